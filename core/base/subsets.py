"""Some of the rows of an array, and where each row stands among them."""

from __future__ import annotations

import numpy as np


def places_in(rows: np.ndarray, count: int) -> np.ndarray:
    """(count,) int64 place of each of `count` rows among `rows`, its last one; -1 where it is not
    among them."""
    place = np.full(count, -1)
    place[rows] = np.arange(len(rows))
    return place
