"""The shape operator of a surface given as heights over a plane."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

Axes = tuple[np.ndarray, np.ndarray, np.ndarray]


@dataclass(frozen=True)
class HeightOperator:
    """Shape operator in the orthonormal tangent frame nearest to the plane's axes.

    Attributes
    ----------
    mean, real, imaginary:
        (b,) float64 mean curvature and deviator (real + i imaginary), in 1 / unit.
    gx, gy:
        (b,) float64 gradient of the heights.
    root:
        (b,) float64 each: the entries 11, 12, 22 of I^(-1/2), which turns the tangents over the
        plane's axes into the orthonormal frame.
    """

    mean: np.ndarray
    real: np.ndarray
    imaginary: np.ndarray
    gx: np.ndarray
    gy: np.ndarray
    root: tuple[np.ndarray, np.ndarray, np.ndarray]

    def tangent(self, cosine: np.ndarray, sine: np.ndarray, axes: Axes) -> np.ndarray:
        """(3, b) unit tangent at an angle to the frame's first axis; axes (e1, e2, n), (3, b)."""
        a, b, d = self.root
        x, y = a * cosine + b * sine, b * cosine + d * sine
        return x * axes[0] + y * axes[1] + (self.gx * x + self.gy * y) * axes[2]

    def normal(self, axes: Axes) -> np.ndarray:
        """(3, b) unit normal; axes (e1, e2, n), each (3, b)."""
        length = np.sqrt(1.0 + self.gx * self.gx + self.gy * self.gy)
        return (axes[2] - self.gx * axes[0] - self.gy * axes[1]) / length


def operator_of_heights(
    gx: np.ndarray, gy: np.ndarray, hxx: np.ndarray, hxy: np.ndarray, hyy: np.ndarray
) -> HeightOperator:
    """Shape operator from gradient and second derivatives (b,) of heights along the normal.

    Positive where the surface falls away from its outward normal, as a sphere does.
    """
    w = np.sqrt(1.0 + gx * gx + gy * gy)
    # I^(-1/2) = 1 - g g^T / (w (1 + w)), and S = -I^(-1/2) II I^(-1/2) in that frame.
    q = 1.0 / (w * (1.0 + w))
    a, b, d = 1.0 - q * gx * gx, -q * gx * gy, 1.0 - q * gy * gy
    m11, m12 = a * hxx + b * hxy, a * hxy + b * hyy
    m21, m22 = b * hxx + d * hxy, b * hxy + d * hyy
    s11, s12, s22 = m11 * a + m12 * b, m11 * b + m12 * d, m21 * b + m22 * d
    return HeightOperator(
        -0.5 * (s11 + s22) / w, -(s11 - s22) / w, -2.0 * s12 / w, gx, gy, (a, b, d)
    )
