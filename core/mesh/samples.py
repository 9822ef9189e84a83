"""Points spread over a surface by area."""

from __future__ import annotations

import numpy as np


def spread_points(
    vertices: np.ndarray,
    triangles: np.ndarray,
    face_normal_area: tuple[np.ndarray, np.ndarray],
    count: int,
    random: np.random.Generator,
) -> tuple[np.ndarray, np.ndarray]:
    """(count, 3) points, evenly distributed over the triangles, and (count, 3) normals there."""
    normal, area = face_normal_area
    row = random.choice(len(area), count, p=area / area.sum())
    a, b = np.sqrt(random.random(count)), random.random(count)
    weights = np.stack([1.0 - a, a * (1.0 - b), a * b], axis=1)
    return np.einsum("sk,skc->sc", weights, vertices[triangles[row]]), normal[row]
