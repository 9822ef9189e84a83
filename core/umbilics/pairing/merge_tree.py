"""The merge tree of the umbilics: where the sublevel sets of the gap around them join.

The tree is contracted in arrays: vertices run down to the minimum below them, and a basin without
an umbilic joins the basin across its lowest pass, which is where the sublevel sets would join it
and where nothing can cancel.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...mesh.surface import Surface


@dataclass(frozen=True)
class _Passes:
    """Passes between basins, lowest first: the two basins (e,) that each joins, and its rank or
    name (e,)."""

    first: np.ndarray
    second: np.ndarray
    rank: np.ndarray

    def after(self, basin: np.ndarray) -> _Passes:
        """Those that are left where basins have become others, the `basin` (b,) of each."""
        first, second = basin[self.first], basin[self.second]
        kept = np.flatnonzero(first != second)
        return _Passes(first[kept], second[kept], self.rank[kept])


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
    corner, seed = _seeds(surface, triangle, regions)
    seed = (seed + vertices).astype(np.int32)
    around = rank[surface.neighbours]
    lowest = np.minimum.reduceat(around, surface.neighbour_start[:-1])
    below = np.arange(vertices + count + len(regions), dtype=np.int32)
    below[:vertices] = np.where(lowest < rank, order[lowest], below[:vertices])
    below[corner] = seed
    basin, basins = label_roots(below)
    passes = _passes(surface, basin, rank, corner, seed)
    row = np.full(basins, -1, dtype=np.int32)
    umbilic = basin[vertices : vertices + count]
    row[umbilic] = np.arange(count, dtype=np.int32)
    neutral = np.ones(basins, dtype=bool)
    neutral[umbilic[charged]] = False
    passes, row = _between_umbilics(passes, row, neutral)
    chosen = _spanning_tree(passes, len(row))
    low, high = row[passes.first[chosen]], row[passes.second[chosen]]
    return low, high, gap[order[passes.rank[chosen]]]


def _seeds(
    surface: Surface, triangle: np.ndarray, regions: Sequence[np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (c,) of value 0, below everything, and what each belongs to: umbilics first, then
    regions."""
    corners = [surface.triangles[triangle].ravel()]
    seeds = [np.repeat(np.arange(len(triangle)), 3)]
    for number, rows in enumerate(regions, start=len(triangle)):
        inside = np.unique(surface.triangles[rows])
        corners.append(inside)
        seeds.append(np.full(len(inside), number))
    return np.concatenate(corners), np.concatenate(seeds)


def _passes(
    surface: Surface, basin: np.ndarray, rank: np.ndarray, corner: np.ndarray, seed: np.ndarray
) -> _Passes:
    """The edges of the mesh from basin to basin, and those from corners to the seeds beside."""
    vertices = len(rank)
    valence = np.diff(surface.neighbour_start)
    mine = np.repeat(basin[:vertices], valence)
    other = basin[surface.neighbours]
    crossing = np.flatnonzero(mine < other)
    owner = np.repeat(np.arange(vertices, dtype=np.int32), valence)[crossing]
    beyond = surface.neighbours[crossing]
    first = np.concatenate([mine[crossing], basin[corner]])
    second = np.concatenate([other[crossing], basin[seed]])
    height = np.concatenate([np.maximum(rank[owner], rank[beyond]), rank[corner]])
    different = np.flatnonzero(first != second)
    first, second, height = first[different], second[different], height[different]
    # Sorting keys is several times faster than sorting places, and as strict.
    key = np.sort(height.astype(np.int64) << 32 | np.arange(len(height)))
    ascending = key & 0xFFFFFFFF
    return _Passes(first[ascending], second[ascending], height[ascending])


def _between_umbilics(
    passes: _Passes, row: np.ndarray, neutral: np.ndarray
) -> tuple[_Passes, np.ndarray]:
    """The passes between umbilics alone, and the umbilic of each basin that is left: what is
    `neutral` (b,) has joined the basin across its lowest pass."""
    while True:
        lowest = lowest_edges(passes.first, passes.second, len(row))
        hook, used = lowest_passes(passes.first, passes.second, lowest, neutral)
        if len(used) == 0:
            return passes, row
        basin, basins = label_roots(hook)
        passes = passes.after(basin)
        # A basin that takes neutral ones up keeps its umbilic.
        held, was = np.flatnonzero(~neutral), row
        neutral, row = np.ones(basins, dtype=bool), np.full(basins, -1, dtype=np.int32)
        neutral[basin[held]] = False
        row[basin[held]] = was[held]


def _spanning_tree(passes: _Passes, basins: int) -> np.ndarray:
    """(e,) bool, the passes of the spanning tree: the same steps, all basins hooking."""
    chosen = np.zeros(len(passes.rank), dtype=bool)
    left = replace(passes, rank=np.arange(len(chosen), dtype=np.int32))
    while len(left.first):
        lowest = lowest_edges(left.first, left.second, basins)
        hook, used = lowest_passes(left.first, left.second, lowest, np.ones(basins, dtype=bool))
        chosen[left.rank[used]] = True
        basin, basins = label_roots(hook)
        left = left.after(basin)
    return chosen


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
