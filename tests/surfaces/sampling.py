"""Where vertices lie before they are mapped: subdivided spheres, grids, random points."""

from __future__ import annotations

import numpy as np
from scipy.spatial import Delaunay


def icosphere(subdivisions: int) -> tuple[np.ndarray, np.ndarray]:
    """Unit sphere of 20 * 4^subdivisions triangles: vertices (n, 3), triangles (m, 3)."""
    golden = (1.0 + np.sqrt(5.0)) / 2.0
    short = np.array([(0, i, j * golden) for i in (-1, 1) for j in (-1, 1)])
    vertices = np.concatenate([np.roll(short, shift, axis=1) for shift in range(3)])
    vertices /= np.linalg.norm(vertices, axis=1)[:, None]
    gap = np.linalg.norm(vertices[:, None] - vertices[None], axis=2)
    near = (gap > 0) & (gap < 1.1)
    a, b, c = np.nonzero(near[:, :, None] & near[:, None, :] & near[None])
    once = (a < b) & (b < c)
    triangles = np.stack([a[once], b[once], c[once]], axis=1)
    triangles = outward(vertices, triangles)
    for _ in range(subdivisions):
        vertices, triangles = _split(vertices, triangles)
        vertices /= np.linalg.norm(vertices, axis=1)[:, None]
    return vertices, triangles


def outward(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """The triangles of a star-shaped surface around the origin, wound outwards."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), a + b + c) < 0
    triangles = triangles.copy()
    triangles[inward] = triangles[inward][:, ::-1]
    return triangles


def _split(vertices: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    n, m = len(vertices), len(triangles)
    start, end = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    low, high = np.minimum(start, end), np.maximum(start, end)
    key, inverse = np.unique(low * n + high, return_inverse=True)
    middle = n + inverse.reshape(m, 3)  # middle of the sides ab, bc, ca
    a, b, c = triangles.T
    ab, bc, ca = middle.T
    pieces = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    triangles = np.concatenate([np.stack(piece, axis=1) for piece in pieces])
    new = 0.5 * (vertices[key // n] + vertices[key % n])
    return np.concatenate([vertices, new]), triangles


def random_points(
    count: int, low: tuple[float, float], high: tuple[float, float], seed: int = 0
) -> tuple[np.ndarray, np.ndarray]:
    """Uniform points (count, 2) of a rectangle and their Delaunay triangles, anticlockwise."""
    points = np.random.default_rng(seed).uniform(low, high, size=(count, 2))
    return points, anticlockwise(points, Delaunay(points).simplices.astype(np.int64))


def grid_points(
    columns: int, rows: int, low: tuple[float, float], high: tuple[float, float]
) -> tuple[np.ndarray, np.ndarray]:
    """A rectangle as columns x rows cells of two triangles each, diagonals alternating."""
    x = np.linspace(low[0], high[0], columns + 1)
    y = np.linspace(low[1], high[1], rows + 1)
    points = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    i, j = (side.ravel() for side in np.meshgrid(np.arange(columns), np.arange(rows)))
    a = j * (columns + 1) + i
    b, c, d = a + 1, a + columns + 2, a + columns + 1
    even = ((i + j) % 2 == 0)[:, None]
    first = np.where(even, np.stack([a, b, c], axis=1), np.stack([a, b, d], axis=1))
    second = np.where(even, np.stack([a, c, d], axis=1), np.stack([b, c, d], axis=1))
    return points, np.concatenate([first, second])


def anticlockwise(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """The triangles of the plane, wound anticlockwise."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    u, v = b - a, c - a
    clockwise = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0] < 0
    triangles = triangles.copy()
    triangles[clockwise] = triangles[clockwise][:, ::-1]
    return triangles
