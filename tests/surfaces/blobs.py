"""Closed shapes to be found again: some without symmetry, some that turns bring onto themselves."""

from __future__ import annotations

import numpy as np

from .sampling import outward


def random_sphere(count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """(count, 3) random points of the unit sphere and the triangles of their hull."""
    from scipy.spatial import ConvexHull

    points = np.random.default_rng(seed).normal(size=(count, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    return points, outward(points, ConvexHull(points).simplices.astype(np.int64))


def blob(points: np.ndarray, seed: int) -> np.ndarray:
    """Points (n, 3) of the unit sphere on a smooth shape without symmetry, of each seed another."""
    random = np.random.default_rng(seed)
    waves = random.normal(size=(12, 3))
    heights, phases = random.normal(size=12) * 0.06, random.uniform(0.0, 2.0 * np.pi, 12)
    radius = 1.0 + np.cos(points @ waves.T * 2.0 + phases) @ heights
    return points * radius[:, None] * (1.6, 1.2, 1.0)


def star(points: np.ndarray, order: int, dent: float = 0.0) -> np.ndarray:
    """Points (n, 3) of the unit sphere on a shape that turns about z of that order, and no others,
    bring onto itself, but for a dent in one sector."""
    x, y, z = points.T
    sectors = (x + 1j * y) ** order
    radius = 1.0 + 0.12 * sectors.real + 0.06 * z * sectors.imag + 0.15 * z + 0.1 * z**3
    radius -= dent * np.exp(-20.0 * ((x - 0.8) ** 2 + (y - 0.4) ** 2 + (z - 0.4) ** 2))
    return points * radius[:, None] * (1.0, 1.0, 0.7)
