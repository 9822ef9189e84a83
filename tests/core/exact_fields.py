"""Surfaces and curvature fields for the tests of the core, in the units of the surface."""

from __future__ import annotations

import numpy as np
from surfaces import AnalyticSurface, grid_points

from core import CurvatureField
from core.mesh.mending.repair import clean
from core.mesh.surface import Surface


def surface_of(mesh: AnalyticSurface) -> Surface:
    """The cleaned surface of an analytic mesh."""
    return clean(mesh.vertices, mesh.triangles)[0]


def flat_surface(cells: int = 21, half_width: float = 1.0) -> tuple[Surface, np.ndarray]:
    """A flat square in z = 0 and the places (n,) x + iy of its vertices.

    An odd number of cells keeps its vertices away from the origin.
    """
    points, triangles = grid_points(
        cells, cells, (-half_width, -half_width), (half_width, half_width)
    )
    surface, _ = clean(np.column_stack([points, np.zeros(len(points))]), triangles)
    z = points[surface.source_vertex]
    return surface, z[:, 0] + 1j * z[:, 1]


def field_on_plane(deviator: np.ndarray, mean: float = 0.0) -> CurvatureField:
    """A field on a surface in z = 0 whose deviator in the axes x, y is given (n,) complex."""
    n = len(deviator)
    angle, gap = 0.5 * np.angle(deviator), np.abs(deviator)
    zero = np.zeros(n)
    d1 = np.stack([np.cos(angle), np.sin(angle), zero], axis=1)
    d2 = np.stack([-np.sin(angle), np.cos(angle), zero], axis=1)
    normal = np.tile([0.0, 0.0, 1.0], (n, 1))
    return CurvatureField(mean + 0.5 * gap, mean - 0.5 * gap, d1, d2, normal, np.full(n, np.nan))


def points_of(surface: Surface, triangle: np.ndarray, barycentric: np.ndarray) -> np.ndarray:
    """(k, 3) points in input coordinates."""
    corners = surface.vertices[surface.triangles[triangle]]
    return np.einsum("kj,kji->ki", barycentric, corners) * surface.unit + surface.origin
