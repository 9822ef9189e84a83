"""Parting quads that pass through each other where the surface does not.

Two sheets nearer together than their quads bend can cross although all vertices lie on the
surface: a side of length s dips s^2 k / 8 below a curvature k. No move along the surface mends
that; the quads go apart along the normals, by about as much as they dip.
"""

from __future__ import annotations

import numpy as np

from ....base.progress import Progress
from ....base.unit import unit
from .faults.crossings import OwnCrossings, crossings
from .faults.mending import against
from .faults.unfolding import own_quality, to_stop
from .guides import vertex_normals
from .projection import ClosestPoints

# Rounds, and the way in each by the mean side of the quads that cross.
ROUNDS, STEP = 16, 0.02


def parted(
    position: np.ndarray, quads: np.ndarray, held: np.ndarray, own: OwnCrossings, progress: Progress
) -> np.ndarray:
    """Positions (n, 3) of quads (q, 4) with fewer crossings, none where that can be.

    Parameters
    ----------
    position:
        In the coordinates of the input.
    held:
        (n,) bool vertices that stay.
    own:
        Those of the input; where it crosses itself nothing is parted.
    """
    pairs = made_crossings(position, quads, own)
    if not len(pairs):
        return position
    whole = own.surface
    vertices = whole.vertices * whole.unit + whole.origin
    closest = ClosestPoints(vertices, whole.triangles, whole.twin)
    best, least = position, len(pairs)
    for number in range(ROUNDS):
        progress.step(number / ROUNDS)
        moved = _apart(position, quads, held, pairs, closest)
        position = without_folds(moved, position, quads, closest)
        pairs = made_crossings(position, quads, own)
        if len(pairs) < least:
            best, least = position, len(pairs)
        if not len(pairs):
            break
    return best


def without_folds(
    moved: np.ndarray,
    position: np.ndarray,
    quads: np.ndarray,
    surface: ClosestPoints | None = None,
) -> np.ndarray:
    """What was moved, but for the vertices of quads that would fold by it or, where there is a
    surface, face against it."""
    sound = own_quality(position, quads) > 0.0
    facing = np.zeros(len(quads), bool)
    if surface is not None:
        facing = ~against(position, quads, surface)
    while True:
        folded = sound & (own_quality(moved, quads) <= 0.0)
        if surface is not None:
            folded |= facing & against(moved, quads, surface)
        stuck = to_stop(folded, (moved != position).any(axis=1), quads)
        if not stuck.any():
            return moved
        moved = np.where(stuck[:, None], position, moved)


def _apart(
    position: np.ndarray,
    quads: np.ndarray,
    held: np.ndarray,
    pairs: np.ndarray,
    closest: ClosestPoints,
) -> np.ndarray:
    """Positions one step farther from each other where the pairs are."""
    normal = unit(vertex_normals(position, quads))
    at = position[quads[pairs]]
    side = np.linalg.norm(np.roll(at, -1, axis=2) - at, axis=3).mean(axis=(1, 2))
    up = normal[quads[pairs]].sum(axis=2)
    below = [closest.below(at[:, k].mean(axis=1), up[:, k])[1] for k in range(2)]
    # With the solid between them quads go outwards, with a gap between them inwards.
    between = np.einsum("pc,pc->p", below[1] - below[0], up[:, 0] - up[:, 1])
    way = STEP * side * np.where(between > 0.0, -1.0, 1.0)
    most, least = np.zeros(len(position)), np.zeros(len(position))
    corners = quads[pairs].reshape(len(pairs), 8)
    np.maximum.at(most, corners, way[:, None])
    np.minimum.at(least, corners, way[:, None])
    move = np.where(held, 0.0, most + least)
    return position + move[:, None] * normal


def made_crossings(position: np.ndarray, quads: np.ndarray, own: OwnCrossings) -> np.ndarray:
    """(p, 2) int64 pairs of quads that cross where the triangles of the input do not.

    `position` (n, 3) is in the coordinates of the input.
    """
    pairs = crossings(position, quads)
    if not len(pairs):
        return pairs
    at = position[quads[pairs]].reshape(len(pairs), 8, 3)
    centre = at.mean(axis=1)
    reach = np.linalg.norm(at - centre[:, None], axis=2).max(axis=1)
    return pairs[~own.beside(centre, reach)]
