"""How the error of a fitted deviator grows from the middle of the samples outwards."""

from __future__ import annotations

from functools import cache
from math import gamma, perm, pi

import numpy as np


def error_growth(degree: int, away: np.ndarray) -> np.ndarray:
    """(...) variance of the deviator of a fit at distances (...) from the middle of its samples, in
    root mean square distances of them, over the variance in the middle, for independent errors of
    samples that are spread evenly over a disc.

    Fits of even degree err most in the middle, of odd degree least.
    """
    return np.asarray(np.polyval(_polynomial(degree), np.square(away)))


@cache
def _polynomial(degree: int) -> np.ndarray:
    """Coefficients, the highest first, of the growth as a polynomial of the squared distance: its
    terms are products of second derivatives of those of the fit."""
    square = np.linspace(0.0, 1.0, degree - 1)
    variance = _variance(degree, np.sqrt(square))
    return np.polyfit(square, variance / variance[0], degree - 2)


def _variance(degree: int, x: np.ndarray) -> np.ndarray:
    """(k,) variance of the deviator at (x, 0), up to a common factor."""
    covariance, terms = _covariance(degree)

    def derived(i: int, j: int) -> np.ndarray:
        """(t, k) derivatives of the terms, i times along x and j times along y."""
        rows = [
            perm(a, i) * perm(b, j) * x ** (a - i) if a >= i and b == j else np.zeros(len(x))
            for a, b in terms
        ]
        return np.stack(rows)

    real, imaginary = derived(2, 0) - derived(0, 2), 2.0 * derived(1, 1)
    return np.asarray(
        np.einsum("tk,tu,uk->k", real, covariance, real)
        + np.einsum("tk,tu,uk->k", imaginary, covariance, imaginary)
    )


@cache
def _covariance(degree: int) -> tuple[np.ndarray, list[tuple[int, int]]]:
    """Covariance (t, t) of the coefficients of x^a y^b up to a common factor, and their exponents
    (a, b)."""
    terms = [(total - b, b) for total in range(degree + 1) for b in range(total + 1)]
    moments = [[_moment(a + c, b + d) for c, d in terms] for a, b in terms]
    return np.linalg.inv(np.array(moments)), terms


def _moment(a: int, b: int) -> float:
    """Mean of x^a y^b over the disc of radius sqrt(2), whose root mean square radius is 1."""
    if a % 2 or b % 2:
        return 0.0
    order = a + b
    around = gamma((a + 1) / 2) * gamma((b + 1) / 2) / (pi * gamma(order / 2 + 1))
    return 2.0 * 2.0 ** (order / 2) / (order + 2) * around
