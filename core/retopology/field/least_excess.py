"""Turns kept below half a turn where least squares do not get there, for certain or not at all.

The largest of linear expressions is made least by a linear program (Wagner 1959,
10.1080/01621459.1959.10501506), which also tells where it cannot be done.
"""

from __future__ import annotations

import numpy as np
import scipy
from scipy import sparse
from scipy.sparse import csgraph

from ...base.progress import Progress
from ...base.subsets import places_in
from .turns import Turns

# Turns wanted, in half turns: with some room for round-off.
WANTED = 0.95
# What a turn costs where it is larger than that, in what the largest of the others costs: one is
# enough for none to be larger that need not be.
DEAR = 2.0
# Edges of a piece beyond which it is not looked at, and of pieces that are looked at at once: what
# a program takes grows with their square, and from a few hundred on no longer with the calls.
MOST, TOGETHER = 6_000, 600


def with_least_excess(
    turns: Turns,
    wanted: np.ndarray,
    moving: np.ndarray,
    angle: np.ndarray,
    progress: Progress,
) -> np.ndarray:
    """(n,) angles of which the moving ones (n,) bool keep the turns over all edges small, each of
    their connected pieces for itself; those of pieces that are too large stay.

    Parameters
    ----------
    wanted:
        (e,) float64 turns that the edges would have without any angle.
    angle:
        (n,) float64 angles of all directions; the others keep theirs.
    """
    angle = angle.copy()
    one, two = moving[turns.tail], moving[turns.head]
    some = np.flatnonzero(one | two)
    inside = some[one[some] & two[some]]
    count = turns.directions
    graph = sparse.coo_array(
        (np.ones(len(inside), np.int8), (turns.tail[inside], turns.head[inside])),
        shape=(count, count),
    )
    piece = csgraph.connected_components(graph, directed=False)[1]
    piece = np.where(one[some], piece[turns.tail[some]], piece[turns.head[some]])
    order = np.argsort(piece, kind="stable")
    some, piece = some[order], piece[order]
    start = np.append(np.flatnonzero(np.diff(piece, prepend=-1)), len(some))
    first = 0
    while first < len(start) - 1:
        progress.ask()
        end = int(np.searchsorted(start, start[first] + TOGETHER, side="right")) - 1
        end = max(end, first + 1)
        if start[end] - start[first] <= MOST:
            _solve(turns, wanted, moving, angle, some[start[first] : start[end]])
        first = end
    return angle


def _solve(
    turns: Turns, wanted: np.ndarray, moving: np.ndarray, angle: np.ndarray, some: np.ndarray
) -> None:
    """Set the moving angles at the edges `some`."""
    ends = np.concatenate([turns.tail[some], turns.head[some]])
    rows = np.unique(ends[moving[ends]])
    number = places_in(rows, turns.directions)
    tail, head = number[turns.tail[some]], number[turns.head[some]]
    before = angle[rows]
    angle[rows] = 0.0
    turn = wanted[some] + angle[turns.head[some]] - angle[turns.tail[some]]
    count, edges = len(rows), len(some)
    own = np.arange(edges)
    one, two = head >= 0, tail >= 0
    difference = sparse.coo_array(
        (
            np.concatenate([np.ones(one.sum()), -np.ones(two.sum())]),
            (np.concatenate([own[one], own[two]]), np.concatenate([head[one], tail[two]])),
        ),
        shape=(edges, count),
    )
    excess, largest = -sparse.eye_array(edges), sparse.coo_array(-np.ones((edges, 1)))
    found = scipy.optimize.linprog(
        np.concatenate([np.zeros(count), np.full(edges, DEAR), [1.0]]),
        A_ub=sparse.block_array(
            [[difference, excess, largest], [-difference, excess, largest]], format="csr"
        ),
        b_ub=np.concatenate([-turn, turn]),
        bounds=np.array(
            [[-np.inf, np.inf]] * count + [[0.0, np.inf]] * edges + [[0.0, WANTED * np.pi]]
        ),
        method="highs",
    )
    angle[rows] = before if found.x is None else found.x[:count]
