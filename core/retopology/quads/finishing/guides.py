"""What holds the vertices of a quad mesh on its surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .projection import ClosestPoints


@dataclass(frozen=True)
class Guides:
    """What holds and turns the vertices of a quad mesh.

    Attributes
    ----------
    surface:
        Where vertices are kept.
    direction:
        (m, 3) float64 unit directions to turn to in its triangles.
    size:
        (m,) float64 what edges shall measure there against one another.
    fixed:
        (n,) bool vertices that do not move.
    curve:
        (n,) int64 polyline that a vertex slides along, -1 for none.
    beside:
        (n, 2) int64 vertices before and after it there, -1 for none.
    curves:
        The polylines' starts and ends, (s, 3) each.
    """

    surface: ClosestPoints
    direction: np.ndarray
    size: np.ndarray
    fixed: np.ndarray
    curve: np.ndarray
    beside: np.ndarray
    curves: dict[int, tuple[np.ndarray, np.ndarray]]


def on_curve(points: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Closest points (p, 3) of a polyline with the given segments."""
    along = end - start
    square = np.maximum((along**2).sum(axis=1), np.finfo(float).tiny)
    share = np.clip(((points[:, None] - start) * along).sum(axis=2) / square, 0.0, 1.0)
    place = start + share[:, :, None] * along
    nearest = ((place - points[:, None]) ** 2).sum(axis=2).argmin(axis=1)
    return place[np.arange(len(points)), nearest]


def vertex_normals(position: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """(n, 3) normals of the quads around each vertex, weighted by area."""
    at = position[quads]
    normal = np.cross(at[:, 2] - at[:, 0], at[:, 3] - at[:, 1])
    flat = quads.ravel()
    total = [
        np.bincount(flat, np.repeat(normal[:, axis], 4), minlength=len(position))
        for axis in range(3)
    ]
    return np.stack(total, axis=1)
