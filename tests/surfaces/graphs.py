"""Graph patches z = f(x, y), wound upwards, and the other open surfaces."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.optimize import root

from .analytic import AnalyticSurface, UmbilicPoints, operators
from .sampling import grid_points, random_points

Jet = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, ...]]
"""(x, y) -> f, fx, fy, fxx, fxy, fyy."""


def graph_surface(
    name: str,
    jet: Jet,
    points: np.ndarray,
    triangles: np.ndarray,
    umbilics: UmbilicPoints | None = None,
    everywhere: bool = False,
) -> AnalyticSurface:
    """The graph of a function over triangulated points (n, 2) of the plane.

    Normals point upwards and the shape operator is their derivative, so curvatures are minus
    those of the Hessian: a bowl has negative ones.
    """
    f, fx, fy, fxx, fxy, fyy = (
        np.broadcast_to(value, len(points)).astype(float) for value in jet(*points.T)
    )
    vertices = np.column_stack([points, f])
    gradient = np.column_stack([-fx, -fy, np.ones_like(fx)])
    hessian = np.zeros((len(points), 3, 3))
    hessian[:, 0, 0], hessian[:, 1, 1] = -fxx, -fyy
    hessian[:, 0, 1] = hessian[:, 1, 0] = -fxy
    found = umbilics if umbilics is not None else UmbilicPoints.none()
    return AnalyticSurface(
        name, vertices, triangles, *operators(gradient, hessian), found, everywhere
    )


def refined_umbilic(jet: Jet, x: float, y: float) -> tuple[float, float, float]:
    """The umbilic of a graph near (x, y), to round-off: the zero of S11 - S22 and S12 + S21."""

    def deviator(point: np.ndarray) -> np.ndarray:
        _, fx, fy, fxx, fxy, fyy = jet(*point)
        first = np.array([[1 + fx * fx, fx * fy], [fx * fy, 1 + fy * fy]])
        S = np.linalg.solve(first, np.array([[fxx, fxy], [fxy, fyy]]))
        return np.array([S[0, 0] - S[1, 1], S[0, 1] + S[1, 0]])

    solution = root(deviator, (x, y), tol=1e-15).x
    return float(solution[0]), float(solution[1]), float(jet(*solution)[0])


def _seed_jet(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, ...]:
    return (
        0.5 * (x * x + y * y) + 1.2 * x**3 - 0.5 * x * x * y + 0.2 * x * y * y + 1.6 * y**3,
        x + 3.6 * x * x - x * y + 0.2 * y * y,
        y - 0.5 * x * x + 0.4 * x * y + 4.8 * y * y,
        1.0 + 7.2 * x - y,
        -x + 0.4 * y,
        1.0 + 0.4 * x + 9.6 * y,
    )


def seed_patch(count: int = 5400, seed: int = 0, grid: bool = False) -> AnalyticSurface:
    """The paper's patch on [-1.2, 1.2]^2: a star and two lemons.

    `count` random points triangulated by Delaunay, or with `grid` a regular grid of about as
    many. Wound upwards, so the star at the origin has curvature -1.
    """
    low, high = (-1.2, -1.2), (1.2, 1.2)
    if grid:
        cells = max(round(np.sqrt(count)) - 1, 1)
        points, triangles = grid_points(cells, cells, low, high)
    else:
        points, triangles = random_points(count, low, high, seed)
    umbilics = UmbilicPoints.of(
        [
            ((0.0, 0.0, 0.0), -0.5, "star"),
            (refined_umbilic(_seed_jet, -0.956950876, -0.185711748), 0.5, "lemon"),
            (refined_umbilic(_seed_jet, -0.391652742, -0.819220227), 0.5, "lemon"),
        ]
    )
    return graph_surface("seed patch", _seed_jet, points, triangles, umbilics)


def paraboloid(
    A: float = 2.0, B: float = 1.0, half_width: float = 2.0, cells: int = 64
) -> AnalyticSurface:
    """z = x^2 / 2A + y^2 / 2B with A > B on a grid: two lemons at y = +-sqrt(B (A - B))."""
    if not A > B > 0:
        raise ValueError("paraboloid: A > B > 0")
    y = np.sqrt(B * (A - B))
    if y >= half_width:
        raise ValueError("paraboloid: the umbilics lie outside the patch")
    points, triangles = grid_points(
        cells, cells, (-half_width, -half_width), (half_width, half_width)
    )
    umbilics = UmbilicPoints.of([((0.0, s * y, 0.5 * (A - B)), 0.5, "lemon") for s in (-1, 1)])
    return graph_surface(
        "paraboloid",
        lambda x, y: (x * x / (2 * A) + y * y / (2 * B), x / A, y / B, 1 / A, 0.0, 1 / B),
        points,
        triangles,
        umbilics,
    )


def monkey_saddle(half_width: float = 1.0, cells: int = 65) -> AnalyticSurface:
    """z = x^3 - 3 x y^2: one flat point, a star (no grid vertex on it while `cells` is odd)."""
    points, triangles = grid_points(
        cells, cells, (-half_width, -half_width), (half_width, half_width)
    )
    return graph_surface(
        "monkey saddle",
        lambda x, y: (x**3 - 3 * x * y * y, 3 * (x * x - y * y), -6 * x * y, 6 * x, -6 * y, -6 * x),
        points,
        triangles,
        UmbilicPoints.of([((0.0, 0.0, 0.0), -0.5, "star")]),
    )


def saddle(half_width: float = 1.0, cells: int = 40) -> AnalyticSurface:
    """z = x y: no umbilic, though EN - GL vanishes at the origin."""
    points, triangles = grid_points(
        cells, cells, (-half_width, -half_width), (half_width, half_width)
    )
    return graph_surface("saddle", lambda x, y: (x * y, y, x, 0.0 * x, 1.0, 0.0), points, triangles)


def plane(half_width: float = 1.0, cells: int = 40, tilt: float = 0.0) -> AnalyticSurface:
    """z = tilt * x: every point is a flat umbilic."""
    points, triangles = grid_points(
        cells, cells, (-half_width, -half_width), (half_width, half_width)
    )
    return graph_surface(
        "plane", lambda x, y: (tilt * x, tilt, 0.0, 0.0, 0.0, 0.0), points, triangles,
        everywhere=True,
    )  # fmt: skip


def cylinder(
    radius: float = 1.0, height: float = 3.0, columns: int = 64, rows: int = 40
) -> AnalyticSurface:
    """An open cylinder about z with two border loops: no umbilic, k1 = 1 / radius."""
    i, j = (side.ravel() for side in np.meshgrid(np.arange(columns), np.arange(rows + 1)))
    u = 2.0 * np.pi * i / columns
    zero, one = np.zeros_like(u), np.ones_like(u)
    normal = np.stack([np.cos(u), np.sin(u), zero], axis=1)
    around = np.stack([-np.sin(u), np.cos(u), zero], axis=1)
    vertices = radius * normal + np.stack([zero, zero, height * (j / rows - 0.5)], axis=1)
    cell = j < rows
    right = np.where(i + 1 < columns, i + 1, 0)
    a, b = (j * columns + i)[cell], (j * columns + right)[cell]
    c, d = b + columns, a + columns
    triangles = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    axial = np.stack([zero, zero, one], axis=1)
    return AnalyticSurface(
        "cylinder", vertices, triangles, one / radius, zero, around, axial, normal,
        UmbilicPoints.none(),
    )  # fmt: skip
