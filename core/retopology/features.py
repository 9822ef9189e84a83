"""What a cross field runs along: creases, edges marked sharp, open borders, and crests.

One set for the field, the files, the marks and the quads. Edges are hard features: creases that go
on as chains, borders, and whatever the user has marked. Where a surface is not sharp at this
resolution its crests pull, the more the farther the normal turns and the surer they are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph
from scipy.spatial import cKDTree

from ..mesh.creases import marked_half_edges
from ..mesh.half_edges import ends_of
from ..mesh.surface import Surface
from ..mesh.tessellated import flat_edges
from .crease_chains import crease_chains
from .lines.truncation import Barriers
from .ridges.find import CERTAIN, CREST, Chains, Ridges
from .settings import GuidanceSettings

# How far the samples of a fit reach, in root mean square distances.
FIT_EXTENT = 1.5
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
        (c,) int64 vertices beside crests, each once, ascending; none of them near a hard feature.
    crest_direction:
        (c, 3) float64 unit direction across the crest.
    crest_weight:
        (c,) float64 how much it counts, 0 to 1, by how sure the crest is.
    """

    half_edge: np.ndarray
    kind: np.ndarray
    chain: np.ndarray
    crest_vertex: np.ndarray
    crest_direction: np.ndarray
    crest_weight: np.ndarray

    @property
    def hard(self) -> Features:
        """The same without crests."""
        none = self.crest_vertex[:0], self.crest_direction[:0], self.crest_weight[:0]
        return Features(self.half_edge, self.kind, self.chain, *none)


def find_features(
    surface: Surface,
    settings: GuidanceSettings,
    sharp: np.ndarray | None = None,
    ridges: Ridges | None = None,
    shortest: float = 0.0,
) -> Features:
    """The features of a surface.

    Parameters
    ----------
    sharp:
        (s, 2) pairs of input vertices whose edges are marked sharp, or None.
    ridges:
        Its ridges, or None to leave crests out.
    shortest:
        Least length of a crest, in the coordinates of the surface.
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
    crests = _crests(surface, hard, ridges, shortest)
    return Features(hard, kind[hard], chain[hard], *crests)


def between_features(surface: Surface, features: Features) -> np.ndarray:
    """(m,) bool triangles with all corners on hard features: no vertex is of their face alone."""
    on = np.zeros(len(surface.vertices), bool)
    for end in ends_of(surface.triangles, features.half_edge):
        on[end] = True
    return np.asarray(on[surface.triangles].all(axis=1))


def flat_faces(surface: Surface, features: Features) -> np.ndarray:
    """(m,) bool triangles of flat faces without a vertex inside, which have no directions.

    Fits at the vertices of their outlines see the faces beyond, and what lies between these is
    chance. A face is what goes on over flat edges: up to features all around, or over more than the
    two triangles of a facet of a round face, which the face may run into without a crease.
    """
    found = between_features(surface, features)
    twin, own = surface.twin, np.arange(len(surface.twin)) // 3
    other = np.where(twin >= 0, twin // 3, own)
    edges = np.flatnonzero((own < other) & found[own] & found[other])
    flat = edges[flat_edges(surface, edges)]
    m = len(found)
    graph = sparse.coo_array((np.ones(len(flat), np.int8), (own[flat], other[flat])), shape=(m, m))
    face = csgraph.connected_components(graph, directed=False)[1]
    closed = np.zeros(len(twin), bool)
    for half in (flat, features.half_edge):
        closed[half] = True
        closed[twin[half][twin[half] >= 0]] = True
    enclosed = np.bincount(face, ~closed.reshape(-1, 3).all(axis=1))[face] == 0
    return found & (enclosed | (np.bincount(face)[face] > 2))


def barriers(features: Features, crests: Chains) -> Barriers:
    """Edges of features and crests, as what lines may end on."""
    # The chord that ends at a point lies in its triangle.
    before = np.arange(len(crests.position)) - 1
    first, last = crests.start[:-1], crests.start[1:] - 1
    before[first[crests.closed]] = last[crests.closed]
    rows = np.ones(len(before), bool)
    rows[first[~crests.closed]] = False
    position = crests.position
    return Barriers(
        features.half_edge, crests.triangle[rows], position[before[rows]], position[rows]
    )


def _crests(
    surface: Surface, hard: np.ndarray, ridges: Ridges | None, shortest: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vertices (c,) beside long crests away from hard features, the directions (c, 3) across and
    the weights (c,)."""
    weight = np.zeros(len(surface.vertices))
    direction = np.zeros((len(weight), 3))
    if ridges is None:
        return np.zeros(0, np.int64), direction[:0], weight[:0]
    chains = ridges.chains
    chord = np.linalg.norm(np.diff(chains.position, axis=0, prepend=0.0), axis=1)
    chord[chains.start[:-1]] = 0.0
    line = np.repeat(np.arange(len(chains)), np.diff(chains.start))
    length = np.bincount(line, weights=chord, minlength=len(chains))
    crest = ((chains.kind == CREST) & (length >= shortest))[line]
    sure = chains.certainty / (chains.certainty + CERTAIN)
    for family in (0, 1):
        rows = np.flatnonzero(crest & (chains.family[line] == family))
        heaviest = np.zeros(len(weight))
        np.maximum.at(heaviest, surface.triangles[chains.triangle[rows]], sure[rows, None])
        better = heaviest > weight
        weight[better] = heaviest[better]
        direction[better] = ridges.slopes.d[family][better]
    vertex = np.flatnonzero(weight)
    if len(hard):
        # A fit that reaches over a sharp edge says nothing of directions beside it.
        edge = np.unique(np.concatenate(ends_of(surface.triangles, hard)))
        distance, _ = cKDTree(surface.vertices[edge]).query(surface.vertices[vertex])
        vertex = vertex[distance > FIT_EXTENT * ridges.slopes.radius[vertex]]
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
    tail, head = ends_of(surface.triangles, features.half_edge)
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
