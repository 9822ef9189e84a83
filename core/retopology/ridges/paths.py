"""Segments joined end to end, in order, all paths at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph


@dataclass(frozen=True)
class Paths:
    """Paths of m segments; each segment is in one of them.

    Attributes
    ----------
    start:
        (l + 1,) int64: the segments of path i are rows start[i]:start[i + 1].
    segment, forward:
        (m,) int64 segments in order, and bool whether they run from their first end to their
        second.
    closed:
        (l,) bool, True where the last segment ends at the first one's beginning.
    """

    start: np.ndarray
    segment: np.ndarray
    forward: np.ndarray
    closed: np.ndarray

    def __len__(self) -> int:
        return len(self.closed)


def ordered_paths(ends: np.ndarray) -> Paths:
    """Paths of segments between nodes, none of which has more than two segments.

    By doubling steps along both directions of every segment: log2 of the longest path in rounds.

    Parameters
    ----------
    ends:
        (m, 2) int64 names of the nodes at both ends, any numbers.
    """
    m = len(ends)
    names, node = np.unique(ends, return_inverse=True)
    node = node.reshape(-1, 2)
    # Directed segment 2 j runs along segment j, 2 j + 1 against it.
    tail, head = node.ravel(), node[:, ::-1].ravel()
    order = np.argsort(tail, kind="stable")
    leaving = np.searchsorted(tail[order], np.arange(len(names) + 1))
    count = np.diff(leaving)
    first = order[np.minimum(leaving[:-1], max(2 * m - 1, 0))] if m else np.zeros(0, np.int64)
    second = order[leaving[1:] - 1] if m else first
    back = np.arange(2 * m) ^ 1
    # At its head a directed segment goes on with the segment that is not its own reverse.
    onward = np.where(first[head] == back, second[head], first[head])
    onward = np.where(count[head] < 2, np.arange(2 * m), onward)

    graph = sparse.coo_array((np.ones(m), (node[:, 0], node[:, 1])), shape=(len(names),) * 2)
    pieces, label = csgraph.connected_components(graph, directed=False)
    closed = np.ones(pieces, bool)
    closed[label[count < 2]] = False
    # A loop is cut at its first node: the segments that run into it stop there.
    _, cut = np.unique(label, return_index=True)
    stops = np.isin(head, cut[closed])
    onward[stops] = np.flatnonzero(stops)

    left = (onward != np.arange(2 * m)).astype(np.int64)
    step = onward
    while True:
        following = step[step]
        if np.array_equal(following, step):
            break
        left = left + left[step]
        step = following
    # Of the two directions of a path the one whose last segment has the smaller number.
    chosen = np.flatnonzero(step < step[back])
    piece = label[tail[chosen]]
    order = np.lexsort((-left[chosen], piece))
    run = chosen[order]
    start = np.concatenate([[0], np.cumsum(np.bincount(piece, minlength=pieces))])
    return Paths(start.astype(np.int64), run // 2, run % 2 == 0, closed)
