"""Borders that lie on each other: seams that an exporter split, halves that were never merged."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph
from scipy.spatial import cKDTree

from ...base.subsets import places_in
from ...base.unit import unit
from ..half_edges import edge_keys, ends_of, following, previous

# Distance, in the shortest edge at either vertex, within which two border vertices are one. What
# is nearer bends the surface less than noise of a hundredth of an edge, at which umbilics are
# placed to a tenth of one; a slit that narrow shows nothing either.
NEAR = 0.01
# Vertices that are looked at around each: more copies than this meet only in one exact place.
COPIES = 8
# Cosine of the angle between two triangles at an edge above which they lie on each other, sheets
# twice instead of one that goes on: two degrees, less than the sharpest rim.
FOLDED = 0.9994


def border_half_edges(corners: np.ndarray, vertex_count: int) -> np.ndarray:
    """(h,) int64 half-edges of triangles (m, 3) whose edge no other triangle has."""
    keys = edge_keys(*ends_of(corners), vertex_count)
    _, first, count = np.unique(keys, return_index=True, return_counts=True)
    return np.sort(first[count == 1])


def joined_vertices(
    vertices: np.ndarray, corners: np.ndarray, open_edges: np.ndarray
) -> np.ndarray:
    """(n,) int64 for each vertex the first of those that it is one with.

    Only vertices along border edges that coincide, two and two, are joined; where more than two
    meet, or a sheet lies on its own copy, nobody can tell which belong together. Nothing is
    joined where sheets merely touch.

    Parameters
    ----------
    vertices:
        (n, 3) positions.
    corners:
        (m, 3) triangles.
    open_edges:
        (h,) half-edges of these on a border.
    """
    same = np.arange(len(vertices))
    if not len(open_edges):
        return same
    tails, heads = ends_of(corners, open_edges)
    used, both = np.unique(np.concatenate([tails, heads]), return_inverse=True)
    place = _exact_places(vertices[used])
    both = both.reshape(2, -1)
    first, second = _matching(vertices, corners, open_edges, place[both])
    unmatched = np.ones(len(open_edges), bool)
    unmatched[first] = unmatched[second] = False
    pairs = [_ends_at_one_place(place[both], tails, heads, first, second)]
    if unmatched.any():
        rest = np.flatnonzero(unmatched)
        place = _near_places(vertices, corners, used, place, np.unique(both[:, rest]))
        first, second = _matching(vertices, corners, open_edges[rest], place[both[:, rest]])
        first, second = rest[first], rest[second]
        pairs.append(_ends_at_one_place(place[both], tails, heads, first, second))
    one, other = np.concatenate(pairs, axis=1)
    apart = one != other
    if not apart.any():
        return same
    graph = sparse.coo_array(
        (np.ones(int(apart.sum()), np.int8), (one[apart], other[apart])),
        shape=(len(vertices), len(vertices)),
    )
    _, label = csgraph.connected_components(graph, directed=False)
    _, first = np.unique(label, return_index=True)
    return first[label]


def _exact_places(points: np.ndarray) -> np.ndarray:
    """(u,) number of the place of each point (u, 3): equal where all coordinates are."""
    order = np.lexsort(points.T)
    ranked = points[order]
    new = np.ones(len(points), np.int64)
    new[1:] = (ranked[1:] != ranked[:-1]).any(axis=1)
    place = np.empty(len(points), np.int64)
    place[order] = np.cumsum(new) - 1
    return place


def _near_places(
    vertices: np.ndarray,
    corners: np.ndarray,
    used: np.ndarray,
    place: np.ndarray,
    asked: np.ndarray,
) -> np.ndarray:
    """(u,) places of the vertices `used` (u,), those of `asked` one where they are `NEAR`."""
    _, representative = np.unique(place[asked], return_index=True)
    representative = asked[representative]
    points = vertices[used[representative]]
    reach = NEAR * _shortest_edges(vertices, corners, used)[representative]
    widest = float(reach.max(initial=0.0))
    if len(points) < 2 or widest == 0.0:
        return place
    distance, other = cKDTree(points).query(
        points, k=range(2, 2 + COPIES), distance_upper_bound=np.nextafter(widest, np.inf)
    )
    row, column = np.nonzero(np.isfinite(distance))
    other = other[row, column]
    near = distance[row, column] <= np.minimum(reach[row], reach[other])
    count = int(place.max()) + 1
    row, other = place[representative[row[near]]], place[representative[other[near]]]
    graph = sparse.coo_array((np.ones(len(row), np.int8), (row, other)), shape=(count, count))
    return csgraph.connected_components(graph, directed=False)[1][place]


def _shortest_edges(vertices: np.ndarray, corners: np.ndarray, used: np.ndarray) -> np.ndarray:
    """(u,) length of the shortest edge at each vertex of `used` (u,), ascending."""
    row = places_in(used, len(vertices))
    touching = corners[(row[corners] >= 0).any(axis=1)]
    shortest = np.full(len(used), np.inf)
    for corner in range(3):
        a, b = touching[:, corner], touching[:, (corner + 1) % 3]
        length = np.linalg.norm(vertices[b] - vertices[a], axis=1)
        for end in (row[a], row[b]):
            np.minimum.at(shortest, end[end >= 0], length[end >= 0])
    return shortest


def _matching(
    vertices: np.ndarray, corners: np.ndarray, open_edges: np.ndarray, ends: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Rows of the border edges that coincide two and two, by the places of their `ends` (2, h)."""
    low, high = ends.min(axis=0), ends.max(axis=0)
    edge = np.flatnonzero(low < high)
    keys = low[edge] * (int(ends.max(initial=0)) + 1) + high[edge]
    order = np.argsort(keys, kind="stable")
    _, begin, count = np.unique(keys[order], return_index=True, return_counts=True)
    begin = begin[count == 2]
    first, second = edge[order[begin]], edge[order[begin + 1]]
    one, other = (_away(vertices, corners, open_edges[rows]) for rows in (first, second))
    cosine = np.einsum("ec,ec->e", one, other)
    return first[cosine < FOLDED], second[cosine < FOLDED]


def _away(vertices: np.ndarray, corners: np.ndarray, half_edges: np.ndarray) -> np.ndarray:
    """(e, 3) unit vectors from half-edges to the third corner, square to them; zero without
    area."""
    flat = corners.ravel()
    tail = vertices[flat[half_edges]]
    along = vertices[flat[following(half_edges)]] - tail
    apex = vertices[flat[previous(half_edges)]] - tail
    square = np.einsum("ec,ec->e", along, along)
    share = np.einsum("ec,ec->e", apex, along) / np.where(square > 0, square, 1.0)
    return unit(apex - share[:, None] * along)


def _ends_at_one_place(
    ends: np.ndarray, tails: np.ndarray, heads: np.ndarray, first: np.ndarray, second: np.ndarray
) -> np.ndarray:
    """(2, 2 e) the vertices of matching border edges that lie in one place."""
    alike = ends[0, first] == ends[0, second]
    at_tail = np.where(alike, tails[second], heads[second])
    at_head = np.where(alike, heads[second], tails[second])
    return np.stack(
        [np.concatenate([tails[first], heads[first]]), np.concatenate([at_tail, at_head])]
    )
