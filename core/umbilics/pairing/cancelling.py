"""Cancelling opposite charges where they meet in a merge tree.

Two nodes that are joined by the lowest edge of both come together before anything else happens
to either. Where noise makes most of the charges, most cancel in such pairs: all of these are taken
at once, in a few rounds of arrays, and only what is left is walked in Python.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ...base.subsets import spans
from .merge_tree import label_roots, lowest_edges, lowest_passes

# Fewer candidates than this are compared faster without arrays.
_FEW = 12
# A round of arrays costs as much as walking this share of the edges.
_WORTHWHILE = 0.02


def cancel(
    units: np.ndarray,
    centres: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    saddle: np.ndarray,
    firm: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The pairs of charges that cancel, the closest ones first, wherever opposite ones meet.

    Of several that could cancel with one, those that are firm stay.

    Parameters
    ----------
    units:
        (k,) int64 charges.
    centres:
        (k, 3) their places.
    low, high, saddle:
        (e,) rows of the charges that each edge of the tree joins, and its gap; lowest first.
    firm:
        (k,) bool, charges that others cancel before; None for no difference.

    Returns
    -------
    first, second, level:
        (p,) rows of both charges of each pair, and the gap at which they cancel.
    """
    units = units.copy()
    centres = _apart(centres, firm)
    left = np.flatnonzero(units)
    node, nodes = left, len(units)
    pairs = []
    worthwhile = True
    while worthwhile and len(low):
        edge, hook = _meeting(units, left, node, nodes, low, high)
        first, second, where = _closest_pairs(units, centres, left, node, low[edge], high[edge])
        pairs.append((first, second, saddle[edge[where]]))
        number, nodes = label_roots(hook)
        kept = np.flatnonzero(units[left])
        left, node = left[kept], number[node[kept]]
        low, high = number[low], number[high]
        apart = np.flatnonzero(low != high)
        worthwhile = len(apart) < (1.0 - _WORTHWHILE) * len(low)
        low, high, saddle = low[apart], high[apart], saddle[apart]
    pairs.append(_walk(units, centres, left, node, nodes, low, high, saddle))
    return _joined(pairs)


def _apart(centres: np.ndarray, firm: np.ndarray | None) -> np.ndarray:
    """(k, 4) places and what adds to every squared distance from them: more than any distance
    for those that are firm."""
    away = np.zeros(len(centres))
    if firm is not None and len(centres):
        size = np.ptp(centres, axis=0)
        away[firm] = 2.0 * float(size @ size) + np.finfo(float).tiny
    return np.column_stack([centres, away])


def _meeting(
    units: np.ndarray,
    left: np.ndarray,
    node: np.ndarray,
    nodes: int,
    low: np.ndarray,
    high: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Edges over which opposite charges meet before anything else happens to them, and to which
    node each one goes: over those, over such edges between charges of one sign, and, from nodes
    without a charge, over the lowest edge."""
    size = np.bincount(node, minlength=nodes)
    positive = np.zeros(nodes, dtype=bool)
    positive[node] = units[left] > 0
    lowest = lowest_edges(low, high, nodes)
    hook, _ = lowest_passes(low, high, lowest, size == 0)
    both = np.flatnonzero((lowest[low] == lowest[high]) & (lowest[low] == np.arange(len(low))))
    one, two = low[both], high[both]
    pairs = size[one] * size[two]
    opposite = positive[one] != positive[two]
    # Long lists are the walk's: comparing all of one with all of another takes memory.
    together = (pairs > 0) & (~opposite | (pairs <= _FEW))
    hook[two[together]] = one[together]
    return both[together & opposite], hook


def _closest_pairs(
    units: np.ndarray,
    centres: np.ndarray,
    left: np.ndarray,
    node: np.ndarray,
    one: np.ndarray,
    two: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Cancel the charges `left` at the nodes `one` (m,) with those at `two` (m,), the closest
    first; `units` is changed. Rows of both of each pair, and in which of the m meetings."""
    nodes = int(node.max(initial=-1)) + 1
    meets = np.zeros(nodes, dtype=bool)
    meets[one] = meets[two] = True
    meets = meets[node]
    left, node = left[meets], node[meets]
    size = np.bincount(node, minlength=nodes)
    start = np.cumsum(size) - size
    rows = left[np.argsort(node, kind="stable")]
    count = size[one] * size[two]
    meeting = np.repeat(np.arange(len(one)), count)
    mine, yours = np.divmod(spans(0, count), size[two][meeting])
    mine, yours = rows[start[one][meeting] + mine], rows[start[two][meeting] + yours]
    away = centres[mine, :3] - centres[yours, :3]
    square = np.einsum("ij,ij->i", away, away) + centres[mine, 3] + centres[yours, 3]
    order = np.lexsort((square, meeting))
    mine, yours, meeting = mine[order], yours[order], meeting[order]
    pairs = [(mine[:0], yours[:0], meeting[:0])]
    while len(meeting):
        nearest = np.append(True, meeting[1:] != meeting[:-1])
        first, second = mine[nearest], yours[nearest]
        pairs.append((first, second, meeting[nearest]))
        spent = np.minimum(np.abs(units[first]), np.abs(units[second]))
        units[first] -= np.sign(units[first]) * spent
        units[second] -= np.sign(units[second]) * spent
        kept = np.flatnonzero((units[mine] != 0) & (units[yours] != 0))
        mine, yours, meeting = mine[kept], yours[kept], meeting[kept]
    return _joined(pairs)


def _joined(parts: Sequence[tuple[np.ndarray, ...]]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Triples of arrays, one behind the other."""
    first, second, third = (np.concatenate(part) for part in zip(*parts, strict=True))
    return first, second, third


def _walk(
    units: np.ndarray,
    centres: np.ndarray,
    rows: np.ndarray,
    node: np.ndarray,
    nodes: int,
    low: np.ndarray,
    high: np.ndarray,
    saddle: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """`cancel`, edge by edge, of the charges in `rows` (r,), each at a node."""
    charge = units[rows].tolist()
    places = _Charges(centres[rows])
    root = list(range(nodes))
    at_node = np.argsort(node, kind="stable").tolist()
    end = np.cumsum(np.bincount(node, minlength=nodes)).tolist()
    left = [at_node[start:stop] for start, stop in zip([0, *end], end, strict=False)]
    # Those of a long list in an array, in the same order: made once, then kept up to date.
    crowd: dict[int, np.ndarray] = {}
    first: list[int] = []
    second: list[int] = []
    level: list[float] = []
    for one, two, gap in zip(low.tolist(), high.tolist(), saddle.tolist(), strict=True):
        while root[one] != one:
            root[one] = one = root[root[one]]
        while root[two] != two:
            root[two] = two = root[root[two]]
        mine, yours = left[one], left[two]
        if len(mine) < len(yours):
            one, two, mine, yours = two, one, yours, mine
        root[two] = one
        if not yours:
            continue
        left[two] = []
        crowd.pop(two, None)
        ours = crowd.get(one)
        if (charge[mine[0]] > 0) != (charge[yours[0]] > 0):
            if ours is None and len(mine) > _FEW:
                ours = crowd[one] = places.spread(mine)
            while mine and yours:
                i, j = places.closest(mine, yours, ours)
                first.append(mine[i])
                second.append(yours[j])
                level.append(gap)
                if _spend(charge, mine, i, yours, j) and ours is not None:
                    ours[:, i] = ours[:, len(mine)]
        if ours is not None and yours:
            if len(mine) + len(yours) > ours.shape[1]:
                ours = crowd[one] = np.concatenate([ours, places.spread(mine + yours)], axis=1)
            for place, row in enumerate(yours, len(mine)):
                ours[:, place] = places.across[:, row]
        mine.extend(yours)
    one, two = (rows[np.array(some, dtype=np.int64)] for some in (first, second))
    return one, two, np.array(level)


class _Charges:
    """Places of charges, for looking for the closest two.

    `across` has columns x, y, z, -(x^2 + y^2 + z^2 + a) / 2, of which the product with a row
    u, v, w, 1 is largest at the place closest to u, v, w: one call for all of a long list.
    a is what adds to the squared distance from a place, see `_apart`.
    """

    def __init__(self, centres: np.ndarray) -> None:
        self._lists = centres.tolist()
        places = centres[:, :3]
        self._rows = np.column_stack([places, np.ones(len(places))])
        half = -0.5 * (np.einsum("ij,ij->i", places, places) + centres[:, 3])
        self.across = np.concatenate([places.T, half[None]])

    def spread(self, some: list[int]) -> np.ndarray:
        """(4, n) columns of a list of charges."""
        return self.across[:, some]

    def closest(
        self, mine: list[int], yours: list[int], ours: np.ndarray | None
    ) -> tuple[int, int]:
        """Places in both lists of the two charges closest to each other.

        `ours` begins with the columns of the first list where that is a long one.
        """
        if len(mine) == 1 and len(yours) == 1:
            return 0, 0
        nearest, first, second = np.inf, 0, 0
        if ours is None:
            for j, two in enumerate(yours):
                u, v, w, a = self._lists[two]
                for i, one in enumerate(mine):
                    x, y, z, b = self._lists[one]
                    distance = (x - u) * (x - u) + (y - v) * (y - v) + (z - w) * (z - w) + a + b
                    if distance < nearest:
                        nearest, first, second = distance, i, j
            return first, second
        # The longer list at once, the shorter one in turn: the memory stays small.
        for j, two in enumerate(yours):
            i = int((self._rows[two] @ ours[:, : len(mine)]).argmax())
            if len(yours) == 1:
                return i, 0
            *one, a = self._lists[mine[i]]
            *other, b = self._lists[two]
            distance = math.dist(one, other) ** 2 + a + b
            if distance < nearest:
                nearest, first, second = distance, i, j
        return first, second


def _spend(charge: list[int], mine: list[int], i: int, yours: list[int], j: int) -> bool:
    """Cancel as much of two opposite charges as both have; what is used up leaves its list, in
    which the last takes its place. True if one left the first list.
    """
    one, two = mine[i], yours[j]
    total = charge[one] + charge[two]
    used_up = total == 0 or (total > 0) != (charge[one] > 0)
    charge[one], charge[two] = (0, total) if used_up else (total, 0)
    if used_up:
        mine[i] = mine[-1]
        mine.pop()
    if charge[two] == 0:
        yours[j] = yours[-1]
        yours.pop()
    return used_up
