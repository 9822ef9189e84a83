"""Edges shorter than single precision tells apart, collapsed.

Booleans and intersections leave vertices one step of their numbers from another, and needles
between them; along creases no flip takes these away, splitting makes strips of them, and no map
unfolds these.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import sparse

from ....base.subsets import places_in
from ....mesh.half_edges import following, link, previous
from .subdivision import Triangles

# The longest edge that is collapsed, in the size of the mesh: three steps of numbers of single
# precision, of which one vertex may be half a diagonal off its place and another as much.
SHORT = 4e-7
# Rounds, in each of which no two of the edges have a triangle in common.
ROUNDS = 100


def without_needles(mesh: Triangles) -> Triangles:
    """The mesh without edges of `SHORT`, as far as its topology allows; features that ran along
    both sides of what goes run along one edge."""
    if not len(mesh.triangles):
        return mesh
    least = SHORT * float(np.ptp(mesh.vertices, axis=0).max())
    lots = np.random.default_rng(0)
    for _ in range(ROUNDS):
        short = mesh.lengths <= least
        if not short.any():
            break
        links = link(mesh.triangles.astype(np.int32), len(mesh.vertices))
        if links is None:
            break
        twin = links.twin.astype(np.int64)
        half = _apart(mesh, _possible(mesh, np.flatnonzero(short), twin), lots)
        if not len(half):
            break
        mesh = _collapsed(mesh, half, twin)
    return mesh


def _possible(mesh: Triangles, half: np.ndarray, twin: np.ndarray) -> np.ndarray:
    """Those of the half-edges, one of each edge, whose collapse keeps the topology: the ends have
    only those neighbours in common that the triangles beside show (Dey et al. 1999), and no edge
    within joins two borders."""
    half = half[(twin[half] < 0) | (half < twin[half])]
    n = len(mesh.vertices)
    tail, head = mesh.ends
    open_ = twin < 0
    border = np.zeros(n, bool)
    border[tail[open_]] = border[head[open_]] = True
    ends = np.concatenate([tail, head[open_]]), np.concatenate([head, tail[open_]])
    beside = sparse.coo_array((np.ones(len(ends[0]), np.int8), ends), shape=(n, n)).tocsr()
    one, two = tail[half], head[half]
    common = np.asarray(beside[one].multiply(beside[two]).sum(axis=1)).ravel()
    inner = twin[half] >= 0
    kept = (common == 1 + inner) & ~(inner & border[one] & border[two])
    # Of the last triangles of a piece none may go.
    around = np.diff(beside.indptr)
    return half[kept & (np.minimum(around[one], around[two]) > 2) & (around[one] + around[two] > 6)]


def _apart(mesh: Triangles, half: np.ndarray, lots: np.random.Generator) -> np.ndarray:
    """Some of the half-edges, whose ends have no neighbours in common with those of others."""
    tail, head = mesh.ends
    n = len(mesh.vertices)
    # By lot (Luby 1986): in the order of their rows many would wait for each other. The first of
    # the edges at each vertex, and the first around.
    first = np.full(n, len(half))
    order = lots.permutation(len(half))
    np.minimum.at(first, tail[half], order)
    np.minimum.at(first, head[half], order)
    for _ in range(2):
        around = first[mesh.triangles].min(axis=1)
        first = first.copy()
        np.minimum.at(first, mesh.triangles.ravel(), np.repeat(around, 3))
    return half[(first[tail[half]] == order) & (first[head[half]] == order)]


def _collapsed(mesh: Triangles, half: np.ndarray, twin: np.ndarray) -> Triangles:
    tail, head = mesh.ends
    sides = np.concatenate([half, twin[half][twin[half] >= 0]])
    feature = mesh.feature.copy()
    # The two other sides of a triangle that goes become one edge.
    one, two = following(sides), previous(sides)
    for here, there in ((one, two), (two, one)):
        beyond = twin[here]
        feature[beyond[beyond >= 0]] |= feature[there[beyond >= 0]]
    on = np.zeros(len(mesh.vertices), np.int64)
    for ends in (tail, head):
        np.add.at(on, ends[(twin < 0) | (mesh.feature > 0)], 1)
    # What lies on more features, or on a border, stays where it is.
    stays = np.where(on[tail[half]] >= on[head[half]], tail[half], head[half])
    goes = tail[half] + head[half] - stays
    row = np.arange(len(mesh.vertices))
    row[goes] = stays
    left = np.ones(len(mesh.triangles), bool)
    left[sides // 3] = False
    triangles = row[mesh.triangles[left]]
    used = np.unique(triangles)
    return replace(
        mesh,
        vertices=mesh.vertices[used],
        triangles=places_in(used, len(mesh.vertices))[triangles].astype(np.int64),
        values=mesh.values[used],
        source=mesh.source[left],
        feature=feature.reshape(-1, 3)[left].ravel(),
    )
