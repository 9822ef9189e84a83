"""The shape operator of a surface given as heights over a plane."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from .height_fit import powers_to


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

    def tangent(
        self, cosine: np.ndarray | float, sine: np.ndarray | float, axes: np.ndarray
    ) -> np.ndarray:
        """(b, 3) unit tangent at an angle to the frame's first axis; axes (3, 3, b): e1, e2, n."""
        a, b, d = self.root
        x, y = a * cosine + b * sine, b * cosine + d * sine
        return _combined(x, y, self.gx * x + self.gy * y, axes)

    def normal(self, axes: np.ndarray) -> np.ndarray:
        """(b, 3) unit normal; axes (3, 3, b): e1, e2, n."""
        shrink = 1.0 / np.sqrt(1.0 + self.gx * self.gx + self.gy * self.gy)
        return _combined(-self.gx * shrink, -self.gy * shrink, shrink, axes)


def _combined(x: np.ndarray, y: np.ndarray, z: np.ndarray, axes: np.ndarray) -> np.ndarray:
    # One contraction: twice as fast as sums of products with their temporaries.
    return np.einsum("kb,kcb->cb", np.stack([x, y, z]), axes).T


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


def operator_at(
    coefficients: Mapping[tuple[int, int], np.ndarray], u: np.ndarray, v: np.ndarray
) -> HeightOperator:
    """Shape operator of the heights sum c_ab u^a v^b above (u, v), in units of these."""
    derivative = {order: np.zeros(u.shape) for order in ((1, 0), (0, 1), (2, 0), (1, 1), (0, 2))}
    most = max(a + b for a, b in coefficients)
    powers = powers_to(most, u), powers_to(most, v)
    for (a, b), coefficient in coefficients.items():
        for (i, j), value in derivative.items():
            if a >= i and b >= j:
                factor = math.perm(a, i) * math.perm(b, j)
                derivative[i, j] = value + (
                    factor * coefficient * powers[0][a - i] * powers[1][b - j]
                )
    return operator_of_heights(*derivative.values())


def deviator_at(
    coefficients: Mapping[tuple[int, int], np.ndarray], u: np.ndarray, v: np.ndarray
) -> np.ndarray:
    """The deviator of `operator_at` as a complex number."""
    operator = operator_at(coefficients, u, v)
    return operator.real + 1j * operator.imaginary
