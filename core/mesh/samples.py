"""Points spread over a surface by area."""

from __future__ import annotations

import numpy as np

from ..base.unit import unit

# Cosine between a triangle and the mean about its corner from which on that is a crease.
_SMOOTH = float(np.cos(np.radians(30.0)))

def spread_points(
    vertices: np.ndarray,
    triangles: np.ndarray,
    face_normal_area: tuple[np.ndarray, np.ndarray],
    count: int,
    random: np.random.Generator,
) -> tuple[np.ndarray, np.ndarray]:
    """(count, 3) points, evenly distributed over the triangles, and (count, 3) unit normals there.

    The normals go over from corner to corner as the surface does that the triangles stand for:
    each corner has the mean of its triangles' by area, where that is no crease.
    """
    normal, area = face_normal_area
    row = random.choice(len(area), count, p=area / area.sum())
    a, b = np.sqrt(random.random(count)), random.random(count)
    weights = np.stack([1.0 - a, a * (1.0 - b), a * b], axis=1)
    corners = triangles[row]
    own = mean_normals(triangles, face_normal_area, len(vertices))[corners]
    smooth = np.einsum("skc,sc->sk", own, normal[row]) > _SMOOTH
    own = np.where(smooth[..., None], own, normal[row][:, None])
    across = np.einsum("sk,skc->sc", weights, own)
    return np.einsum("sk,skc->sc", weights, vertices[corners]), unit(across)


def mean_normals(
    triangles: np.ndarray, face_normal_area: tuple[np.ndarray, np.ndarray], count: int
) -> np.ndarray:
    """(count, 3) unit means of the normals of each vertex' triangles by area."""
    normal, area = face_normal_area
    mean: np.ndarray = np.stack(
        [
            np.bincount(triangles.ravel(), np.repeat(normal[:, k] * area, 3), count)
            for k in range(3)
        ],
        axis=1,
    )
    return unit(mean)
