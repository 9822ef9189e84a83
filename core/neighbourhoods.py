"""Which vertices lie around each vertex: rings grown by sparse products, in blocks."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy import sparse

from .surface import Surface


def adjacency(surface: Surface) -> sparse.csr_array:
    """The (n, n) one-ring graph of the surface, ones where two vertices share an edge."""
    n = len(surface.vertices)
    ones = np.ones(len(surface.neighbours), np.int32)
    return sparse.csr_array((ones, surface.neighbours, surface.neighbour_start), shape=(n, n))


def rings(graph: sparse.csr_array, rows: np.ndarray | slice, count: int) -> sparse.csr_array:
    """For each of the vertices `rows`, those within `count` >= 2 edges, itself included.

    On a surface every edge has a triangle, so two steps reach the centre and the one-ring too.
    """
    reach = graph[rows]
    for _ in range(count - 1):
        reach = reach @ graph
        reach.data[:] = 1
    return reach


def by_size(reach: sparse.csr_array, most: int) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """The rows of `reach`, gathered into blocks of equal size.

    Yields
    ------
    rows:
        (b,) rows of `reach`, with b * size <= `most` (at least one row).
    members:
        (size, b) int32 vertices of each row.
    """
    sizes = np.diff(reach.indptr)
    order = np.argsort(sizes, kind="stable")
    ends = np.cumsum(np.bincount(sizes)) if len(sizes) else np.zeros(0, int)
    begin = 0
    for size, end in enumerate(ends):
        step = max(most // max(size, 1), 1)
        for low in range(begin, end, step):
            rows = order[low : min(low + step, end)]
            if size:
                slots = reach.indptr[rows] + np.arange(size, dtype=reach.indptr.dtype)[:, None]
                yield rows, reach.indices[slots]
        begin = end
