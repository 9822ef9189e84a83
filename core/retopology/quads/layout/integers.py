"""Whole numbers of quads for the arcs of a layout, as near to their lengths as can be.

Opposite sides of every rectangle hold equally many. Each arc stands in the sums of two sides, and
so does each width with its two sides: a flow on a bidirected graph with convex costs, whose linear
program has solutions in halves (Campen, Bommes & Kobbelt 2015, 10.1145/2766892; Heistermann,
Warnett & Bommes 2023, 10.1145/3592437). Halves are cleared by fixing one number in each of their
connected pieces at a time.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.optimize import Bounds, LinearConstraint, linprog, milp
from scipy.sparse import csgraph

from ....base.progress import Progress
from .rectangles import Layout

# Single arcs matter this much beside the widths of rectangles.
ARC_WEIGHT = 0.1
# Widths weigh by what lies across, within these bounds.
LEAST_ACROSS, MOST_ACROSS = 0.5, 30.0
# Unit steps up and down that have a cost of their own; farther ones cost like the last.
STEPS = 4
# Rounds of fixing before branch and bound takes over, and its nodes and gap.
MOST_ROUNDS, BRANCHES, GAP = 60, 2000, 0.02
NEARLY_WHOLE = 1e-6


@dataclass(frozen=True)
class _Program:
    """min cost s for base + steps s, rows of it 0, some sums of arcs at least 1."""

    base: np.ndarray
    quantity: np.ndarray  # of each step
    sign: np.ndarray
    cost: np.ndarray
    upper: np.ndarray
    rows: sparse.csr_array
    weight: np.ndarray
    arcs: int


def whole_lengths(
    layout: Layout,
    scale: float,
    cuts: set[frozenset[int]],
    least: int,
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
        What every arc has at least: 0 or 1.
    """
    program = _program(layout, scale, least)
    sums = _sums(cuts, program)
    value = _dive(program, sums, progress)
    if value is None:
        value = _branched(program, sums)
    return value[: program.arcs]


def _program(layout: Layout, scale: float, least: int) -> _Program:
    length = layout.length * scale
    arcs, count = len(length), len(layout.rectangles)
    every = [side for rectangle in layout.rectangles for side in rectangle]
    row = np.repeat(np.arange(len(every)), [len(side) for side in every])
    column = np.array([half // 2 for side in every for half in side])
    sides = sparse.coo_array((np.ones(len(row)), (row, column)), shape=(4 * count, arcs)).tocsr()
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


def _sums(cuts: set[frozenset[int]], program: _Program) -> sparse.csr_array:
    ordered = sorted(sorted(cut) for cut in cuts)
    row = np.repeat(np.arange(len(ordered)), [len(cut) for cut in ordered]).astype(np.int64)
    column = np.array([arc for cut in ordered for arc in cut], np.int64)
    shape = (len(ordered), len(program.base))
    return sparse.coo_array((np.ones(len(row)), (row, column)), shape=shape).tocsr()


def _dive(program: _Program, sums: sparse.csr_array, progress: Progress) -> np.ndarray | None:
    """Whole numbers by linear programs, None where fixing has led to none."""
    low = np.full(len(program.base), -np.inf)
    high = np.full(len(program.base), np.inf)
    value = _relaxed(program, sums, low, high)
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
        wanted = _wanted(program, chosen)
        up = np.abs(down + 1.0 - wanted) < np.abs(down - wanted)
        next_low, next_high = low.copy(), high.copy()
        next_low[chosen[up]] = down[up] + 1.0
        next_high[chosen[~up]] = down[~up]
        found = _relaxed(program, sums, next_low, next_high)
        if found is None and len(chosen) > 1:
            share *= 0.5
            continue
        if found is None:
            next_low, next_high = low.copy(), high.copy()
            next_low[chosen[~up]] = down[~up] + 1.0
            next_high[chosen[up]] = down[up]
            found = _relaxed(program, sums, next_low, next_high)
        low, high, value = next_low, next_high, found
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


def _bounds(program: _Program, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
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
    program: _Program, sums: sparse.csr_array, low: np.ndarray, high: np.ndarray
) -> np.ndarray | None:
    """The quantities of the linear program, None where the bounds leave none."""
    least, most = _bounds(program, low, high)
    steps = _steps(program)
    solution = linprog(
        program.cost,
        A_eq=program.rows @ steps,
        b_eq=-program.rows @ program.base,
        A_ub=-(sums @ steps) if sums.shape[0] else None,
        b_ub=sums @ program.base - 1.0 if sums.shape[0] else None,
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


def _branched(program: _Program, sums: sparse.csr_array) -> np.ndarray:
    """Whole numbers by branch and bound; a solution exists whatever the cuts."""
    steps = _steps(program)
    conditions = [LinearConstraint(program.rows @ steps, *([-program.rows @ program.base] * 2))]
    if sums.shape[0]:
        conditions.append(LinearConstraint(sums @ steps, 1.0 - sums @ program.base, np.inf))
    nodes = BRANCHES
    while True:
        solution = milp(
            program.cost,
            constraints=conditions,
            bounds=Bounds(np.zeros(len(program.cost)), program.upper),
            integrality=np.ones(len(program.cost)),
            options={"node_limit": nodes, "mip_rel_gap": GAP},
        )
        if solution.x is not None:
            return np.rint(program.base + steps @ solution.x).astype(np.int64)
        nodes *= 4
