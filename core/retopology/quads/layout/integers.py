"""Whole numbers of quads for the arcs of a layout, as near to their lengths as can be.

Opposite sides of every rectangle hold equally many. Each arc stands in the sums of two sides, and
so does each width with its two sides: a flow on a bidirected graph with convex costs, whose linear
program has solutions in halves (Campen, Bommes & Kobbelt 2015, 10.1145/2766892; Heistermann,
Warnett & Bommes 2023, 10.1145/3592437). Halves are cleared by fixing one number in each of their
connected pieces at a time. How many quads there are is a sum of products of widths; near numbers
that are known it is linear, and bounds on it are two more rows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.optimize import Bounds, LinearConstraint, linprog, milp
from scipy.sparse import csgraph

from ....base.errors import RemeshError
from ....base.progress import Progress
from .rectangles import Layout

# Single arcs matter this much beside the widths of rectangles.
ARC_WEIGHT = 0.1
# Widths weigh by what lies across, within these bounds.
LEAST_ACROSS, MOST_ACROSS = 0.5, 30.0
# Unit steps up and down that have a cost of their own; farther ones cost like the last.
STEPS = 4
# Rounds of fixing before branch and bound takes over, its nodes at first and at most, those for a
# number of quads that is only wished for, and its gap.
MOST_ROUNDS, BRANCHES, MOST_BRANCHES, FEW_BRANCHES, GAP = 60, 2000, 50_000, 200, 0.02
# How often numbers beside parts of wholes get more room.
WIDER = 3
# Edges around a border.
LEAST_BORDER = 3.0
# Rectangles of a layout for which branch and bound is quick, and for which linear programs with
# bounds of the number of quads are.
SMALL, MANY = 60, 300
NEARLY_WHOLE, NEARLY_HALF = 1e-6, 1e-3


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
class _Program:
    """min cost s for base + steps s, rows of it 0."""

    base: np.ndarray
    quantity: np.ndarray  # of each step
    sign: np.ndarray
    cost: np.ndarray
    upper: np.ndarray
    rows: sparse.csr_array
    weight: np.ndarray
    arcs: int


@dataclass(frozen=True)
class _Bounds:
    """Sums of quantities that are at least so much."""

    sums: sparse.csr_array
    least: np.ndarray

    def __len__(self) -> int:
        return len(self.least)


def whole_lengths(
    layout: Layout,
    scale: float,
    cuts: set[frozenset[int]],
    least: int | np.ndarray,
    progress: Progress,
) -> np.ndarray:
    """(a,) int64 number of quads along each arc.

    Parameters
    ----------
    scale:
        What lengths are multiplied with first.
    cuts:
        Sets of arcs that must not all be 0.
    least:
        What every arc has at least, or (a,) int64 each of them.
    """
    program = _program(layout, _sides(layout), scale, least)
    bounds = _lengths(cuts, program, layout)
    value = _dive(program, bounds, progress)
    if value is None and not np.any(least) and len(layout.rectangles) > SMALL:
        # Where every arc has a length none of the cuts is all 0.
        return whole_lengths(layout, scale, set(), 1, progress)
    if value is None:
        value = _branched(program, bounds)
    return value[: program.arcs]


def lengths_of_count(
    layout: Layout, scale: float, cuts: set[frozenset[int]], count: Count, progress: Progress
) -> np.ndarray | None:
    """As `whole_lengths` of least 0, with bounds of the number of quads; None where none were
    found."""
    sides = _sides(layout)
    program = _program(layout, sides, scale, 0)
    free = _lengths(cuts, program, layout)
    bounds = _counted(free, count, sides)
    if len(layout.rectangles) <= MANY:
        value = _dive(program, bounds, progress)
    else:
        none = np.full(len(program.base), np.inf)
        value = _relaxed(program, bounds, -none, none)
        value = None if value is None else _rounded(program, free, value, progress)
    if value is None and len(layout.rectangles) <= SMALL:
        value = _searched(program, bounds, FEW_BRANCHES)
    return None if value is None else value[: program.arcs]


def _sides(layout: Layout) -> sparse.csr_array:
    """(4 r, a) the arcs in the sums of each rectangle's four sides."""
    every = [side for rectangle in layout.rectangles for side in rectangle]
    row = np.repeat(np.arange(len(every)), [len(side) for side in every])
    column = np.array([half // 2 for side in every for half in side])
    shape = (len(every), len(layout.arc_track))
    return sparse.coo_array((np.ones(len(row)), (row, column)), shape=shape).tocsr()


def _program(
    layout: Layout, sides: sparse.csr_array, scale: float, least: int | np.ndarray
) -> _Program:
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
    return _Program(
        base,
        np.concatenate(quantity),
        np.concatenate(sign),
        np.concatenate(cost),
        np.concatenate(upper),
        sparse.hstack([sides, widths]).tocsr(),
        weight,
        arcs,
    )


def _lengths(cuts: set[frozenset[int]], program: _Program, layout: Layout) -> _Bounds:
    """At least 1 for each of the cuts, and `LEAST_BORDER` around each border: with fewer its edges
    lie on each other and the hole is shut."""
    loops = _borders(layout)
    ordered = sorted(sorted(cut) for cut in cuts) + loops
    row = np.repeat(np.arange(len(ordered)), [len(cut) for cut in ordered]).astype(np.int64)
    column = np.array([arc for cut in ordered for arc in cut], np.int64)
    shape = (len(ordered), len(program.base))
    sums = sparse.coo_array((np.ones(len(row)), (row, column)), shape=shape).tocsr()
    least = np.ones(len(ordered))
    least[len(ordered) - len(loops) :] = LEAST_BORDER
    return _Bounds(sums, least)


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


def _counted(bounds: _Bounds, count: Count, sides: sparse.csr_array) -> _Bounds:
    """The bounds and those of the number of quads, sum w h = sum w h0 + w0 h - w0 h0 nearly."""
    extent = (sides @ count.near).reshape(-1, 4)[:, :2]
    row = np.concatenate([np.zeros(len(count.near)), extent[:, ::-1].ravel()])
    row = row / max(count.most, 1.0)
    known = float((extent[:, 0] * extent[:, 1]).sum())
    least, most = ((bound + known) / max(count.most, 1.0) for bound in (count.least, count.most))
    both = sparse.csr_array(np.stack([row, -row]))
    return _Bounds(
        sparse.vstack([bounds.sums, both]).tocsr(), np.concatenate([bounds.least, [least, -most]])
    )


def _dive(
    program: _Program,
    bounds: _Bounds,
    progress: Progress,
    low: np.ndarray | None = None,
    high: np.ndarray | None = None,
) -> np.ndarray | None:
    """Whole numbers from low to high by linear programs, None where fixing has led to none."""
    low = np.full(len(program.base), -np.inf) if low is None else low
    high = np.full(len(program.base), np.inf) if high is None else high
    value = _relaxed(program, bounds, low, high)
    share = 1.0
    for _ in range(MOST_ROUNDS):
        progress.step(0.5)
        if value is None:
            return None
        half = np.flatnonzero(np.abs(value - np.rint(value)) > NEARLY_WHOLE)
        if not len(half):
            return np.rint(value).astype(np.int64)
        chosen = _one_of_each_piece(program, half)
        chosen = chosen[: max(1, int(share * len(chosen)))]
        down = np.floor(value[chosen])
        # A half lies between two that are as good; where the number of quads has made it another
        # part, the nearer is what that needs.
        part = value[chosen] - down
        even = np.abs(part - 0.5) < NEARLY_HALF
        wanted = np.where(even, _wanted(program, chosen), value[chosen])
        up = np.abs(down + 1.0 - wanted) < np.abs(down - wanted)
        next_low, next_high = low.copy(), high.copy()
        next_low[chosen[up]] = down[up] + 1.0
        next_high[chosen[~up]] = down[~up]
        found = _relaxed(program, bounds, next_low, next_high)
        if found is None and len(chosen) > 1:
            share *= 0.5
            continue
        if found is None:
            next_low, next_high = low.copy(), high.copy()
            next_low[chosen[~up]] = down[~up] + 1.0
            next_high[chosen[up]] = down[up]
            found = _relaxed(program, bounds, next_low, next_high)
        low, high, value = next_low, next_high, found
    return None


def _rounded(
    program: _Program, bounds: _Bounds, value: np.ndarray, progress: Progress
) -> np.ndarray | None:
    """Whole numbers near those of a linear program with bounds of the sum, None where none were
    found.

    Few numbers are parts of wholes then. Cleared under the bounds of the sum each would leave its
    part to another; so these go, and only numbers beside a part change by a whole one.
    """
    low, high = np.floor(value + NEARLY_WHOLE), np.ceil(value - NEARLY_WHOLE)
    near = (high > low).astype(float)
    rows = abs(program.rows)
    for _ in range(WIDER):
        found = _dive(program, bounds, progress, low, high)
        if found is not None:
            return found
        near = rows.T @ (rows @ near)
        low, high = low - (near > 0), high + (near > 0)
    return None


def _wanted(program: _Program, chosen: np.ndarray) -> np.ndarray:
    """The real value of quantities, back from the cost of their first step up."""
    # price(b + 1) - price(b) = weight (2 (b - x) + 1), and the first steps come first.
    rest = program.cost[chosen] / np.maximum(program.weight[chosen], 1e-300) - 1.0
    return program.base[chosen] - 0.5 * rest


def _one_of_each_piece(program: _Program, half: np.ndarray) -> np.ndarray:
    """The heaviest of the quantities `half` in each set that their rows connect."""
    part = program.rows[:, half]
    _, label = csgraph.connected_components(part.T @ part, directed=False)
    order = np.lexsort((half, -program.weight[half], label))
    first = np.concatenate([[True], np.diff(label[order]) > 0])
    chosen = half[order[first]]
    return chosen[np.argsort(-program.weight[chosen], kind="stable")]


def _reach(program: _Program, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Bounds of the steps for quantities within low and high."""
    least, most = np.zeros(len(program.cost)), program.upper.copy()
    touched = np.flatnonzero((np.isfinite(low) | np.isfinite(high))[program.quantity])
    # Steps of one kind stand in the order in which they are taken.
    kind = program.quantity[touched] * 2 + (program.sign[touched] < 0)
    order = np.argsort(kind, kind="stable")
    kind, touched = kind[order], touched[order]
    _, first, count = np.unique(kind, return_index=True, return_counts=True)
    rank = np.arange(len(kind)) - np.repeat(first, count)
    last = rank == np.repeat(count, count) - 1
    name, sign = program.quantity[touched], program.sign[touched]
    bottom, top = low[name] - program.base[name], high[name] - program.base[name]
    reach = np.where(sign > 0, top, -bottom) - rank
    need = np.where(sign > 0, bottom, -top) - rank
    cap = np.where(last, np.inf, 1.0)
    most[touched] = np.minimum(most[touched], np.clip(reach, 0.0, cap))
    least[touched] = np.minimum(np.clip(need, 0.0, cap), most[touched])
    return least, most


def _relaxed(
    program: _Program, bounds: _Bounds, low: np.ndarray, high: np.ndarray
) -> np.ndarray | None:
    """The quantities of the linear program, None where the bounds leave none."""
    least, most = _reach(program, low, high)
    steps = _steps(program)
    solution = linprog(
        program.cost,
        A_eq=program.rows @ steps,
        b_eq=-program.rows @ program.base,
        A_ub=-(bounds.sums @ steps) if len(bounds) else None,
        b_ub=bounds.sums @ program.base - bounds.least if len(bounds) else None,
        bounds=np.column_stack([least, most]),
        method="highs",
    )
    if solution.x is None:
        return None
    return program.base + steps @ solution.x


def _steps(program: _Program) -> sparse.csr_array:
    shape = (len(program.base), len(program.cost))
    place = program.quantity, np.arange(len(program.cost))
    return sparse.coo_array((program.sign, place), shape=shape).tocsr()


def _branched(program: _Program, bounds: _Bounds) -> np.ndarray:
    """Whole numbers by branch and bound.

    Raises
    ------
    RemeshError
        None were found with `MOST_BRANCHES` nodes, or there are none.
    """
    nodes = BRANCHES
    while nodes <= MOST_BRANCHES:
        found = _searched(program, bounds, nodes)
        if found is not None:
            return found
        nodes *= 4
    raise RemeshError("No whole numbers of quads suit the layout of a piece. Ask for more quads.")


def _searched(program: _Program, bounds: _Bounds, nodes: int) -> np.ndarray | None:
    """Whole numbers by branch and bound with so many nodes, None where they do not do."""
    steps = _steps(program)
    conditions = [LinearConstraint(program.rows @ steps, *([-program.rows @ program.base] * 2))]
    if len(bounds):
        lacking = bounds.least - bounds.sums @ program.base
        conditions.append(LinearConstraint(bounds.sums @ steps, lacking, np.inf))
    solution = milp(
        program.cost,
        constraints=conditions,
        bounds=Bounds(np.zeros(len(program.cost)), program.upper),
        integrality=np.ones(len(program.cost)),
        options={"node_limit": nodes, "mip_rel_gap": GAP},
    )
    if solution.x is None:
        return None
    return np.rint(program.base + steps @ solution.x).astype(np.int64)
