"""Charges taken out of a field: its directions turn as little as that needs, in a few rings.

Moving a charge over an edge changes the edge's turn by a full one. The directions around the
paths then turn so that all turns become small again: a least squares problem on a few rings, and
the directions beyond stay as they are. Where every turn ends up below half a turn, the field has
the wanted charges and no others; where one does not, its part of the problem is weighted anew and
widened, then made sure of (`least_excess`), and what cannot be helped stays.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from ...base.progress import Progress
from ...base.subsets import places_in, spans
from ...fields.multigrid import solve_diagonal, solve_part
from .charge_paths import Paths, charge_paths, joined_places, staying
from .least_excess import with_least_excess
from .turns import Turns

# Rings of directions beside a path that turn: these, and one more for each edge of the path, up
# to so many; as many times that as charges go along it.
LEAST_RINGS, MOST_RINGS = 2, 8
# A turn up to this share of half a turn is certain in the presence of round-off.
CERTAIN = 0.98
# Rounds of weighting anew, those of them that also widen, and how many may pass without fewer turns
# that are too large: most of what settles does so in one.
ROUNDS, WIDENING, PATIENCE = 20, 6, 3
# Rings around a turn that is too large in which the directions are sought again.
AROUND = 8
# Turns above this share of half a turn weigh more in the next round, by the square of the excess:
# least squares become the least largest turn (Lawson 1961).
EASY = 0.7
# What is left in a round of the stiffness beside a turn that is too large. Chosen by separatrices
# of an ellipsoid with 5 % noise, confirmed on three others of them.
SOFTER = 0.02
# Rings around turns that are still too large within which they are made as small as can be.
SURE_RINGS = (1, 2, 4, 8, 16, 32)
# Stored entries of a system up to which it is solved exactly: 10,000 directions take .03 s, three
# times as long as by the diagonal; late rounds, whose weights lie far apart, have fewer.
EXACT = 60_000
# A trace of stiffness keeps the directions of an island without a fixed one from floating.
FLOATING = 1e-9


@dataclass(frozen=True)
class Settled:
    """What became of the charges.

    Attributes
    ----------
    angle:
        (n,) float64 by which each direction turns, times the symmetry; 0 where it stays.
    left:
        (places,) int charges that are left: those that had nothing to cancel with, where they were,
        and opposite ones on both sides of edges that cannot but turn too far.
    """

    angle: np.ndarray
    left: np.ndarray


def balances(turns: Turns, charge: np.ndarray, held: np.ndarray) -> bool:
    """Whether charges (places,) can all cancel with held directions (n,) bool where they are."""
    joined = joined_places(turns, ~(held[turns.tail] & held[turns.head]))
    return not _surplus(charge, np.zeros(len(charge)), joined).any()


def settle(
    turns: Turns,
    charge: np.ndarray,
    priority: np.ndarray,
    held: np.ndarray,
    stiffness: np.ndarray,
    progress: Progress,
    exact: bool = True,
    again: bool = False,
) -> Settled:
    """Turn a field so that charges leave it.

    Parameters
    ----------
    charge:
        (places,) int to be taken out of each place.
    priority:
        (places,) float64: where the charges do not balance, those of the highest one stay.
    held:
        (n,) bool directions that must not turn.
    stiffness:
        (n,) float64 by which a direction resists to turning, beside the weights of the edges.
    exact:
        Whether turns that least squares leave too large are made sure of.
    again:
        Whether what cannot leave may be left as other charges, for another try; else charges stay
        where they were, so that the others leave.
    """
    usable = ~(held[turns.tail] & held[turns.head])
    joined = joined_places(turns, usable)
    left = _surplus(charge, priority, joined)
    charge = charge - left
    while charge.any():
        paths = charge_paths(turns, usable, charge)
        angle = _turned(turns, paths, held, stiffness, progress, exact)
        turn = turns.turn - 2.0 * np.pi * paths.flow + angle[turns.head] - angle[turns.tail]
        too_far = np.flatnonzero(np.abs(turn) > np.pi)
        if not len(too_far):
            return Settled(angle, left)
        # Such a turn is a smaller one, and charges on both sides.
        if again:
            over = np.rint(turn / (2.0 * np.pi)).astype(np.int64)
            left = np.append(left, 0)
            np.subtract.at(left, turns.left, over)
            np.add.at(left, turns.right, over)
            return Settled(angle, left[:-1])
        # Rather those stay that were there.
        stay = staying(paths, charge, _nearest(turns, paths, too_far))
        left, charge = left + stay, charge - stay
    return Settled(np.zeros(turns.directions), left)


def _surplus(charge: np.ndarray, priority: np.ndarray, joined: np.ndarray) -> np.ndarray:
    """(places,) int the charges that have nothing to cancel with, of the highest priority."""
    places = np.flatnonzero(charge)
    total = np.bincount(joined[places], weights=charge[places], minlength=joined.max() + 1)
    total[joined[-1]] = 0.0
    surplus = np.zeros_like(charge)
    mine = places[np.sign(charge[places]) == np.sign(total[joined[places]])]
    mine = mine[np.lexsort((-priority[mine], joined[mine]))]
    size = np.abs(charge[mine])
    before = np.cumsum(size) - size
    group = joined[mine]
    first = np.searchsorted(group, group, side="left")
    # Of a charge of several units as many stay as are too many.
    over = np.abs(total[group]).astype(np.int64) - (before - before[first])
    surplus[mine] = np.sign(charge[mine]) * np.clip(over, 0, size)
    return surplus


def _nearest(turns: Turns, paths: Paths, edge: np.ndarray) -> np.ndarray:
    """Rows of the paths that are nearest to some edges, one for those that touch each other."""
    on = np.concatenate([turns.tail[paths.edge], turns.head[paths.edge]])
    path = np.zeros(turns.directions, np.int64)
    path[on] = np.tile(paths.path, 2)
    shape = turns.directions, turns.directions
    graph = sparse.coo_array((np.ones(len(turns.tail)), (turns.tail, turns.head)), shape)
    away, _, near = csgraph.dijkstra(
        graph.tocsr(), directed=False, indices=np.unique(on), unweighted=True, min_only=True,
        return_predecessors=True,
    )  # fmt: skip
    joined = sparse.coo_array((np.ones(len(edge)), (turns.tail[edge], turns.head[edge])), shape)
    group = csgraph.connected_components(joined, directed=False)[1]
    ends = np.unique([turns.tail[edge], turns.head[edge]])
    ends = ends[np.argsort(away[ends], kind="stable")]
    _, first = np.unique(group[ends], return_index=True)
    # What turns with a path is joined to it.
    return np.unique(path[near[ends[first]]])


def _turned(
    turns: Turns,
    paths: Paths,
    held: np.ndarray,
    stiffness: np.ndarray,
    progress: Progress,
    exact: bool,
) -> np.ndarray:
    """(n,) angles with which the charges move."""
    ring = _ring(turns)
    wanted = turns.turn - 2.0 * np.pi * paths.flow
    angle, too_far = _by_least_squares(
        turns, ring, wanted, _zones(ring, turns, paths, held), held, stiffness, progress
    )
    for rings in SURE_RINGS if exact else ():
        if not len(too_far):
            break
        around = np.full(turns.directions, -1)
        around[turns.tail[too_far]] = around[turns.head[too_far]] = rings
        _spread(ring, around, held)
        angle = with_least_excess(turns, wanted, around >= 0, angle, progress)
        turn = np.abs(wanted + angle[turns.head] - angle[turns.tail])
        too_far = np.flatnonzero(turn >= CERTAIN * np.pi)
    return angle


def _by_least_squares(
    turns: Turns,
    ring: sparse.csr_array,
    wanted: np.ndarray,
    budget: np.ndarray,
    held: np.ndarray,
    stiffness: np.ndarray,
    progress: Progress,
) -> tuple[np.ndarray, np.ndarray]:
    """(n,) angles that make the wanted turns (e,) small, weighted anew in rounds, and the edges
    that turn too far still.

    Parameters
    ----------
    budget:
        (n,) int as of `_zones`; changed in place where the zones are widened.
    """
    free = budget >= 0
    weight, stiffness = turns.weight.copy(), stiffness.copy()
    angle = np.zeros(turns.directions)
    moving = np.flatnonzero(free)
    fewest, idle = len(turns.turn) + 1, 0
    for number in range(ROUNDS):
        progress.step(number / ROUNDS)
        beside = _Beside.of(ring, moving)
        _least_squares(turns, beside, weight, stiffness, wanted, angle, progress.quiet())
        # All turns that are too large are among these: what moves is what lies around them.
        some = beside.edge
        turn = np.abs(wanted[some] + angle[turns.head[some]] - angle[turns.tail[some]])
        too_far = some[turn >= CERTAIN * np.pi]
        idle = 0 if len(too_far) < fewest else idle + 1
        fewest = min(len(too_far), fewest)
        if not len(too_far) or idle >= PATIENCE:
            break
        ends = np.unique([turns.tail[too_far], turns.head[too_far]])
        # An edge between two that move is among them twice.
        weight[some] = weight[some] * np.maximum(turn / (EASY * np.pi), 1.0) ** 2
        stiffness[ends] *= SOFTER
        if number < WIDENING:
            budget[ends] = np.maximum(budget[ends], number + 1)
            _spread(ring, budget, held, ends)
            free = budget >= 0
        # What lies farther away is as good as it was.
        around = np.full(turns.directions, -1)
        around[ends] = AROUND
        _spread(ring, around, ~free, ends)
        moving = np.flatnonzero(around >= 0)
    return angle, too_far


def _ring(turns: Turns) -> sparse.csr_array:
    """(n, n) the edges that directions have between them, by their numbers."""
    edge = np.flatnonzero(turns.tail != turns.head).astype(np.int32)
    tail, head = turns.tail[edge], turns.head[edge]
    ends = np.concatenate([tail, head]), np.concatenate([head, tail])
    ring = sparse.coo_array((np.concatenate([edge, edge]), ends), shape=(turns.directions,) * 2)
    # Two edges between the same directions are two: their numbers must not be summed.
    ring.has_canonical_format = True
    return ring.tocsr()


@dataclass(frozen=True)
class _Beside:
    """The surroundings of some directions (r,), `rows`: b edges, in their order.

    Attributes
    ----------
    row:
        (b,) int64 which of them the edge leaves.
    edge, other:
        (b,) int32 its number, and the direction at its other end.
    """

    rows: np.ndarray
    row: np.ndarray
    edge: np.ndarray
    other: np.ndarray

    @classmethod
    def of(cls, ring: sparse.csr_array, rows: np.ndarray) -> _Beside:
        count = np.diff(ring.indptr)[rows]
        at = spans(ring.indptr[rows], count)
        row = np.repeat(np.arange(len(rows)), count)
        return cls(rows, row, ring.data[at], ring.indices[at])


def _zones(ring: sparse.csr_array, turns: Turns, paths: Paths, held: np.ndarray) -> np.ndarray:
    """(n,) int how many rings beyond each direction turn with the paths, -1 where it stays."""
    budget = np.full(turns.directions, -1)
    rings = (np.minimum(LEAST_RINGS + paths.reach, MOST_RINGS) * paths.amount)[paths.path]
    for ends in (turns.tail, turns.head):
        np.maximum.at(budget, ends[paths.edge], rings)
    _spread(ring, budget, held)
    return budget


def _spread(
    ring: sparse.csr_array,
    budget: np.ndarray,
    held: np.ndarray,
    changed: np.ndarray | None = None,
) -> None:
    """Hand budgets on to the neighbours, one less with every edge, up to what is held; from the
    changed ones (k,) alone where all others have been."""
    budget[held] = -1
    first = np.flatnonzero(budget > 0) if changed is None else changed[budget[changed] > 0]
    first = first[np.argsort(budget[first], kind="stable")]
    start = np.searchsorted(budget[first], np.arange(budget[first].max(initial=-1) + 2))
    handed, once = first[:0], np.empty(len(budget), np.int32)
    for level in range(len(start) - 2, 0, -1):
        if not len(handed) and start[level] == start[level + 1]:
            # Beside many charges the first levels are far above those that all others come to.
            continue
        rows = np.concatenate([handed, first[start[level] : start[level + 1]]])
        rows = rows[budget[rows] == level]
        to = ring.indices[spans(ring.indptr[rows], ring.indptr[rows + 1] - ring.indptr[rows])]
        to = to[(budget[to] < level - 1) & ~held[to]]
        budget[to] = level - 1
        # One that several hand to would hand on as often.
        once[to] = np.arange(len(to))
        handed = to[once[to] == np.arange(len(to))]


def _least_squares(
    turns: Turns,
    beside: _Beside,
    weight: np.ndarray,
    stiffness: np.ndarray,
    wanted: np.ndarray,
    angle: np.ndarray,
    progress: Progress,
) -> None:
    """Set the angles of the directions so that the weighted squares of the turns over the edges
    beside them, and of the angles, are least."""
    rows, row = beside.rows, beside.row
    count = len(rows)
    angle[rows] = 0.0
    w = weight[beside.edge]
    leaving = turns.tail[beside.edge] == rows[row]
    turn = wanted[beside.edge]
    pull = w * (np.where(leaving, turn, -turn) + angle[beside.other])
    diagonal = np.bincount(row, weights=w, minlength=count) + stiffness[rows]
    other = places_in(rows, turns.directions)[beside.other]
    inside, own = np.flatnonzero(other >= 0), np.arange(count)
    entries = np.concatenate([diagonal * (1.0 + FLOATING), -w[inside]])
    at = np.concatenate([own, row[inside]]), np.concatenate([own, other[inside]])
    matrix = sparse.coo_array((entries, at), shape=(count, count))
    # What is too exact for a few small systems at once is soon good enough for many, and those
    # solvers need no sorted rows.
    large = len(entries) > EXACT
    matrix.has_canonical_format = large
    right = np.bincount(row, weights=pull, minlength=count)
    angle[rows] = (solve_diagonal if large else solve_part)(matrix.tocsr(), right, progress)
