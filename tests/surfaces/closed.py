"""Closed surfaces: ellipsoids, the quartic x^4 + y^4 + z^4 = 1, spheres and tori."""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull

from .analytic import AnalyticSurface, UmbilicPoints, operators
from .sampling import icosphere, outward


def ellipsoid(
    axes: tuple[float, float, float] = (3.0, 2.0, 1.0), subdivisions: int = 5
) -> AnalyticSurface:
    """x^2/a^2 + y^2/b^2 + z^2/c^2 = 1 with a > b > c, an icosphere stretched: four lemons."""
    points, triangles = icosphere(subdivisions)
    return ellipsoid_on(points * np.array(axes), triangles, axes)


def random_ellipsoid(
    count: int, axes: tuple[float, float, float] = (3.0, 2.0, 1.0), seed: int = 0
) -> AnalyticSurface:
    """`count` random points of the ellipsoid (uniform on the sphere, stretched), convex hull."""
    points = np.random.default_rng(seed).normal(size=(count, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    # The hull of the unstretched points is the Delaunay triangulation of the sphere.
    triangles = outward(points, ConvexHull(points).simplices.astype(np.int64))
    return ellipsoid_on(points * np.array(axes), triangles, axes)


def ellipsoid_on(
    vertices: np.ndarray, triangles: np.ndarray, axes: tuple[float, float, float]
) -> AnalyticSurface:
    a, b, c = axes
    if not a > b > c > 0:
        raise ValueError(f"the semi-axes must fall strictly, not {axes}")
    weight = 1.0 / np.square(axes)
    hessian = np.broadcast_to(np.diag(weight), (len(vertices), 3, 3))
    x = a * np.sqrt((a * a - b * b) / (a * a - c * c))
    z = c * np.sqrt((b * b - c * c) / (a * a - c * c))
    umbilics = UmbilicPoints.of(
        [((i * x, 0.0, j * z), 0.5, "lemon") for i in (-1, 1) for j in (-1, 1)]
    )
    k1, k2, d1, d2, normal = operators(vertices * weight, hessian)
    return AnalyticSurface("ellipsoid", vertices, triangles, k1, k2, d1, d2, normal, umbilics)


def quartic(subdivisions: int = 5) -> AnalyticSurface:
    """x^4 + y^4 + z^4 = 1: eight stars on the diagonals, six flat points of index +1."""
    points, triangles = icosphere(subdivisions)
    # Turned a little, so that no vertex sits on an umbilic.
    angle = 0.3
    turn = np.array(
        [[np.cos(angle), -np.sin(angle), 0.0], [np.sin(angle), np.cos(angle), 0.0], [0, 0, 1.0]]
    )
    points = points @ turn @ turn[[2, 0, 1]][:, [2, 0, 1]]
    vertices = points / (points**4).sum(axis=1)[:, None] ** 0.25
    hessian = np.zeros((len(vertices), 3, 3))
    hessian[:, [0, 1, 2], [0, 1, 2]] = 12.0 * vertices**2
    side = 3.0**-0.25
    signs = (-1.0, 1.0)
    stars = [((i * side, j * side, k * side), -0.5, "star")
             for i in signs for j in signs for k in signs]  # fmt: skip
    flat = [(tuple(sign * row), 1.0, "flat") for row in np.eye(3) for sign in signs]
    k1, k2, d1, d2, normal = operators(4.0 * vertices**3, hessian)
    return AnalyticSurface(
        "quartic", vertices, triangles, k1, k2, d1, d2, normal, UmbilicPoints.of(stars + flat)
    )


def sphere(radius: float = 1.0, subdivisions: int = 5) -> AnalyticSurface:
    """Every point is an umbilic of curvature 1 / radius."""
    points, triangles = icosphere(subdivisions)
    hessian = np.broadcast_to(np.eye(3), (len(points), 3, 3))
    k1, k2, d1, d2, normal = operators(points * radius, hessian)
    return AnalyticSurface(
        "sphere", points * radius, triangles, k1, k2, d1, d2, normal, UmbilicPoints.none(), True
    )


def torus(
    major: float = 2.0, minor: float = 0.7, columns: int = 120, rows: int = 48
) -> AnalyticSurface:
    """Torus of revolution about z, `columns` around the axis, `rows` around the tube."""
    i, j = (side.ravel() for side in np.meshgrid(np.arange(columns), np.arange(rows)))
    u, v = 2.0 * np.pi * i / columns, 2.0 * np.pi * j / rows
    radial = np.stack([np.cos(u), np.sin(u), np.zeros_like(u)], axis=1)
    around = np.stack([-np.sin(u), np.cos(u), np.zeros_like(u)], axis=1)
    up = np.array([0.0, 0.0, 1.0])
    normal = np.cos(v)[:, None] * radial + np.sin(v)[:, None] * up
    meridian = -np.sin(v)[:, None] * radial + np.cos(v)[:, None] * up
    right, above = (i + 1) % columns, (j + 1) % rows
    a, b = j * columns + i, j * columns + right
    c, d = above * columns + right, above * columns + i
    triangles = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    k1 = np.full(len(u), 1.0 / minor)
    k2 = np.cos(v) / (major + minor * np.cos(v))
    return AnalyticSurface(
        "torus",
        major * radial + minor * normal,
        triangles,
        k1,
        k2,
        meridian,
        -around,  # meridian x (-around) = normal
        normal,
        UmbilicPoints.none(),
    )
