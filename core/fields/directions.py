"""Fields of directions at the vertices of a surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class DirectionField:
    """One of `symmetry` equal directions at every vertex, and how much it matters there.

    Attributes
    ----------
    direction, normal:
        (n, 3) float64 unit tangents and unit normals; NaN where there is no direction.
    magnitude:
        (n,) float64 weight of the direction, in the unit of what it was made from: of curvature
        the gap k1 - k2, in 1 / length.
    symmetry:
        How many equally spaced directions are the same: 2 for lines, 4 for crosses.
    """

    direction: np.ndarray
    normal: np.ndarray
    magnitude: np.ndarray
    symmetry: int = 2

    @property
    def across(self) -> np.ndarray:
        """(n, 3) the direction turned by a right angle to the left about the normal."""
        return np.cross(self.normal, self.direction)
