"""Vertices spread over a graph: none beside another, every other one beside some."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from ..base.progress import Progress
from .rings import selection


def independent(graph: sparse.csr_array, progress: Progress) -> np.ndarray:
    """(c,) ascending nodes of a symmetric graph, no two of them adjacent, and every other node
    adjacent to one: a maximal independent set (Luby 1986, https://doi.org/10.1137/0215074).

    Of nodes in a random order those that come before all their neighbours are taken, their
    neighbours are left out, and so on with the rest.
    """
    n = graph.shape[0]
    rank = np.random.default_rng(0).permutation(n).astype(np.int32) + 1
    taken = np.diff(graph.indptr) == 0
    rank[taken] = 0
    rest, rows = np.flatnonzero(~taken), graph
    while len(rest):
        progress.ask()
        rows = graph[rest]
        # A rank of zero is that of a node that is decided.
        first = rank[rest] > np.maximum.reduceat(rank[rows.indices], rows.indptr[:-1])
        new = rest[first]
        taken[new] = True
        rank[new] = 0
        rank[rows[np.flatnonzero(first)].indices] = 0
        rest = rest[rank[rest] > 0]
    return np.flatnonzero(taken)


def spread(
    graph: sparse.csr_array, rounds: int, progress: Progress
) -> tuple[np.ndarray, sparse.csr_array]:
    """Nodes spread over a symmetric graph (n, n), and which of them are near to each node.

    Each round leaves about a quarter of the nodes, the second a third of these.

    Returns
    -------
    nodes:
        (c,) ascending.
    near:
        (n, c) ones where a node of the graph is within one edge of one of those, after a second
        round within three. No row is empty.
    """
    nodes = independent(graph, progress)
    near = _within(graph, nodes, 1, progress)
    if rounds > 1:
        # Two nodes are neighbours that some node is next to.
        beside = (near.T @ near).tocoo()
        apart = beside.row != beside.col
        ones = np.ones(int(apart.sum()), np.int32)
        pairs = beside.row[apart], beside.col[apart]
        nodes = nodes[independent(sparse.csr_array((ones, pairs), beside.shape), progress)]
        near = _within(graph, nodes, 3, progress)
    return nodes, near


def _within(
    graph: sparse.csr_array, nodes: np.ndarray, edges: int, progress: Progress
) -> sparse.csr_array:
    """(n, c) ones where a node is within so many edges of each of the `nodes` (c,)."""
    near = selection(nodes[:, None], graph.shape[0]).T.tocsr()
    for _ in range(edges):
        progress.ask()
        near = (near + graph @ near).tocsr()
        near.data[:] = 1
    return near
