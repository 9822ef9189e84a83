"""Surface types from the signs of mean and Gaussian curvature (Besl & Jain 1986)."""

from __future__ import annotations

import numpy as np

from ..mesh.surface import Surface

SURFACE_TYPES = (
    "peak",
    "pit",
    "ridge",
    "valley",
    "flat",
    "minimal",
    "saddle ridge",
    "saddle valley",
)
"""Names of the codes 0 to 7. With outward normals a convex place is a peak: a sphere's
curvatures are positive. On an open surface the side that the normals point to decides."""

PEAK, PIT, RIDGE, VALLEY, FLAT, MINIMAL, SADDLE_RIDGE, SADDLE_VALLEY = range(8)

# Rows by the sign of H, columns by that of K: 0, 1 and, as the last one, -1.
_TYPE_BY_SIGNS = np.array(
    [[FLAT, FLAT, MINIMAL], [RIDGE, PEAK, SADDLE_RIDGE], [VALLEY, PIT, SADDLE_VALLEY]], np.int8
)


def typical_curvature(surface: Surface, k1: np.ndarray, k2: np.ndarray) -> float:
    """What counts as an ordinary curvature on this surface, in 1 / length.

    The median over the vertices of the larger principal curvature in absolute value, but at
    least the curvature of a sphere around the whole surface: on a mesh that is mostly flat the
    median says nothing about its curved parts. `k1`, `k2` are (n,).
    """
    largest = np.maximum(k1, -k2)  # k1 >= k2
    largest = largest[np.isfinite(largest)]
    median = float(np.median(largest)) if len(largest) else 0.0
    diagonal = float(np.linalg.norm([np.ptp(column) for column in surface.vertices.T]))
    # A mesh may lie in a single point.
    return max(median, 2.0 / diagonal) if diagonal > 0.0 else median


def surface_types(k1: np.ndarray, k2: np.ndarray, tolerance: float) -> np.ndarray:
    """(n,) int8 code of `SURFACE_TYPES` at each vertex, -1 where a curvature is not a number.

    Principal curvatures (n,) within `tolerance` (1 / length) of zero count as zero. The sign
    of K is then that of their product, and H counts as zero within the tolerance where K < 0;
    in this way H = 0 with K > 0, which no surface has, cannot come out. The tolerance is
    `Settings.flatness` times `typical_curvature`.
    """
    first, second = _sign_beyond(tolerance, k1), _sign_beyond(tolerance, k2)
    gaussian = first * second
    total = np.where(first, k1, 0.0) + np.where(second, k2, 0.0)
    mean = _sign_beyond(np.where(gaussian < 0, 2.0 * tolerance, 0.0), total)
    types = _TYPE_BY_SIGNS[mean, gaussian]
    types[~(np.isfinite(k1) & np.isfinite(k2))] = -1
    return types


def _sign_beyond(tolerance: float | np.ndarray, values: np.ndarray) -> np.ndarray:
    """(n,) int8 signs of values, zero within the tolerance."""
    return (values > tolerance).astype(np.int8) - (values < -tolerance).astype(np.int8)
