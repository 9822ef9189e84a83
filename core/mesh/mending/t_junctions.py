"""T-junctions: border vertices that lie inside a border edge, which does not know them."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from ..half_edges import ends_of, following, previous
from .coincident import NEAR, border_half_edges

# Halvings of an edge after which its pieces are shorter than the distance that counts.
HALVINGS = 8


def split_at_junctions(
    vertices: np.ndarray, corners: np.ndarray, rows: np.ndarray, open_edges: np.ndarray
) -> tuple[np.ndarray, np.ndarray, int]:
    """Insert border vertices that lie on border edges into the triangles of these.

    A triangle becomes two, which meet at the vertex; with many vertices on its edges it is
    halved again and again, so that the rounds are as the logarithm of their number.

    Parameters
    ----------
    vertices:
        (n, 3) positions.
    corners, rows:
        (m, 3) triangles and (m,) what to call each; parts are called as their whole.
    open_edges:
        (h,) half-edges of the triangles on a border.

    Returns
    -------
    corners, rows:
        With the parts in place of the triangles that were split, in the same order.
    count:
        How many vertices were inserted.
    """
    count = 0
    while True:
        half_edge, vertex = _junctions(vertices, corners, open_edges)
        # One side of a triangle at a time.
        _, first = np.unique(half_edge // 3, return_index=True)
        half_edge, vertex = half_edge[first], vertex[first]
        if not len(half_edge):
            return corners, rows, count
        count += len(half_edge)
        flat, triangle = corners.ravel(), half_edge // 3
        a, b, c = flat[half_edge], flat[following(half_edge)], flat[previous(half_edge)]
        parts = np.repeat(np.arange(len(corners)), 1 + np.isin(np.arange(len(corners)), triangle))
        second = np.append(False, parts[1:] == parts[:-1])
        corners, rows = corners[parts], rows[parts]
        corners[np.flatnonzero(second) - 1] = np.stack([a, vertex, c], axis=1)
        corners[second] = np.stack([vertex, b, c], axis=1)
        open_edges = border_half_edges(corners, len(vertices))


def _junctions(
    vertices: np.ndarray, corners: np.ndarray, open_edges: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Border half-edges, ascending, and for each a border vertex inside it, near its middle.

    The vertex must have a border edge along the other one: what only touches is no junction.
    """
    nothing = np.zeros(0, np.int64), np.zeros(0, np.int64)
    flat = corners.ravel()
    tails, heads = ends_of(corners, open_edges)
    border = np.unique(np.concatenate([tails, heads]))
    if len(border) < 3:
        return nothing
    points, first = np.unique(vertices[border], axis=0, return_index=True)
    at = border[first]
    if len(points) < 3:
        return nothing
    # Any border edge out of and into each place.
    place = np.full(len(vertices), -1)
    place[border] = cKDTree(points).query(vertices[border])[1]
    beside = np.zeros((2, len(points)), np.int64)
    beside[0, place[tails]], beside[1, place[heads]] = heads, tails
    tree = cKDTree(points)
    start, along = vertices[tails], vertices[heads] - vertices[tails]
    length = np.linalg.norm(along, axis=1)
    apex = vertices[flat[previous(open_edges)]]

    def off(edge: np.ndarray, point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Share of the way along edges at which points lie, and how far beside them, in edges."""
        offset = point - start[edge]
        square = np.maximum(length[edge] ** 2, np.finfo(float).tiny)
        share = np.einsum("ec,ec->e", offset, along[edge]) / square
        away = np.linalg.norm(offset - share[:, None] * along[edge], axis=1)
        return share, away / np.maximum(length[edge], np.finfo(float).tiny)

    found = np.full(len(open_edges), -1)
    edge = np.flatnonzero(length > 0)
    low, width = np.zeros(len(edge)), 1.0
    for _ in range(HALVINGS):
        # The two ends of the edge, and the nearest that is neither.
        middle = low + 0.5 * width
        asked = start[edge] + middle[:, None] * along[edge]
        distance, near = tree.query(asked, k=3)
        own = (near == place[tails[edge]][:, None]) | (near == place[heads[edge]][:, None])
        pick = own.argmin(axis=1)
        every = np.arange(len(edge))
        distance, near = distance[every, pick], near[every, pick]
        share, away = off(edge, points[near])
        inside = (away <= NEAR) & (share > NEAR) & (share < 1.0 - NEAR)
        inside &= (points[near] != apex[edge]).any(axis=1)
        goes_on = np.zeros(len(edge), bool)
        for other in beside:
            share, away = off(edge, vertices[other[near]])
            goes_on |= (away <= NEAR) & (share > -NEAR) & (share < 1.0 + NEAR)
        hit = inside & goes_on
        found[edge[hit]] = at[near[hit]]
        going = (found[edge] < 0) & (distance <= (0.5 * width + NEAR) * length[edge])
        edge, low, width = edge[going], low[going], 0.5 * width
        edge, low = np.concatenate([edge, edge]), np.concatenate([low, low + width])
    rows = np.flatnonzero(found >= 0)
    return open_edges[rows], found[rows]
