"""Vertex normals smoothed by linear fitting: the paper's other words for its filter.

Where the mean of the normals around a vertex is that of their centroid, which on an irregular mesh
or at a border lies beside the vertex, a linear fit is read at the vertex itself: normals that
change linearly over the tangent plane pass unchanged.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse

from ..base.progress import Progress
from ..fields.transport import tangents
from ..mesh.surface import Surface

# Neighbours that spread worse than this over the tangent plane (determinant over squared trace of
# their moments; 1/4 if alike in all directions) fix no slope, and the mean is taken.
_LEAST_SPREAD = 1e-3


def fitted_normals(
    surface: Surface, normals: np.ndarray, passes: int, progress: Progress | None = None
) -> np.ndarray:
    """`passes` of a linear fit over unit normals (n, 3), each at the vertex and its one-ring.

    In the tangent plane of the first normals, weighted by the area around each vertex. The fit is
    linear in the normals, so that a pass is a product with a sparse matrix; the results are made
    unit length again, and a normal whose fit vanishes is kept.
    """
    if passes <= 0:
        return normals.copy()
    matrix = _intercepts(surface, normals)
    for _ in range(passes):
        if progress is not None:
            progress.ask()
        fitted = matrix @ normals
        length = np.linalg.norm(fitted, axis=1)
        kept = ~(length > 1e-9)
        normals = np.where(kept[:, None], normals, fitted / np.where(kept, 1.0, length)[:, None])
    return normals


def _intercepts(surface: Surface, normals: np.ndarray) -> sparse.csr_array:
    """(n, n) matrix that takes values at the vertices to those of their linear fits."""
    n = len(surface.vertices)
    itself = np.arange(n)
    centre = np.concatenate([itself, surface.owner])
    other = np.concatenate([itself, surface.neighbours])
    area = surface.vertex_area
    weight = np.maximum(area[other], 1e-12 * max(float(area.mean()), np.finfo(float).tiny))

    def summed(values: np.ndarray) -> np.ndarray:
        return np.bincount(centre, values, minlength=n)

    weight /= summed(weight)[centre]
    offset = surface.vertices[other] - surface.vertices[centre]
    e1, e2 = tangents(normals)
    x, y = (np.einsum("ec,ec->e", offset, axis[centre]) for axis in (e1, e2))
    mean_x, mean_y = summed(weight * x), summed(weight * y)
    x -= mean_x[centre]
    y -= mean_y[centre]
    xx, xy, yy = summed(weight * x * x), summed(weight * x * y), summed(weight * y * y)
    determinant, trace = xx * yy - xy * xy, xx + yy
    sound = determinant > _LEAST_SPREAD * trace * trace
    factor = np.divide(1.0, determinant, out=np.zeros(n), where=sound)
    # Weights of a mean, less the slope from the centroid to the vertex.
    along_x = factor * (yy * mean_x - xy * mean_y)
    along_y = factor * (xx * mean_y - xy * mean_x)
    entries = weight * (1.0 - x * along_x[centre] - y * along_y[centre])
    return sparse.csr_array((entries, (centre, other)), shape=(n, n))
