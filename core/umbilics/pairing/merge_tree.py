"""The merge tree of the umbilics: where the sublevel sets of the gap around them join.

The tree is contracted in arrays: vertices run down to the minimum below them, and a basin without
an umbilic joins the basin across its lowest pass, which is where the sublevel sets would join it
and where nothing can cancel.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...mesh.surface import Surface


def merge_tree(
    surface: Surface,
    gap: np.ndarray,
    triangle: np.ndarray,
    charged: np.ndarray,
    regions: Sequence[np.ndarray],
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The merge tree of the umbilics: rows of both and gap at the pass, lowest pass first."""
    count, vertices = len(triangle), len(gap)
    # Ranks instead of gaps: a strict order, in which equal gaps make no cycles.
    order = _ascending(gap)
    rank = np.empty(vertices, dtype=np.int32)
    rank[order] = np.arange(vertices, dtype=np.int32)

    # Seeds have value 0, below everything: umbilics first, then regions.
    corners = [surface.triangles[triangle].ravel()]
    seeds = [np.repeat(np.arange(count), 3)]
    for number, rows in enumerate(regions):
        inside = np.unique(surface.triangles[rows])
        corners.append(inside)
        seeds.append(np.full(len(inside), count + number))
    corner, seed = np.concatenate(corners), np.concatenate(seeds)
    seed_node = (seed + vertices).astype(np.int32)

    around = rank[surface.neighbours]
    lowest = np.minimum.reduceat(around, surface.neighbour_start[:-1])
    below = np.arange(vertices + count + len(regions), dtype=np.int32)
    below[:vertices] = np.where(lowest < rank, order[lowest], below[:vertices])
    below[corner] = seed_node
    basin, basins = label_roots(below)

    mine = np.repeat(basin[:vertices], np.diff(surface.neighbour_start))
    other = basin[surface.neighbours]
    crossing = np.flatnonzero(mine < other)
    owner = np.repeat(np.arange(vertices, dtype=np.int32), np.diff(surface.neighbour_start))
    first = np.concatenate([mine[crossing], basin[corner]])
    second = np.concatenate([other[crossing], basin[seed_node]])
    weight = np.concatenate([np.maximum(rank[owner[crossing]], around[crossing]), rank[corner]])
    different = np.flatnonzero(first != second)
    first, second, weight = first[different], second[different], weight[different]
    # Sorting keys is several times faster than sorting places, and as strict.
    key = np.sort(weight.astype(np.int64) << 32 | np.arange(len(weight)))
    ascending = key & 0xFFFFFFFF
    first, second, weight = first[ascending], second[ascending], weight[ascending]

    umbilic = basin[vertices : vertices + count]
    neutral = np.ones(basins, dtype=bool)
    neutral[umbilic[charged]] = False
    row = np.full(basins, -1, dtype=np.int32)
    row[umbilic] = np.arange(count, dtype=np.int32)
    while True:
        hook, used = lowest_passes(first, second, lowest_edges(first, second, basins), neutral)
        if len(used) == 0:
            break
        basin, basins = label_roots(hook)
        first, second = basin[first], basin[second]
        kept = np.flatnonzero(first != second)
        first, second, weight = first[kept], second[kept], weight[kept]
        # A basin that takes neutral ones up keeps its umbilic.
        held, was = np.flatnonzero(~neutral), row
        neutral, row = np.ones(basins, dtype=bool), np.full(basins, -1, dtype=np.int32)
        neutral[basin[held]] = False
        row[basin[held]] = was[held]

    # Only umbilics are left. The same steps, all of them hooking, give the spanning tree.
    low, high = row[first], row[second]
    edge = np.arange(len(first), dtype=np.int32)
    tree = []
    while len(first):
        lowest = lowest_edges(first, second, basins)
        hook, used = lowest_passes(first, second, lowest, np.ones(basins, dtype=bool))
        tree.append(edge[used])
        basin, basins = label_roots(hook)
        first, second = basin[first], basin[second]
        kept = np.flatnonzero(first != second)
        first, second, edge = first[kept], second[kept], edge[kept]
    chosen = np.zeros(len(low), dtype=bool)
    for used in tree:
        chosen[used] = True
    return low[chosen], high[chosen], gap[order[weight[chosen]]]


def _ascending(gap: np.ndarray) -> np.ndarray:
    """(n,) int32 order of the gaps, equal ones by their rows."""
    order = np.argsort(gap)
    ordered = gap[order]
    if (ordered[1:] == ordered[:-1]).any():
        # Several times slower, which is why it is not what is tried first.
        order = np.argsort(gap, kind="stable")
    return order.astype(np.int32)


def label_roots(below: np.ndarray) -> tuple[np.ndarray, int]:
    """Number the roots of a forest of pointers; each node's root number, and how many."""
    while True:
        further = below[below]
        if np.array_equal(further, below):
            break
        below = further
    root = below == np.arange(len(below), dtype=below.dtype)
    number = np.cumsum(root, dtype=np.int32) - 1
    return number[below], int(number[-1]) + 1


def lowest_edges(first: np.ndarray, second: np.ndarray, nodes: int) -> np.ndarray:
    """(nodes,) the lowest edge of each node, the number of edges where it has none.

    Edges join `first` (e,) to `second` (e,), lowest first.
    """
    none = len(first)
    edge = np.full(nodes, none, dtype=np.int32)
    # Of several values written to one place the last one stays.
    backwards = np.arange(none, dtype=np.int32)[::-1]
    edge[second[::-1]] = backwards
    other = np.full(nodes, none, dtype=np.int32)
    other[first[::-1]] = backwards
    return np.minimum(edge, other)


def lowest_passes(
    first: np.ndarray, second: np.ndarray, lowest: np.ndarray, hooking: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Where nodes go that hook over their lowest edge (Borůvka 1926).

    Parameters
    ----------
    first, second:
        (e,) nodes that each edge joins, lowest first.
    lowest, hooking:
        (nodes,) as `lowest_edges` gives them, and which nodes hook.

    Returns
    -------
    hook, used:
        (nodes,) int32 pointers, of others to themselves, and the edges gone over.
    """
    moving = np.flatnonzero(hooking & (lowest < len(first)))
    hook = np.arange(len(hooking), dtype=np.int32)
    used = lowest[moving]
    hook[moving] = first[used] + second[used] - moving
    # Two nodes may choose each other: one of them stays.
    mutual = moving[(hook[hook[moving]] == moving) & (moving < hook[moving])]
    hook[mutual] = mutual
    return hook, used
