"""Raw finds of methods I and C, before kinds, persistence and filters."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class RawUmbilics:
    """Points with an index, one row each.

    Attributes
    ----------
    triangle:
        (k,) int64 rows of the surface's triangles.
    barycentric:
        (k, 3) float64 weights of its corners.
    index:
        (k,) float64 multiples of one half.
    vertex:
        (k,) int64 vertex of the surface that was found, -1 where the point lies in a triangle.
    conformal_scale:
        (n,) float64 length in the plane per length on the surface (method C), else NaN.
    warnings:
        Sentences for the user.
    """

    triangle: np.ndarray
    barycentric: np.ndarray
    index: np.ndarray
    vertex: np.ndarray
    conformal_scale: np.ndarray
    warnings: list[str] = field(default_factory=list)

    def __len__(self) -> int:
        return len(self.index)

    def select(self, rows: np.ndarray) -> RawUmbilics:
        """The given rows (a mask or indices) of the finds."""
        return RawUmbilics(
            self.triangle[rows],
            self.barycentric[rows],
            self.index[rows],
            self.vertex[rows],
            self.conformal_scale,
            self.warnings,
        )
