"""A `Surface` straight from arrays that are already a clean manifold."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from core.surface import Surface


def bare_surface(vertices: np.ndarray, triangles: np.ndarray) -> Surface:
    """`vertices` (n, 3) and `triangles` (m, 3) as they are, without any cleaning."""
    n = len(vertices)
    start, end = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    both = np.concatenate([start, end]), np.concatenate([end, start])
    # One entry for each triangle at an edge; the rows sorted.
    edges = sparse.coo_matrix((np.ones(len(both[0])), both), shape=(n, n)).tocsr()
    edges.sort_indices()
    border = np.zeros(n, dtype=bool)
    rows = np.repeat(np.arange(n), np.diff(edges.indptr))
    border[rows[edges.data == 1]] = True
    _, component = csgraph.connected_components(edges, directed=False)
    return Surface(
        np.asarray(vertices, dtype=float),
        triangles.astype(np.int32),
        np.arange(n),
        np.arange(len(triangles)),
        edges.indptr.astype(np.int32),
        edges.indices.astype(np.int32),
        border,
        component.astype(np.int32),
        np.zeros(3),
        1.0,
    )
