"""Triangles in the plane, whose corners are complex numbers."""

from __future__ import annotations

import numpy as np


def corner_angles(corner: np.ndarray) -> np.ndarray:
    """(3 m,) angle at each corner of triangles (m, 3), negative where they lie upside down."""
    out = np.roll(corner, -1, axis=1) - corner
    back = np.roll(corner, 1, axis=1) - corner
    return np.angle(back * out.conj()).ravel()


def doubled_areas(corner: np.ndarray) -> np.ndarray:
    """(m,) twice the areas of triangles (m, 3), negative where they lie upside down."""
    a, b, c = corner.T
    return ((b - a).conj() * (c - a)).imag
