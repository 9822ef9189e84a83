"""Tessellated parts as CAD programs write them: vertices only where faces end."""

from __future__ import annotations

import numpy as np
from scipy.spatial import Delaunay


def plate(
    holes: int, around: int, radius: float = 0.12, thick: float = 0.1
) -> tuple[np.ndarray, np.ndarray]:
    """A square plate with holes x holes round holes; its flat sides have vertices on outlines
    only, as CAD programs write them."""
    angle = 2 * np.pi * np.arange(around) / around + 0.1
    circle = radius * np.column_stack([np.cos(angle), np.sin(angle)])
    centres = [(i + 0.5, j + 0.5) for i in range(holes) for j in range(holes)]
    points = np.concatenate(
        [[(0, 0), (holes, 0), (holes, holes), (0, holes)], *(circle + c for c in centres)]
    )
    which = np.concatenate([[-1] * 4, np.repeat(np.arange(len(centres)), around)])
    flat = Delaunay(points).simplices
    inside = (which[flat] >= 0).all(axis=1) & (np.ptp(which[flat], axis=1) == 0)
    flat = flat[~inside]
    side = points[flat]
    u, v = side[:, 1] - side[:, 0], side[:, 2] - side[:, 0]
    turned = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0] < 0
    flat[turned] = flat[turned][:, ::-1]
    n = len(points)
    top = np.column_stack([points, np.full(n, thick / 2)])
    edges = flat[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    known = set(map(tuple, edges.tolist()))
    outline = np.array([(a, b) for a, b in edges.tolist() if (b, a) not in known])
    a, b = outline.T
    walls = [np.stack([b, a, a + n], axis=1), np.stack([b, a + n, b + n], axis=1)]
    triangles = np.concatenate([flat, flat[:, ::-1] + n, *walls])
    return np.concatenate([top, top * (1, 1, -1)]), triangles


def turned(
    radius: np.ndarray, height: np.ndarray, around: int
) -> tuple[np.ndarray, np.ndarray]:
    """A body of revolution from a profile that starts and ends on the axis."""
    angle = 2 * np.pi * np.arange(around) / around
    rings = [
        np.stack([r * np.cos(angle), r * np.sin(angle), np.full(around, z)], axis=1)
        for r, z in zip(radius[1:-1], height[1:-1], strict=True)
    ]
    vertices = np.concatenate([[[0, 0, height[0]]], *rings, [[0, 0, height[-1]]]])
    j = np.arange(around)
    k = (j + 1) % around
    triangles = [np.stack([0 * j, 1 + k, 1 + j], axis=1)]
    for ring in range(len(rings) - 1):
        one, two = 1 + ring * around, 1 + (ring + 1) * around
        triangles += [
            np.stack([one + j, one + k, two + k], axis=1),
            np.stack([one + j, two + k, two + j], axis=1),
        ]
    last = 1 + (len(rings) - 1) * around
    triangles.append(np.stack([last + j, last + k, 0 * j + len(vertices) - 1], axis=1))
    return vertices, np.concatenate(triangles)


def divided(vertices: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Each triangle in four."""
    sides = np.sort(np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)]), axis=1)
    edges, row = np.unique(sides, axis=0, return_inverse=True)
    x, y, z = row.reshape(3, -1) + len(vertices)
    a, b, c = triangles.T
    fine = np.concatenate([np.c_[a, x, z], np.c_[x, b, y], np.c_[z, y, c], np.c_[x, y, z]])
    return np.vstack([vertices, vertices[edges].mean(axis=1)]), fine
