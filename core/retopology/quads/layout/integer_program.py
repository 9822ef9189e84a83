"""The program of whole numbers for the arcs of a layout: what it costs to leave their lengths, and
what holds of their sums."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from .rectangles import Layout

# Single arcs matter this much beside the widths of rectangles.
ARC_WEIGHT = 0.1
# Widths weigh by what lies across, within these bounds.
LEAST_ACROSS, MOST_ACROSS = 0.5, 30.0
# Unit steps up and down that have a cost of their own; farther ones cost like the last.
STEPS = 4
# Edges around a border, and around one with a corner that a single quad fills: it has two of them,
# and with three it would lie on the hole.
LEAST_BORDER, LEAST_CORNERED = 3.0, 4.0


@dataclass(frozen=True)
class Count:
    """How many quads there shall be.

    Attributes
    ----------
    near:
        (a,) int64 quads along the arcs of a solution of which the one that is sought is not far.
    least, most:
        Bounds of the number of quads.
    """

    near: np.ndarray
    least: float
    most: float


@dataclass(frozen=True)
class Program:
    """min cost s for base + steps s, rows of it 0."""

    base: np.ndarray
    quantity: np.ndarray  # of each step
    sign: np.ndarray
    cost: np.ndarray
    upper: np.ndarray
    rows: sparse.csr_array
    weight: np.ndarray
    arcs: int

    @property
    def steps(self) -> sparse.csr_array:
        """(quantities, steps) what each step adds to its quantity."""
        shape = (len(self.base), len(self.cost))
        place = self.quantity, np.arange(len(self.cost))
        return sparse.coo_array((self.sign, place), shape=shape).tocsr()

    def wanted(self, chosen: np.ndarray) -> np.ndarray:
        """The real value of quantities, back from the cost of their first step up."""
        # price(b + 1) - price(b) = weight (2 (b - x) + 1), and the first steps come first.
        rest = self.cost[chosen] / np.maximum(self.weight[chosen], np.finfo(float).tiny) - 1.0
        return np.asarray(self.base[chosen] - 0.5 * rest)


@dataclass(frozen=True)
class LeastSums:
    """Sums of quantities that are at least so much."""

    sums: sparse.csr_array
    least: np.ndarray

    def __len__(self) -> int:
        return len(self.least)


def sides_of(layout: Layout) -> sparse.csr_array:
    """(4 r, a) the arcs in the sums of each rectangle's four sides."""
    every = [side for rectangle in layout.rectangles for side in rectangle]
    row = np.repeat(np.arange(len(every)), [len(side) for side in every])
    column = np.array([half // 2 for side in every for half in side])
    shape = (len(every), len(layout.arc_track))
    return sparse.coo_array((np.ones(len(row)), (row, column)), shape=shape).tocsr()


def program_of(
    layout: Layout, sides: sparse.csr_array, scale: float, least: int | np.ndarray
) -> Program:
    """The program of a layout; see `whole_lengths`."""
    length = layout.length * scale
    arcs, count = len(length), len(layout.rectangles)
    # What widths have at least follows from the arcs in them.
    least = np.concatenate([np.broadcast_to(least, arcs), np.full(2 * count, np.min(least))])
    # Width and height of each rectangle, by the first two of its sides.
    extent = (sides @ length).reshape(-1, 4)[:, :2]
    owner = np.arange(4 * count)
    of = arcs + 2 * (owner // 4) + owner % 2
    widths = sparse.coo_array(
        (np.full(4 * count, -1.0), (owner, of - arcs)), shape=(4 * count, 2 * count)
    ).tocsr()
    wanted = np.concatenate([length, extent.ravel()])
    across = np.clip(extent[:, ::-1], LEAST_ACROSS, MOST_ACROSS)
    weight = np.concatenate([np.full(arcs, ARC_WEIGHT), across.ravel()])
    weight = weight / np.maximum(wanted, 1.0)
    base = np.maximum(np.floor(wanted), least)
    quantity, sign, cost, upper = [], [], [], []
    name = np.arange(len(wanted))

    def price(value: np.ndarray) -> np.ndarray:
        return weight * (value - wanted) ** 2

    for step in range(STEPS):
        quantity.append(name)
        sign.append(np.ones(len(name)))
        cost.append(price(base + step + 1) - price(base + step))
        upper.append(np.full(len(name), 1.0 if step < STEPS - 1 else np.inf))
        room = base - least - step
        has = room > 0
        quantity.append(name[has])
        sign.append(np.full(np.count_nonzero(has), -1.0))
        cost.append((price(base - step - 1) - price(base - step))[has])
        upper.append(np.minimum(room, 1.0 if step < STEPS - 1 else np.inf)[has])
    return Program(
        base,
        np.concatenate(quantity),
        np.concatenate(sign),
        np.concatenate(cost),
        np.concatenate(upper),
        sparse.hstack([sides, widths]).tocsr(),
        weight,
        arcs,
    )


def lengths_of_cuts(cuts: set[frozenset[int]], program: Program, layout: Layout) -> LeastSums:
    """At least 1 for each of the cuts, and `LEAST_BORDER` around each border: with fewer its edges
    lie on each other and the hole is shut. `LEAST_CORNERED` where it has a corner of one quad."""
    loops = _borders(layout)
    ordered = sorted(sorted(cut) for cut in cuts) + loops
    row = np.repeat(np.arange(len(ordered)), [len(cut) for cut in ordered]).astype(np.int64)
    column = np.array([arc for cut in ordered for arc in cut], np.int64)
    shape = (len(ordered), len(program.base))
    sums = sparse.coo_array((np.ones(len(row)), (row, column)), shape=shape).tocsr()
    least = np.ones(len(ordered))
    if loops:
        single = _quarters(layout) == 1
        least[len(ordered) - len(loops) :] = [
            LEAST_CORNERED if single[layout.arc_node[loop]].any() else LEAST_BORDER
            for loop in loops
        ]
    return LeastSums(sums, least)


def _borders(layout: Layout) -> list[list[int]]:
    """The arcs around each border."""
    border = np.array([track.border for track in layout.tracks], bool)
    arc = np.flatnonzero(border[layout.arc_track])
    if not len(arc):
        return []
    count = len(layout.nodes)
    ends = layout.arc_node[arc]
    graph = sparse.coo_array((np.ones(len(arc)), (ends[:, 0], ends[:, 1])), shape=(count, count))
    _, label = csgraph.connected_components(graph, directed=False)
    around = label[ends[:, 0]]
    order = np.argsort(around, kind="stable")
    cuts = np.flatnonzero(np.diff(around[order])) + 1
    return [rows.tolist() for rows in np.split(arc[order], cuts)]


def _quarters(layout: Layout) -> np.ndarray:
    """(n,) int64 right angles of rectangles at each node: one of a corner, two of a side that
    passes it."""
    sides = [side for rectangle in layout.rectangles for side in rectangle]
    half = np.array([half for side in sides for half in side], np.int64)
    turns = np.array([1 if place == 0 else 2 for side in sides for place in range(len(side))])
    node = layout.arc_node[half // 2, half % 2]
    return np.bincount(node, turns, len(layout.nodes)).astype(np.int64)


def with_count(bounds: LeastSums, count: Count, sides: sparse.csr_array) -> LeastSums:
    """The bounds and those of the number of quads, sum w h = sum w h0 + w0 h - w0 h0 nearly."""
    extent = (sides @ count.near).reshape(-1, 4)[:, :2]
    row = np.concatenate([np.zeros(len(count.near)), extent[:, ::-1].ravel()])
    row = row / max(count.most, 1.0)
    known = float((extent[:, 0] * extent[:, 1]).sum())
    least, most = ((bound + known) / max(count.most, 1.0) for bound in (count.least, count.most))
    both = sparse.csr_array(np.stack([row, -row]))
    return LeastSums(
        sparse.vstack([bounds.sums, both]).tocsr(), np.concatenate([bounds.least, [least, -most]])
    )
