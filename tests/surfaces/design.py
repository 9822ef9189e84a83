"""Surfaces of the applications that the paper names: a ship's hull and a progressive lens."""

from __future__ import annotations

import numpy as np

from .analytic import AnalyticSurface, UmbilicPoints
from .graphs import graph_surface, refined_umbilic
from .sampling import grid_points, random_points


def wigley_hull(cells: int = 100, breadth: float = 0.1, draught: float = 0.0625) -> AnalyticSurface:
    """One side of Wigley's hull of length 1 with its image above the waterline: (x, z, half the
    breadth times (1 - 4 x^2) (1 - z^2 / draught^2)).

    Its two stars lie on the waterline: of the usual hull four thousandths of the length from its
    ends, the farther in the deeper it is. `cells` from keel to keel.
    """
    half, lengthwise, upward = 0.5 * breadth, 4.0, 1.0 / draught**2

    def jet(x: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, ...]:
        along, down = 1.0 - lengthwise * x * x, 1.0 - upward * z * z
        return (
            half * along * down,
            -2.0 * half * lengthwise * x * down,
            -2.0 * half * upward * z * along,
            -2.0 * half * lengthwise * down,
            4.0 * half * lengthwise * upward * x * z,
            -2.0 * half * upward * along,
        )

    columns = max(round(cells / (2.0 * draught) / 2.0), cells)
    points, triangles = grid_points(columns, cells, (-0.5, -draught), (0.5, draught))
    end = np.sqrt((1.0 - lengthwise / upward) / lengthwise)
    found = UmbilicPoints.of(
        [(refined_umbilic(jet, side * end, 0.0), -0.5, "star") for side in (-1.0, 1.0)]
    )
    return graph_surface("Wigley's hull", jet, points, triangles, found)


# Curvature far away, what is added for near, and how far up the lens it grows.
_FAR, _ADDED, _REACH = 0.5, 0.4, 1.0


def meridian(y: np.ndarray) -> tuple[np.ndarray, ...]:
    """Slope u', and p = u'' with its first two derivatives, of the line x = 0 of the lens."""
    s = y / _REACH
    p = _FAR + _ADDED * (0.5 + 0.75 * s - 0.25 * s**3)
    first = _ADDED * (0.75 - 0.75 * s * s) / _REACH
    second = -1.5 * _ADDED * s / _REACH**2
    slope = _FAR * y + _ADDED * _REACH * (0.5 * s + 0.375 * s * s - s**4 / 16.0)
    return slope, p, first, second


def _lens(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, ...]:
    slope, p, p1, p2 = meridian(y)
    s = y / _REACH
    height = 0.5 * _FAR * y * y
    height = height + _ADDED * _REACH**2 * (0.25 * s * s + s**3 / 8.0 - s**5 / 80.0)
    q, q1, q2 = 1.0 + slope**2, 2.0 * slope * p, 2.0 * (p * p + slope * p1)
    c = p / q
    c1 = (p1 - c * q1) / q
    c2 = (p2 - 2.0 * c1 * q1 - c * q2) / q
    half = 0.5 * x * x
    return height + c * half, c * x, slope + c1 * half, c, c1 * x, p + c2 * half


def power(y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Curvature along the umbilic line x = 0 at heights y, and its growth per arc length."""
    slope, p, p1, _ = meridian(y)
    q = 1.0 + slope**2
    curvature = p / q**1.5
    return curvature, (p1 / q**1.5 - 3.0 * p * p * slope / q**2.5) / np.sqrt(q)


def progressive_lens(
    count: int = 8000, seed: int | None = 0, half_width: float = 0.9
) -> AnalyticSurface:
    """z = u(y) + u''(y) / (1 + u'(y)^2) x^2 / 2 on a square: across the meridian it is bent as
    along it, so that the whole line x = 0 is umbilical while the curvature grows along it. `count`
    random points, or a grid without a seed."""
    low, high = (-half_width, -half_width), (half_width, half_width)
    if seed is None:
        # An odd number of cells, so that no vertices lie on the line.
        cells = 2 * (round(np.sqrt(count)) // 2) + 1
        points, triangles = grid_points(cells, cells, low, high)
    else:
        points, triangles = random_points(count, low, high, seed)
    return graph_surface("progressive lens", _lens, points, triangles)
