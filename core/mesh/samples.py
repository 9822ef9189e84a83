"""Points spread over a surface by area."""

from __future__ import annotations

import numpy as np

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
    mean: np.ndarray = np.stack(
        [
            np.bincount(triangles.ravel(), np.repeat(normal[:, k] * area, 3), len(vertices))
            for k in range(3)
        ],
        axis=1,
    )
    mean /= np.maximum(np.linalg.norm(mean, axis=1, keepdims=True), np.finfo(float).tiny)
    own = mean[corners]
    smooth = np.einsum("skc,sc->sk", own, normal[row]) > _SMOOTH
    own = np.where(smooth[..., None], own, normal[row][:, None])
    across = np.einsum("sk,skc->sc", weights, own)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    return np.einsum("sk,skc->sc", weights, vertices[corners]), across
