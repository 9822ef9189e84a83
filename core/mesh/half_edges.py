"""Half-edges of a triangle mesh: twins, fans around vertices, and the one-ring graph.

Half-edge 3 t + k runs from corner k of triangle t to corner k + 1, and also names that corner.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from ..base.parallel import run
from ..base.progress import Progress

# Half-edges, or vertices, that one thread looks at: fewer are not worth a thread.
PART = 1 << 17
# Corners around a vertex up to which fans are walked, a step of all vertices at once.
LONG = 64


@dataclass(frozen=True)
class HalfEdges:
    """Links between half-edges of an oriented mesh of n vertices and m triangles.

    Attributes
    ----------
    twin:
        (3 m,) int32 the same edge in the neighbouring triangle, -1 on a border.
    leaving:
        (n,) int32 a half-edge that starts at each vertex, -1 at vertices without a triangle.
    corner_count:
        (n,) int32 corners at each vertex.
    neighbour_start, neighbours:
        The one-ring graph of the vertices, see `Surface`.
    """

    twin: np.ndarray
    leaving: np.ndarray
    corner_count: np.ndarray
    neighbour_start: np.ndarray
    neighbours: np.ndarray


def link(triangles: np.ndarray, vertex_count: int) -> HalfEdges | None:
    """Link the half-edges of (m, 3) triangles; None if two of them run the same way."""
    m = len(triangles)
    tails, heads = ends_of(triangles)
    ends = (tails, heads), (heads, tails)
    graphs: dict[int, sparse.csr_array] = {}
    together = 1 if m > PART else 2

    def direct(first: int) -> None:
        for way in range(first, first + together):
            rows, columns = ends[way]
            graphs[way] = _by_row(rows, columns, vertex_count)

    run(direct, range(0, 2, together), Progress())
    forward, backward = graphs[0], graphs[1]
    if not forward.has_canonical_format:
        return None
    corner_count = np.diff(forward.indptr)
    leaving = np.full(vertex_count, -1, np.int32)
    used = corner_count > 0
    leaving[used] = forward.data[forward.indptr[:-1][used]]
    if np.array_equal(forward.indptr, backward.indptr) and np.array_equal(
        forward.indices, backward.indices
    ):
        # Without a border every edge has both directions, in the same places.
        twin = np.empty(3 * m, np.int32)

        def pair(first: int) -> None:
            some = slice(first, first + PART)
            twin[forward.data[some]] = backward.data[some]

        run(pair, range(0, 3 * m, PART), Progress())
        return HalfEdges(twin, leaving, corner_count, forward.indptr, forward.indices)
    # One sum aligns both directions of every edge: the low half names the half-edge from row
    # to column, counted from 1, the high half the one that comes back.
    forward.data = forward.data.astype(np.int64) + 1
    backward.data = (backward.data.astype(np.int64) + 1) << 32
    both = forward + backward
    out = (both.data & 0xFFFFFFFF) - 1
    back = (both.data >> 32) - 1
    twin = np.full(3 * m + 1, -1, np.int32)
    twin[out] = back  # half-edges that do not exist are named -1 and land in the spare slot
    return HalfEdges(twin[:-1], leaving, corner_count, both.indptr, both.indices)


def _by_row(rows: np.ndarray, columns: np.ndarray, vertex_count: int) -> sparse.csr_array:
    """The entries at `rows` and `columns` (e,), numbered in their order, row by row with rising
    columns; its format is not canonical if several are in one place."""
    names = np.arange(len(rows), dtype=np.int32)
    graph = sparse.coo_array((names, (rows, columns)), shape=(vertex_count, vertex_count))
    graph.has_canonical_format = True  # or entries in one place would be summed
    found = graph.tocsr()
    found.sort_indices()
    return found


def following(half_edges: np.ndarray) -> np.ndarray:
    """The half-edge after each one in its triangle."""
    return np.where(half_edges % 3 == 2, half_edges - 2, half_edges + 1)


def previous(half_edges: np.ndarray) -> np.ndarray:
    """The half-edge before each one in its triangle."""
    return np.where(half_edges % 3 == 0, half_edges + 2, half_edges - 1)


def ends_of(
    triangles: np.ndarray, half_edges: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """(h,) the vertices that half-edges (h,), or all (3 m,), of triangles (m, 3) come from and go
    to."""
    corners = triangles.ravel()
    if half_edges is None:
        return corners, np.concatenate([triangles[:, 1:], triangles[:, :1]], axis=1).ravel()
    return corners[half_edges], corners[following(half_edges)]


def edge_keys(one: np.ndarray, other: np.ndarray, count: int) -> np.ndarray:
    """(e,) int64 a number for each edge between two of `count` vertices, whichever end is first:
    least * count + greatest."""
    least = np.minimum(one, other, dtype=np.int64)
    return np.asarray(least * count + np.maximum(one, other))


def inner_edges(twin: np.ndarray) -> np.ndarray:
    """(e,) int64 the lower half-edge of each edge that two triangles share, ascending."""
    return np.flatnonzero(np.arange(len(twin), dtype=twin.dtype) < twin)


def all_edges(twin: np.ndarray) -> np.ndarray:
    """(e,) int64 a half-edge of each edge, of two the lower, ascending."""
    return np.flatnonzero((twin < 0) | (np.arange(len(twin), dtype=twin.dtype) < twin))


def _next_around(twin: np.ndarray) -> np.ndarray:
    """(3 m,) the corner that follows each one around its vertex, -1 at the end of an open fan."""
    step = np.empty((len(twin) // 3, 3), twin.dtype)
    for corner in range(3):
        step[:, corner] = twin[(corner + 2) % 3 :: 3]
    return step.ravel()


def has_pinched_vertex(triangles: np.ndarray, links: HalfEdges) -> bool:
    """Whether several fans of triangles touch at some vertex of (m, 3) triangles.

    One fan is walked around every vertex, all together; it must have as many corners as there
    are at the vertex. The few vertices of long fans are left out of that, and their fans counted.
    """
    step = _next_around(links.twin)
    first = links.leaving.copy()
    openings = np.flatnonzero(links.twin < 0)
    first[triangles.ravel()[openings]] = openings
    pinched: list[int] = []
    crowded: list[int] = []

    def walk(low: int) -> None:
        walking = low + np.flatnonzero(first[low : low + PART] >= 0)
        begin = current = first[walking]
        length = 0
        while len(walking) and length < LONG and not pinched:
            length += 1
            current = step[current]
            going = (current >= 0) & (current != begin)
            if not going.all():
                if (links.corner_count[walking[~going]] != length).any():
                    pinched.append(low)
                walking, begin, current = walking[going], begin[going], current[going]
        crowded.extend(walking)

    run(walk, range(0, len(first), PART), Progress())
    if pinched or not crowded:
        return bool(pinched)
    inside = np.zeros(len(first), bool)
    inside[crowded] = True
    return _fan_count(triangles, step, inside) > len(crowded)


def _fan_count(triangles: np.ndarray, step: np.ndarray, inside: np.ndarray) -> int:
    """How many fans of triangles there are around the vertices that are `inside` (n,) bool, by the
    `step` (3 m,) from corner to corner."""
    corners = np.flatnonzero(inside[triangles.ravel()])
    joined = np.flatnonzero(step[corners] >= 0)
    following = np.searchsorted(corners, step[corners[joined]])
    ones, shape = np.ones(len(joined), np.int8), (len(corners), len(corners))
    graph = sparse.coo_array((ones, (joined, following)), shape=shape)
    return int(csgraph.connected_components(graph, directed=False)[0])


def fan_labels(twin: np.ndarray) -> np.ndarray:
    """(3 m,) label of the fan of triangles that each corner lies in: equal around a vertex.

    The fan is followed from corner to corner across shared edges; its label is the smallest
    corner in it, and negative (corner - 3 m of its last corner) where the fan is open.
    """
    count = len(twin)
    corners = np.arange(count, dtype=np.int32)
    step = _next_around(twin)
    last = step < 0
    step = np.where(last, corners, step)
    labels = np.where(last, corners - np.int32(count), corners)
    # Doubling the step covers a fan of 2^k corners in k rounds.
    while True:
        lower = np.minimum(labels, labels[step])
        if np.array_equal(lower, labels):
            return labels
        labels = lower
        step = step[step]
