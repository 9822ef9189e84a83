"""One number for each umbilic of a detection, by which list, glyphs and files call it."""

from __future__ import annotations

import numpy as np

from .result import Umbilics


def numbers(candidates: Umbilics) -> np.ndarray:
    """(k,) int64 from 1: those that rise out of the noise first, the most persistent first.

    They hang on the detection alone: no filter renumbers what is left, and what the automatic
    filter keeps are the first. Those next to an open border come last.

    Examples
    --------
    On an ellipsoid of `vertices` and `triangles`, as in `detect`:

    >>> core.numbers(core.detect(vertices, triangles).candidates).tolist()
    [1, 2, 3, 4]
    """
    persistence = np.nan_to_num(candidates.persistence, nan=-1.0, posinf=np.inf)
    doubtful = ~candidates.resolved & np.isfinite(candidates.persistence)
    order = np.lexsort((-persistence, doubtful, candidates.at_border))
    found = np.empty(len(order), np.int64)
    found[order] = np.arange(1, len(order) + 1)
    return found
