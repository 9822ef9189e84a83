"""Surface types from the signs of mean and Gaussian curvature (Besl & Jain 1986)."""

from __future__ import annotations

import numpy as np

from .surface import Surface

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
    known = np.isfinite(k1) & np.isfinite(k2)
    first = np.where(known & (np.abs(k1) > tolerance), k1, 0.0)
    second = np.where(known & (np.abs(k2) > tolerance), k2, 0.0)
    gaussian = np.sign(first) * np.sign(second)
    total = first + second
    mean = np.sign(np.where((gaussian < 0) & (np.abs(total) <= 2.0 * tolerance), 0.0, total))
    types = np.full(np.shape(k1), FLAT, dtype=np.int8)
    for code, (wanted_mean, wanted_gaussian) in {
        PEAK: (1, 1),
        PIT: (-1, 1),
        RIDGE: (1, 0),
        VALLEY: (-1, 0),
        MINIMAL: (0, -1),
        SADDLE_RIDGE: (1, -1),
        SADDLE_VALLEY: (-1, -1),
    }.items():
        types[(mean == wanted_mean) & (gaussian == wanted_gaussian)] = code
    types[~known] = -1
    return types
