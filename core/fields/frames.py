"""Tangent frames, deviators and their transport from one tangent plane to another.

The deviator of a shape operator S in an orthonormal frame is the complex number
D = (S11 - S22) + i (S12 + S21): |D| is the gap k1 - k2 and arg D is twice the angle of the
first principal direction. Turning the frame by phi multiplies D by exp(-2i phi).
"""

from __future__ import annotations

import numpy as np

from ..base.unit import unit
from ..mesh.surface import Surface


def side_axes(
    surface: Surface, triangle: np.ndarray | slice = slice(None)
) -> tuple[np.ndarray, np.ndarray]:
    """(r, 3) unit axes in the planes of triangles (r,): along their first sides, and across."""
    a, b = (surface.vertices[surface.triangles[triangle, k]] for k in range(2))
    x = unit(b - a)
    return x, np.cross(surface.face_normal_area[0][triangle], x)


def frame(normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit tangents (3, b) with e1 x e2 = normal, for unit normals (3, b).

    Duff et al. 2017, "Building an orthonormal basis, revisited".
    """
    x, y, z = normal
    sign = np.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    e1 = np.stack([1.0 + sign * x * x * a, sign * b, -sign * x])
    e2 = np.stack([b, sign + y * y * a, -y])
    return e1, e2


def principal_directions(
    real: np.ndarray, imaginary: np.ndarray, gap: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Cosine and sine of half the argument of the deviator real + i imaginary.

    Half-angle formulas, stable for every argument; (1, 0) where the deviator is zero.
    """
    larger = np.sqrt(0.5 * (gap + np.abs(real)))
    with np.errstate(divide="ignore", invalid="ignore"):
        smaller = np.where(larger > 0, 0.5 * np.abs(imaginary) / larger, 0.0)
    length = np.sqrt(gap)
    safe = np.where(length > 0, length, 1.0)
    larger, smaller = larger / safe, smaller / safe
    cosine = np.where(real >= 0, larger, smaller)
    sine = np.copysign(np.where(real >= 0, smaller, larger), imaginary)
    flat = length == 0
    return np.where(flat, 1.0, cosine), np.where(flat, 0.0, sine)
