"""Opening folded and flat quads: their vertices and those around move together until every corner
is well open.

The neighbourhoods of bad quads are opened in the tangent planes of their vertices, those on
features along them.
"""

from __future__ import annotations

import numpy as np

from ....base.progress import Progress
from ....base.subsets import places_in
from ....base.unit import unit
from ....mesh.rings import with_rings
from ..conformity import scaled_jacobian
from .guides import Guides, moved_along, surface_axes, vertex_normals
from .opening import WANTED, Opening

# A quad is bad below this scaled Jacobian.
SOUND = 0.6
# How much a move by the mean side costs beside a corner that misses all.
STAY = 0.02
# Rounds, and rings around bad quads that move in the first and the most.
ROUNDS, FIRST_RINGS, MOST_RINGS = 10, 2, 5
# A round's move is halved so often while it makes things worse.
HALVINGS = 3


def mend(position: np.ndarray, quads: np.ndarray, guides: Guides, progress: Progress) -> None:
    """Move the vertices around bad quads, in place, while that makes them better."""
    movable = ~guides.fixed & ((guides.curve < 0) | (guides.beside >= 0).all(axis=1))
    rings = FIRST_RINGS
    for _ in range(ROUNDS):
        progress.step(1.0)
        quality = oriented_quality(position, quads, guides)
        bad = quality < SOUND
        if not bad.any():
            return
        near = np.zeros(len(position), bool)
        near[quads[bad]] = True
        near = with_rings(quads, near, rings)
        rows = np.flatnonzero(near & movable)
        mine = np.flatnonzero(near[quads].any(axis=1))
        if not len(rows):
            return
        some = quads[mine]
        up = surface_axes(position[some], vertex_normals(position, quads)[some], guides)
        local = places_in(rows, len(position))[some]
        axes = _axes(position, quads, guides, rows)
        step = Opening(position[some], up, local, axes, STAY).step()
        if not _applied(position, quads[mine], guides, rows, step):
            if rings == MOST_RINGS:
                return
            rings = MOST_RINGS


def oriented_quality(position: np.ndarray, quads: np.ndarray, guides: Guides) -> np.ndarray:
    """(q,) scaled Jacobians, negative where a quad faces against the surface; where this may be
    thin, where no part of it within half of a side faces as the quad does."""
    at = position[quads]
    normal = np.cross(at[:, 2] - at[:, 0], at[:, 3] - at[:, 1])
    around = vertex_normals(position, quads)[quads].sum(axis=1)
    middle = at.mean(axis=1)
    triangle, _ = guides.surface(middle, around)
    against = np.einsum("qc,qc->q", guides.surface.normal[triangle], normal) < 0.0
    # A quad that is turned against those around is turned in any way.
    rows = np.flatnonzero(against & (np.einsum("qc,qc->q", around, normal) > 0.0))
    if guides.thin and len(rows):
        side = np.linalg.norm(np.roll(at[rows], -1, axis=1) - at[rows], axis=2)
        against[rows] = ~guides.surface.faced(middle[rows], normal[rows], 0.5 * side.max(axis=1))
    quality = scaled_jacobian(position, quads)
    return np.where(against, -np.abs(quality) - 1e-6, quality)


def _applied(
    position: np.ndarray, quads: np.ndarray, guides: Guides, rows: np.ndarray, step: np.ndarray
) -> bool:
    """Move the vertices by the step or a part of it, in place, if that is better at all."""
    before = position[rows]
    missing = _missing(position, quads, guides)
    for halving in range(HALVINGS):
        position[rows] = moved_along(before, step * 0.5**halving, rows, position, quads, guides)
        if _missing(position, quads, guides) < missing:
            return True
        position[rows] = before
    return False


def _missing(position: np.ndarray, quads: np.ndarray, guides: Guides) -> float:
    quality = oriented_quality(position, quads, guides)
    return float((np.maximum(WANTED - quality, 0.0) ** 2).sum())


def _axes(
    position: np.ndarray, quads: np.ndarray, guides: Guides, rows: np.ndarray
) -> np.ndarray:
    """(r, 2, 3) directions in which vertices may move, the second 0 on features."""
    normal = unit(vertex_normals(position, quads)[rows])
    least = np.eye(3)[np.abs(normal).argmin(axis=1)]
    x = unit(np.cross(normal, least))
    y = np.cross(normal, x)
    held = np.flatnonzero(guides.curve[rows] >= 0)
    ends = position[guides.beside[rows[held]]]
    x[held] = unit(ends[:, 1] - ends[:, 0])
    y[held] = 0.0
    return np.stack([x, y], axis=1)
