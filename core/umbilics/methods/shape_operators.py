"""Method S: linear interpolation of shape operators inside a triangle.

Each corner's shape operator is laid into the plane of the triangle by one of two local
parametrizations; its deviator t is interpolated linearly, and the umbilic is where t = 0.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...base.unit import phase
from ...curvature.field import CurvatureField
from ...fields.frames import frame
from ...mesh.surface import Surface

# Below this cosine between vertex and face normal the projection magnifies the operator more
# than three times along one axis; the rotation is used for that face instead.
LEAST_COSINE = 0.3
_BLOCK = 1 << 16


@dataclass(frozen=True)
class FaceDeviators:
    """Deviators of the three corners of r triangles in the frames of the triangles.

    Attributes
    ----------
    values:
        (r, 3) complex128 deviator of each corner, in 1 / length.
    x, y, normal:
        (r, 3) float64 frame of each triangle.
    refused:
        (r,) bool, True where the projection was refused and the rotation was used.
    """

    values: np.ndarray
    x: np.ndarray
    y: np.ndarray
    normal: np.ndarray
    refused: np.ndarray


def face_deviators(
    surface: Surface, field: CurvatureField, rows: np.ndarray, parametrization: str
) -> FaceDeviators:
    """Deviators at the corners of the triangles `rows`, in the plane of each triangle.

    parametrization "conformal" turns the tangent plane at the corner into the triangle's by
    the smallest rotation; "projection" projects it along the face normal, where the operator
    becomes S = B K B^-1 with B the projected principal directions.
    """
    normal = surface.face_normal_area[0][rows]
    x, y = (axis.T for axis in frame(normal.T))
    corners = surface.triangles[rows]
    d1, d2 = field.d1[corners], field.d2[corners]
    b11, b12 = _dot(d1, x), _dot(d2, x)
    b21, b22 = _dot(d1, y), _dot(d2, y)
    rotation = phase((b11 + b22) + 1j * (b21 - b12))
    values = field.gap[corners] * rotation**2
    refused = np.zeros(len(rows), bool)
    if parametrization == "projection":
        determinant = b11 * b22 - b12 * b21
        refused = (determinant < LEAST_COSINE).any(axis=1)
        k1, k2 = field.k1[corners], field.k2[corners]
        safe = np.where(refused[:, None], 1.0, determinant)
        s11 = (k1 * b11 * b22 - k2 * b12 * b21) / safe
        s22 = (k2 * b11 * b22 - k1 * b12 * b21) / safe
        s12 = (k2 - k1) * b11 * b12 / safe
        s21 = (k1 - k2) * b21 * b22 / safe
        projected = (s11 - s22) + 1j * (s12 + s21)
        values = np.where(refused[:, None], values, projected)
    return FaceDeviators(values, x, y, normal, refused)


def _dot(vectors: np.ndarray, axis: np.ndarray) -> np.ndarray:
    return np.einsum("rkc,rc->rk", vectors, axis)


def zero_weights(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where the interpolated deviator of each triangle is zero.

    Parameters
    ----------
    values:
        (r, 3) complex128 deviators of the corners.

    Returns
    -------
    weights:
        (r, 3) float64 barycentric coordinates of the zero, which may lie outside the triangle;
        a third each where the three values are parallel and have no isolated zero.
    winding:
        (r,) float64 the sum of the three cross products: its sign is that of the index.
    """
    after, before = np.roll(values, -1, axis=1), np.roll(values, -2, axis=1)
    cross = (np.conj(after) * before).imag
    winding = cross.sum(axis=1)
    isolated = np.abs(winding) > 1e-12 * np.abs(cross).sum(axis=1)
    safe = np.where(isolated, winding, 1.0)
    weights = np.where(isolated[:, None], cross / safe[:, None], 1.0 / 3.0)
    return weights, winding


def zero_crossings(
    deviators: Callable[[np.ndarray], np.ndarray], count: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The paper's own test: triangles whose interpolated deviator vanishes inside them.

    Each triangle decides alone, so on noisy meshes umbilics at edges are lost or doubled; the
    certified index decides consistently.

    Parameters
    ----------
    deviators:
        Gives those of the corners, (r, 3) complex128, of the triangles (r,).
    count:
        How many triangles there are.

    Returns
    -------
    triangle, weights, index:
        (k,) rows, (k, 3) barycentric coordinates, (k,) index +-0.5.
    """
    found = []
    for first in range(0, count, _BLOCK):
        rows = np.arange(first, min(first + _BLOCK, count))
        weights, winding = zero_weights(deviators(rows))
        inside = (weights >= 0).all(axis=1) & (winding != 0)
        found.append((rows[inside], weights[inside], 0.5 * np.sign(winding[inside])))
    triangle, weights, index = (np.concatenate(part) for part in zip(*found, strict=True))
    return triangle, weights, index


def nearest_inside(points: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Barycentric coordinates of the points of triangles nearest to given ones.

    Parameters
    ----------
    points:
        (r, 3, 3) float64 corners of each triangle.
    weights:
        (r, 3) float64 barycentric coordinates, perhaps outside.
    """
    outside = ~(weights >= 0).all(axis=1)
    result = weights.copy()
    if not outside.any():
        return result
    corner = points[outside]
    target = np.einsum("rk,rkc->rc", weights[outside], corner)
    best = np.full(len(corner), np.inf)
    nearest = np.zeros((len(corner), 3))
    for k in range(3):
        start, end = corner[:, k], corner[:, (k + 1) % 3]
        along = end - start
        length = np.maximum(np.einsum("rc,rc->r", along, along), np.finfo(float).tiny)
        share = np.clip(np.einsum("rc,rc->r", target - start, along) / length, 0.0, 1.0)
        distance = np.linalg.norm(start + share[:, None] * along - target, axis=1)
        closer = distance < best
        best = np.where(closer, distance, best)
        candidate = np.zeros_like(nearest)
        candidate[:, k], candidate[:, (k + 1) % 3] = 1.0 - share, share
        nearest[closer] = candidate[closer]
    result[outside] = nearest
    return result
