"""Better triangles on flat faces: edges between two of one plane flipped until they are Delaunay.

Faces of few corners come as fans of slivers, and as caps whose third corner lies on their longest
side. Flips within a plane leave the surface as it is (Lawson 1977), and what is split afterwards
has angles that a map can be made on.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from ....mesh.half_edges import edge_keys, ends_of, following, inner_edges, link, previous
from .subdivision import Triangles

# How far the surface may move, in the size of the whole; single precision is that coarse.
FLAT = 2e-7
# Triangles of the smallest flat face: on marching cubes pairs of them lie in a plane by chance, and
# are no better the other way.
FACE = 4
# Radians by which the two angles across from an edge must exceed a half turn.
CLEARLY = 1e-6
# Radians that a cap's wide angle is off a half turn by at most.
CAP = 1e-3
# Rounds, in each of which no two flips share a triangle.
ROUNDS = 100


def flipped(mesh: Triangles) -> Triangles:
    """The mesh with the edges inside of flat faces flipped where that opens angles.

    Edges on features stay but for those that are the longest side of a cap: then the feature runs
    on by the corner that lies on it.
    """
    for _ in range(ROUNDS):
        links = link(mesh.triangles.astype(np.int32), len(mesh.vertices))
        if links is None:
            return mesh
        twin = links.twin.astype(np.int64)
        beyond = np.where(twin >= 0, mesh.feature[twin], np.int8(0))
        mesh = replace(mesh, feature=mesh.feature | beyond)
        half = _independent(*_candidates(mesh, twin), twin, mesh)
        if not len(half):
            return mesh
        mesh = _turned(mesh, half, twin[half])
    return mesh


def _candidates(mesh: Triangles, twin: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The lower half-edges of edges that would flip, and by how much their angles are too wide."""
    half = inner_edges(twin)
    corners = mesh.triangles.ravel()
    a, b = ends_of(mesh.triangles, half)
    c, d = corners[previous(half)], corners[previous(twin[half])]
    at = mesh.vertices
    wide = _angle(at[c], at[a], at[b]), _angle(at[d], at[a], at[b])
    excess = wide[0] + wide[1] - np.pi
    cap = (wide[0] > np.pi - CAP) ^ (wide[1] > np.pi - CAP)
    likely = (excess > CLEARLY) & (c != d) & ((mesh.feature[half] == 0) | cap)
    # The tetrahedron of the four corners is as high as the two edges are far from each other.
    across = np.cross(at[b] - at[a], at[d] - at[c])
    size = np.linalg.norm(across, axis=1)
    flat = np.abs(np.einsum("ec,ec->e", across, at[c] - at[a])) <= FLAT * size
    likely &= flat & _in_faces(half, twin, flat, len(mesh.triangles))
    half, excess = half[likely], excess[likely]
    a, b, c, d = (at[row[likely]] for row in (a, b, c, d))
    here, there = np.cross(b - a, c - a), np.cross(a - b, d - b)
    up = here + there
    made = np.cross(d - a, c - a), np.cross(b - d, c - d)
    flat = np.ones(len(half), bool)
    for normal, least in ((here, -CLEARLY), (there, -CLEARLY), (made[0], 0.0), (made[1], 0.0)):
        along = np.einsum("ec,ec->e", normal, up)
        flat &= along > least * np.einsum("ec,ec->e", up, up)
    return half[flat], excess[flat]


def _in_faces(half: np.ndarray, twin: np.ndarray, flat: np.ndarray, count: int) -> np.ndarray:
    """(e,) bool edges, given by a half-edge each, in flat faces of `FACE` triangles or more, which
    hang together over the edges that are `flat`."""
    one, two = half[flat] // 3, twin[half[flat]] // 3
    graph = sparse.coo_array((np.ones(len(one), np.int8), (one, two)), shape=(count, count))
    _, face = csgraph.connected_components(graph, directed=False)
    size = np.bincount(face, minlength=count)
    return size[face[half // 3]] >= FACE


def _angle(tip: np.ndarray, one: np.ndarray, two: np.ndarray) -> np.ndarray:
    """(e,) the angles at points between two others."""
    a, b = one - tip, two - tip
    sine = np.linalg.norm(np.cross(a, b), axis=1)
    angle: np.ndarray = np.arctan2(sine, np.einsum("ec,ec->e", a, b))
    return angle


def _independent(
    half: np.ndarray, excess: np.ndarray, twin: np.ndarray, mesh: Triangles
) -> np.ndarray:
    """Those of the half-edges that are the worst in both their triangles and make no edge that
    there is already."""
    n = len(mesh.vertices)
    corners = mesh.triangles.ravel()
    made = edge_keys(corners[previous(half)], corners[previous(twin[half])], n)
    known = np.unique(edge_keys(*mesh.ends, n))
    place = np.minimum(np.searchsorted(known, made), len(known) - 1)
    half, excess, made = (part[known[place] != made] for part in (half, excess, made))
    # No two are alike, so that in each triangle one is the worst.
    rank = np.zeros(len(half), np.int64)
    rank[np.lexsort((half, excess))] = np.arange(1, len(half) + 1)
    worst = np.zeros(len(mesh.triangles), np.int64)
    np.maximum.at(worst, half // 3, rank)
    np.maximum.at(worst, twin[half] // 3, rank)
    chosen = np.flatnonzero((worst[half // 3] == rank) & (worst[twin[half] // 3] == rank))
    _, first = np.unique(made[chosen], return_index=True)
    return half[chosen[first]]


def _turned(mesh: Triangles, half: np.ndarray, other: np.ndarray) -> Triangles:
    """The mesh with edges flipped, each given by its two half-edges."""
    corners, feature = mesh.triangles.ravel(), mesh.feature
    a, b = corners[half], corners[other]
    c, d = corners[previous(half)], corners[previous(other)]
    # A feature along the flipped edge goes on by the corner of the cap.
    kind = feature[half]
    at = mesh.vertices
    by_c = _angle(at[c], at[a], at[b]) > _angle(at[d], at[a], at[b])
    none = np.zeros(len(half), np.int8)
    near, far = np.where(by_c, kind, none), np.where(by_c, none, kind)
    triangles, sides = mesh.triangles.copy(), feature.reshape(-1, 3).copy()
    triangles[half // 3] = np.stack([a, d, c], axis=1)
    triangles[other // 3] = np.stack([d, b, c], axis=1)
    sides[half // 3] = np.stack(
        [feature[following(other)] | far, none, feature[previous(half)] | near], axis=1
    )
    sides[other // 3] = np.stack(
        [feature[previous(other)] | far, feature[following(half)] | near, none], axis=1
    )
    return replace(mesh, triangles=triangles, feature=sides.ravel())
