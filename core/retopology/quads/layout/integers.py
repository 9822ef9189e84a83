"""Whole numbers of quads for the arcs of a layout, as near to their lengths as can be.

Opposite sides of every rectangle hold equally many. Each arc stands in the sums of two sides, and
so does each width with its two sides: a flow on a bidirected graph with convex costs, whose linear
program has solutions in halves (Campen, Bommes & Kobbelt 2015, 10.1145/2766892; Heistermann,
Warnett & Bommes 2023, 10.1145/3592437). Halves are cleared by fixing one number in each of their
connected pieces at a time. How many quads there are is a sum of products of widths; near numbers
that are known it is linear, and bounds on it are two more rows.
"""

from __future__ import annotations

import numpy as np
import scipy
from scipy.sparse import csgraph

from ....base.errors import RemeshError
from ....base.progress import Progress
from .integer_program import (
    Count,
    LeastSums,
    Program,
    lengths_of_cuts,
    program_of,
    sides_of,
    with_count,
)
from .rectangles import Layout

# Rounds of fixing before branch and bound takes over, its nodes at first and at most, those for a
# number of quads that is only wished for, and its gap.
MOST_ROUNDS, BRANCHES, MOST_BRANCHES, FEW_BRANCHES, GAP = 60, 2000, 50_000, 200, 0.02
# How often numbers beside parts of wholes get more room.
WIDER = 3
# Rectangles of a layout for which branch and bound is quick, and for which linear programs with
# bounds of the number of quads are.
SMALL, MANY = 60, 300
NEARLY_WHOLE, NEARLY_HALF = 1e-6, 1e-3


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
    program = program_of(layout, sides_of(layout), scale, least)
    bounds = lengths_of_cuts(cuts, program, layout)
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
    sides = sides_of(layout)
    program = program_of(layout, sides, scale, 0)
    free = lengths_of_cuts(cuts, program, layout)
    bounds = with_count(free, count, sides)
    if len(layout.rectangles) <= MANY:
        value = _dive(program, bounds, progress)
    else:
        none = np.full(len(program.base), np.inf)
        value = _relaxed(program, bounds, -none, none)
        value = None if value is None else _rounded(program, free, value, progress)
    if value is None and len(layout.rectangles) <= SMALL:
        value = _searched(program, bounds, FEW_BRANCHES)
    return None if value is None else value[: program.arcs]


def _dive(
    program: Program,
    bounds: LeastSums,
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
        wanted = np.where(even, program.wanted(chosen), value[chosen])
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
    program: Program, bounds: LeastSums, value: np.ndarray, progress: Progress
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


def _one_of_each_piece(program: Program, half: np.ndarray) -> np.ndarray:
    """The heaviest of the quantities `half` in each set that their rows connect."""
    part = program.rows[:, half]
    _, label = csgraph.connected_components(part.T @ part, directed=False)
    order = np.lexsort((half, -program.weight[half], label))
    first = np.concatenate([[True], np.diff(label[order]) > 0])
    chosen = half[order[first]]
    return chosen[np.argsort(-program.weight[chosen], kind="stable")]


def _reach(program: Program, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
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
    program: Program, bounds: LeastSums, low: np.ndarray, high: np.ndarray
) -> np.ndarray | None:
    """The quantities of the linear program, None where the bounds leave none."""
    least, most = _reach(program, low, high)
    steps = program.steps
    solution = scipy.optimize.linprog(
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


def _branched(program: Program, bounds: LeastSums) -> np.ndarray:
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


def _searched(program: Program, bounds: LeastSums, nodes: int) -> np.ndarray | None:
    """Whole numbers by branch and bound with so many nodes, None where they do not do."""
    steps = program.steps
    wanted = -program.rows @ program.base
    conditions = [scipy.optimize.LinearConstraint(program.rows @ steps, wanted, wanted)]
    if len(bounds):
        lacking = bounds.least - bounds.sums @ program.base
        conditions.append(scipy.optimize.LinearConstraint(bounds.sums @ steps, lacking, np.inf))
    solution = scipy.optimize.milp(
        program.cost,
        constraints=conditions,
        bounds=scipy.optimize.Bounds(np.zeros(len(program.cost)), program.upper),
        integrality=np.ones(len(program.cost)),
        options={"node_limit": nodes, "mip_rel_gap": GAP},
    )
    if solution.x is None:
        return None
    return np.rint(program.base + steps @ solution.x).astype(np.int64)
