"""A median that gives more room to what is larger."""

from __future__ import annotations

import numpy as np


def weighted_median(values: np.ndarray, weights: np.ndarray) -> float:
    """The value below which half of the weights lie; 0 of none."""
    if len(values) == 0:
        return 0.0
    order = np.argsort(values)
    share = np.cumsum(weights[order])
    return float(values[order[np.searchsorted(share, 0.5 * share[-1])]])
