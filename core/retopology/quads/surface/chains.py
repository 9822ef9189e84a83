"""Chains of feature edges, and leaving out those too short for edges of quads to follow."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from ....mesh.half_edges import ends_of
from ....mesh.surface import Surface


def chains(surface: Surface, half_edges: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The chain (e,) of each of the edges, and the length of each chain.

    Chains end where other than two feature edges meet, and at corners of the surface's border.

    Parameters
    ----------
    half_edges:
        (e,) int64 one half-edge of each feature edge.
    """
    tail, head = ends_of(surface.triangles, half_edges)
    n, count = len(surface.vertices), len(half_edges)
    degree = np.bincount(np.concatenate([tail, head]), minlength=n)
    both = np.concatenate([tail, head])
    owner = np.tile(np.arange(count), 2)
    through = (degree[both] == 2) & ~surface.border[both]
    both, owner = both[through], owner[through]
    order = np.argsort(both, kind="stable")
    one, two = owner[order][::2], owner[order][1::2]
    graph = sparse.coo_array((np.ones(len(one)), (one, two)), shape=(count, count))
    number, label = csgraph.connected_components(graph, directed=False)
    length = np.linalg.norm(surface.vertices[head] - surface.vertices[tail], axis=1)
    return label, np.bincount(label, weights=length, minlength=number)


def long_chains(
    surface: Surface, half_edges: np.ndarray, least: float, strong: float = 0.0
) -> np.ndarray:
    """Those of the edges (e,) in chains that are `least` long and bend by `strong` degrees as a
    mean, or join others at both ends.

    Lone short edges of a noisy or coarse surface are no creases, nor are the stubs that are left
    of a crease where it fades. Along a thin tube of few triangles around, whose edges bend about
    as far as creases must, chains come and go by chance.
    """
    normal, _ = surface.face_normal_area
    while len(half_edges):
        tail, head = ends_of(surface.triangles, half_edges)
        degree = np.bincount(np.concatenate([tail, head]), minlength=len(surface.vertices))
        chain, length = chains(surface, half_edges)
        loose = ((degree == 1) & ~surface.border)[np.stack([tail, head])].any(axis=0)
        ends = np.bincount(chain, weights=loose)
        # What hangs together without one long chain is a tangle of noise.
        n = len(surface.vertices)
        graph = sparse.coo_array((np.ones(len(tail)), (tail, head)), shape=(n, n))
        _, label = csgraph.connected_components(graph, directed=False)
        longest = np.zeros(n)
        np.maximum.at(longest, label[tail], length[chain])
        short = (length[chain] < least) & ((ends[chain] > 0) | (longest[label[tail]] < least))
        one, two = normal[half_edges // 3], normal[surface.twin[half_edges] // 3]
        bend = np.degrees(np.arccos(np.einsum("ec,ec->e", one, two).clip(-1.0, 1.0)))
        mean = np.bincount(chain, weights=bend) / np.bincount(chain)
        short |= (ends[chain] > 0) & (mean[chain] < strong)
        if not short.any():
            break
        half_edges = half_edges[~short]
    return half_edges
