"""What the linear part of the deviator says about an umbilic: index, kind, separatrices.

Near an umbilic the deviator is D = p z + q conj(z) with z = x + i y in the tangent plane
(Berry & Hannay 1977 name the three patterns star, lemon and monstar).
"""

from __future__ import annotations

import numpy as np

from .result import COMPOUND, LEMON, MONSTAR, STAR, UNCERTAIN

# Directions in which the cubic form is moved by its error to see whether it stays what it is.
DIRECTIONS = 8
# |q| over |p| that it is moved to at most where the index is positive.
INSIDE = 0.99


def from_gradient(along_x: np.ndarray, along_y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """p and q of deviators with the given complex derivatives along orthonormal x and y."""
    return 0.5 * (along_x - 1j * along_y), 0.5 * (along_x + 1j * along_y)


def in_triangles(
    corners: np.ndarray, values: np.ndarray, x: np.ndarray, y: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """p and q of deviators interpolated linearly over triangles.

    Parameters
    ----------
    corners:
        (r, 3, 3) float64 corner positions.
    values:
        (r, 3) complex128 deviators of the corners in the frames x, y.
    x, y:
        (r, 3) float64 orthonormal in-plane axes.
    """
    ab, ac = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    abx, aby = np.einsum("rc,rc->r", ab, x), np.einsum("rc,rc->r", ab, y)
    acx, acy = np.einsum("rc,rc->r", ac, x), np.einsum("rc,rc->r", ac, y)
    area = abx * acy - aby * acx
    area = np.where(np.abs(area) > np.finfo(float).tiny, area, np.inf)
    one, two = values[:, 1] - values[:, 0], values[:, 2] - values[:, 0]
    return from_gradient((one * acy - two * aby) / area, (two * abx - one * acx) / area)


def index(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """(k,) +0.5 or -0.5, the index of the generic umbilic p z + q conj(z); 0 if |p| = |q|."""
    return 0.5 * np.sign(np.abs(p) - np.abs(q))


def separatrix_angles(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """(k, 3) angles, NaN-filled, along which lines of the larger curvature run into an umbilic.

    They are the real roots of Im(p exp(-i phi) + q exp(-3 i phi)) = 0 with positive real part;
    at the opposite angle the line belongs to the smaller curvature.
    """
    # With s = tan(phi - phi0) the equation is a real cubic. Its leading coefficient is the left
    # side at phi0 + pi/2; the best of a few phi0 keeps it away from zero.
    starts = np.pi * np.arange(6) / 6
    sides = np.abs(_across(p[:, None], q[:, None], starts + np.pi / 2))
    start = starts[sides.argmax(axis=1)] if len(p) else np.zeros(0)
    turned_p, turned_q = p * np.exp(-1j * start), q * np.exp(-3j * start)
    # p (c - i s) + q (c - i s)^3 with c, s = cosine, sine; imaginary part by powers of s / c.
    constant = turned_p.imag + turned_q.imag
    linear = -turned_p.real - 3 * turned_q.real
    square = turned_p.imag - 3 * turned_q.imag
    cube = -turned_p.real + turned_q.real
    cube = np.where(cube == 0, np.finfo(float).tiny, cube)
    companion = np.zeros((len(p), 3, 3))
    companion[:, 0] = -np.stack([square / cube, linear / cube, constant / cube], axis=1)
    companion[:, 1, 0] = companion[:, 2, 1] = 1.0
    finite = np.all(np.isfinite(companion), axis=(1, 2))
    companion[~finite] = 0.0
    roots = np.linalg.eigvals(companion).astype(np.complex128)
    angles = start[:, None] + np.arctan(roots.real)
    real = np.abs(roots.imag) <= 1e-9 * (1.0 + np.abs(roots))
    backward = (p[:, None] * np.exp(-1j * angles) + q[:, None] * np.exp(-3j * angles)).real < 0
    angles = np.where(backward, angles + np.pi, angles)
    angles = np.where(real & finite[:, None], angles, np.nan)
    return np.sort(np.mod(angles + np.pi, 2 * np.pi) - np.pi, axis=1)


def _across(p: np.ndarray, q: np.ndarray, angle: np.ndarray) -> np.ndarray:
    return (p * np.exp(-1j * angle) + q * np.exp(-3j * angle)).imag


def kinds(
    p: np.ndarray, q: np.ndarray, certified: np.ndarray, error: np.ndarray | None = None
) -> np.ndarray:
    """(k,) kind of each umbilic: "compound" where the certified index is no generic one,
    "uncertain" where p, q contradict it, and where they are within their standard error (k,) of
    being a lemon instead of a monstar or the other way round. That error holds what the linear form
    changes by over the error of the place that it is read at."""
    named = _named(p, q)
    if error is not None:
        # An error of p moves q / p as one of q of the same share does.
        least = np.maximum(np.abs(p), 1e-6 * np.abs(q) + np.finfo(float).tiny)
        reach = error * np.hypot(1.0, np.abs(q) / least)
        most = np.maximum(INSIDE * np.abs(p), np.finfo(float).tiny)
        for angle in 2.0 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS:
            moved = q + reach * np.exp(1j * angle)
            # The index is known: |q| < |p|.
            moved *= most / np.maximum(np.abs(moved), most)
            named = np.where((_named(p, moved) != named) & (named != STAR), UNCERTAIN, named)
    generic = np.abs(certified) == 0.5
    return np.where(generic, np.where(index(p, q) == certified, named, UNCERTAIN), COMPOUND)


def _named(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    rays = np.isfinite(separatrix_angles(p, q)).sum(axis=1)
    found = np.where(rays == 3, MONSTAR, LEMON)
    return np.where(index(p, q) < 0, STAR, found)
