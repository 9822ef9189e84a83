"""Some of the rows of an array: where each stands among them, and those that follow one another."""

from __future__ import annotations

import numpy as np


def places_in(rows: np.ndarray, count: int) -> np.ndarray:
    """(count,) int64 place of each of `count` rows among `rows`, its last one; -1 where it is not
    among them."""
    place = np.full(count, -1)
    place[rows] = np.arange(len(rows))
    return place


def spans(first: np.ndarray | int, count: np.ndarray) -> np.ndarray:
    """(sum of count,) int64 first[0], first[0] + 1, … (count[0] of them), then those of first[1],
    and so on; `first` (k,) or one for all, `count` (k,) whole numbers."""
    begin = np.cumsum(count) - count
    return np.arange(int(np.sum(count))) + np.repeat(first - begin, count)
