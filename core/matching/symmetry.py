"""What the symmetries of a shape have in common."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Symmetry:
    """A motion that brings a shape onto itself.

    Attributes
    ----------
    point:
        (3,) float64 of what stays in place, a plane or an axis, the point nearest to the middle of
        the shape.
    error:
        Root mean square distance between the shape and its image, in length.
    score:
        0 to 1: 1 where the image lies on the shape, 0 at the limit of what counts as symmetric.
    pairs:
        (p, 2) int64 rows of the umbilics that are taken to each other.
    """

    point: np.ndarray
    error: float
    score: float
    pairs: np.ndarray
