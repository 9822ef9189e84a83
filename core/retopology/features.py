"""What a cross field runs along: creases, edges marked sharp, open borders, and crests.

One set for the field, the files, the marks and the quads. Edges are hard features: creases that go
on as chains, borders, and whatever the user has marked. Where a surface is not sharp at this
resolution its crests pull, the more the farther the normal turns and the surer they are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..mesh.creases import marked_half_edges
from ..mesh.surface import Surface
from .crease_chains import crease_chains
from .ridges.find import CERTAIN, CREST, Ridges
from .settings import GuidanceSettings

BORDER, MARK, CREASE = 0, 1, 2
# What a feature edge is one for, by number; the first that holds.
KINDS = ("border", "mark", "crease")


@dataclass(frozen=True)
class Features:
    """Features of a `Surface`.

    Attributes
    ----------
    half_edge:
        (e,) int64 one half-edge of each hard feature edge, ascending.
    kind:
        (e,) int8 number in `KINDS`.
    chain:
        (e,) int64 chain of creases that the edge is part of, -1 for others.
    crest_vertex:
        (c,) int64 vertices beside crests, each once, ascending; none of them on a hard feature.
    crest_direction:
        (c, 3) float64 unit direction across the crest.
    crest_weight:
        (c,) float64 how much it counts, 0 to 1.
    """

    half_edge: np.ndarray
    kind: np.ndarray
    chain: np.ndarray
    crest_vertex: np.ndarray
    crest_direction: np.ndarray
    crest_weight: np.ndarray


def find_features(
    surface: Surface,
    settings: GuidanceSettings,
    sharp: np.ndarray | None = None,
    ridges: Ridges | None = None,
) -> Features:
    """The features of a surface.

    Parameters
    ----------
    sharp:
        (s, 2) pairs of input vertices whose edges are marked sharp, or None.
    ridges:
        Its ridges, or None to leave crests out.
    """
    kind = np.full(len(surface.twin), -1, np.int8)
    chain = np.full(len(surface.twin), -1)
    if settings.feature_angle < 180.0:
        creases = crease_chains(surface, settings.feature_angle)
        kind[creases.half_edge] = CREASE
        count = np.diff(creases.start)
        chain[creases.half_edge] = np.repeat(np.arange(len(count)), count)
    if settings.align_sharp:
        kind[marked_half_edges(surface, sharp)] = MARK
    if settings.align_borders:
        kind[surface.twin < 0] = BORDER
    hard = np.flatnonzero(kind >= 0)
    on_edge = np.zeros(len(surface.vertices), bool)
    for corner in _ends(surface, hard):
        on_edge[corner] = True
    return Features(
        hard, kind[hard], chain[hard], *_crests(surface, settings.feature_angle, ridges, on_edge)
    )


def _ends(surface: Surface, half_edges: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Tails and heads (e,) of half-edges."""
    return (
        surface.triangles.ravel()[half_edges],
        surface.triangles[:, [1, 2, 0]].ravel()[half_edges],
    )


def _crests(
    surface: Surface, angle: float, ridges: Ridges | None, taken: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vertices (c,) beside crests that bend by `angle` or more and are not `taken` (n,), the
    directions (c, 3) across and the weights (c,)."""
    weight = np.zeros(len(surface.vertices))
    direction = np.zeros((len(weight), 3))
    if ridges is not None and angle < 180.0:
        chains = ridges.chains
        family = np.repeat(chains.family, np.diff(chains.start))
        crest = np.repeat(chains.kind == CREST, np.diff(chains.start)) & (chains.bend >= angle)
        sure = chains.certainty / (chains.certainty + CERTAIN)
        for number in (0, 1):
            rows = np.flatnonzero(crest & (family == number))
            corner = surface.triangles[chains.triangle[rows]]
            heavier = np.zeros(len(weight))
            np.maximum.at(heavier, corner, sure[rows, None])
            better = heavier > weight
            weight[better] = heavier[better]
            direction[better] = ridges.slopes.d[number][better]
    vertex = np.flatnonzero((weight > 0) & ~taken)
    return vertex, direction[vertex], weight[vertex]


def wanted_directions(
    surface: Surface, features: Features, axis: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Which vertices lie on hard features, and the fourth power of their direction there.

    Parameters
    ----------
    axis:
        (3, n) complex tangent frames e1 + i e2.

    Returns
    -------
    hard, wanted:
        (n,) bool and (n,) complex128: the mean over the feature's edges at the vertex, of
        length 1 where they agree up to right angles and near 0 where they do not.
    """
    n = len(surface.vertices)
    total, count = np.zeros(n, complex), np.zeros(n)
    tail, head = _ends(surface, features.half_edge)
    along = surface.vertices[head] - surface.vertices[tail]
    for corner in (tail, head):
        value = fourth_power(axis[:, corner], along)
        total += np.bincount(corner, weights=value.real, minlength=n)
        total += 1j * np.bincount(corner, weights=value.imag, minlength=n)
        count += np.bincount(corner, minlength=n)
    return count > 0, total / np.maximum(count, 1)


def fourth_power(axis: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """(r,) fourth powers of the directions of vectors (r, 3) in the frames `axis` (3, r)."""
    value = np.einsum("cr,rc->r", axis, vectors)
    size = np.abs(value)
    return np.divide(value, size, out=np.zeros_like(value), where=size > 0) ** 4
