"""Cutting a surface with crosses to a disk, on which one direction of all crosses agrees."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from ....mesh.half_edges import following
from ..field.crosses import QUARTER, Crosses


@dataclass(frozen=True)
class Seams:
    """A cut through all poles of a `Crosses`, open to a disk.

    Attributes
    ----------
    comb:
        (m,) int64 quarter turns that bring each triangle's direction to agree with its
        neighbours' within the disk.
    cut:
        (3 m,) bool half-edges on the cut.
    matching:
        (3 m,) int64 quarter turns between combed coordinates, 0 to 3, and 0 off the cut.
    sheet:
        (m, 3) int64 copy of the vertex at each corner: one for each side of the cut.
    count:
        How many copies there are.
    axis:
        (3 m,) int64 0 where a feature runs along the real axis of its triangle, 1 where along
        the imaginary one, -1 off features.
    """

    comb: np.ndarray
    cut: np.ndarray
    matching: np.ndarray
    sheet: np.ndarray
    count: int
    axis: np.ndarray


def seams(crosses: Crosses) -> Seams:
    """Cut along the edges that a spanning tree of triangles leaves, less what dangles."""
    twin, inner = crosses.twin, crosses.inner
    m = len(crosses.triangles)
    comb, tree = _combed(crosses)
    cut = np.zeros(3 * m, bool)
    cut[inner] = True
    cut[tree] = cut[twin[tree]] = False
    keep = crosses.border | (crosses.quarter_turns != 4)
    _shorten(crosses, cut, keep)
    matching = np.zeros(3 * m, np.int64)
    edge = np.flatnonzero(cut)
    face = edge // 3
    matching[edge] = (crosses.matching[edge] + comb[face] - comb[twin[edge] // 3]) % 4
    across = inner[~cut[inner]]
    rows = np.concatenate([across, following(across)])
    columns = np.concatenate([following(twin[across]), twin[across]])
    graph = sparse.coo_array((np.ones(len(rows)), (rows, columns)), shape=(3 * m, 3 * m))
    count, sheet = csgraph.connected_components(graph, directed=False)
    axis = _axes(crosses, comb)
    return Seams(comb, cut, matching, sheet.reshape(-1, 3).astype(np.int64), int(count), axis)


def _combed(crosses: Crosses) -> tuple[np.ndarray, np.ndarray]:
    """(m,) turns of each triangle, and the half-edges of the spanning tree they follow.

    Combed coordinates are those of the triangle times i to the power of minus its turns.
    """
    inner, twin = crosses.inner, crosses.twin
    m = len(crosses.triangles)
    # Breadth first, so that the cut that is left runs between the poles on short ways.
    graph = sparse.coo_array((inner + 1, (inner // 3, twin[inner] // 3)), shape=(m, m)).tocsr()
    order, parent = csgraph.breadth_first_order(graph, 0)
    child = order[1:]
    tree = np.asarray(graph[parent[child], child]).ravel().astype(np.int64) - 1
    # Two triangles that share two edges have the sum of both names: take the first edge then.
    wrong = (tree >= 3 * m) | (twin[np.minimum(tree, 3 * m - 1)] // 3 != child)
    for row in np.flatnonzero(wrong):
        sides = 3 * parent[child[row]] + np.arange(3)
        tree[row] = sides[twin[sides] // 3 == child[row]][0]
    comb = np.zeros(m, np.int64)
    turn = crosses.matching[tree]
    for one, up, by in zip(child.tolist(), parent[child].tolist(), turn.tolist(), strict=True):
        comb[one] = comb[up] + by
    return comb % 4, tree


def _shorten(crosses: Crosses, cut: np.ndarray, keep: np.ndarray) -> None:
    """Take ends of the cut that lead nowhere away, in place."""
    twin, tail, head = crosses.twin, crosses.tail, crosses.head
    n = len(crosses.vertices)
    edge = np.flatnonzero(cut)
    degree = np.bincount(tail[edge], minlength=n)
    loose = np.flatnonzero((degree == 1) & ~keep)
    order = edge[np.argsort(tail[edge], kind="stable")]
    start = np.concatenate([[0], np.cumsum(degree)])
    stack = loose.tolist()
    while stack:
        vertex = stack.pop()
        if degree[vertex] != 1:
            continue
        for out in order[start[vertex] : start[vertex + 1]]:
            if cut[out]:
                cut[out] = cut[twin[out]] = False
                other = head[out]
                degree[vertex] -= 1
                degree[other] -= 1
                if degree[other] == 1 and not keep[other]:
                    stack.append(other)


def _axes(crosses: Crosses, comb: np.ndarray) -> np.ndarray:
    """(3 m,) the axis that each feature half-edge runs along in combed coordinates."""
    feature = np.flatnonzero(crosses.feature)
    axis = np.full(len(crosses.twin), -1)
    face, side = feature // 3, feature % 3
    along = crosses.corner[face, (side + 1) % 3] - crosses.corner[face, side]
    axis[feature] = (np.rint(np.angle(along) / QUARTER).astype(np.int64) + comb[face]) % 2
    # Both sides of an edge must agree: the lower half-edge decides.
    other = crosses.twin[feature]
    upper = feature[(other >= 0) & (other < feature)]
    lower = crosses.twin[upper]
    across = crosses.matching[lower] + comb[lower // 3] - comb[upper // 3]
    axis[upper] = (axis[lower] + across) % 2
    return axis
