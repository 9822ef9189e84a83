"""Zeros of the deviator of a fit: where one is, how the deviator grows from it, and how clear of
zero it is around."""

from __future__ import annotations

import numpy as np

from ..curvature.fits.height_fit import HeightFit
from ..curvature.fits.monge import deviator_at
from .kind import from_gradient

NEWTON_STEPS = 8
# Radii of the circles on which the fit is read, in root mean square distances of its samples, and
# points on each.
CIRCLES = (0.2, 0.35, 0.5, 0.7)
CIRCLE = 24
# Directions of an error of the deviator, over which its effect on the slopes is averaged.
DIRECTIONS = 4
# Distance over which the slopes are differenced, in radii.
NEXT = 0.05
# Step of the derivative by central differences, for coordinates of order 1: the cube root of
# the rounding unit balances truncation against round-off.
STEP = 6e-6


def zero(fit: HeightFit, farthest: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Where the deviator of the fit vanishes: (u, v) by Newton's method, and where it settled."""
    u, v = np.zeros((2, len(farthest)))
    step = np.full(len(farthest), np.inf)
    for _ in range(NEWTON_STEPS):
        value = deviator_at(fit.coefficients, u, v)
        along_u, along_v = slopes(fit, u, v)
        determinant = (np.conj(along_u) * along_v).imag
        safe = np.where(determinant == 0, np.inf, determinant)
        du = -(np.conj(value) * along_v).imag / safe
        dv = -(np.conj(along_u) * value).imag / safe
        # No step longer than the reach: far from the zero the linear model overshoots.
        length = np.hypot(du, dv)
        short = farthest / np.maximum(length, farthest)
        u, v, step = u + short * du, v + short * dv, length
    distance = np.hypot(u, v)
    return u, v, (distance <= farthest) & (step <= 1e-6) & (determinant != 0)


def slopes(fit: HeightFit, u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Derivatives of the deviator of a fit along u and v."""
    # All at once: places are few, and each call costs more than they do.
    beside = np.stack([u + STEP, u - STEP, u, u]), np.stack([v, v, v + STEP, v - STEP])
    right, left, above, below = deviator_at(fit.coefficients, *beside)
    return (right - left) / (2 * STEP), (above - below) / (2 * STEP)


def slope_change(fit: HeightFit, u: np.ndarray, v: np.ndarray, error: np.ndarray) -> np.ndarray:
    """(b,) how much p and q change over the error of the place (u, v) that an error of the deviator
    makes, each in the units of the fit; root of the mean square over its directions."""
    along_u, along_v = slopes(fit, u, v)
    p, q = from_gradient(along_u, along_v)
    determinant = np.abs(p) ** 2 - np.abs(q) ** 2
    square = np.zeros((2, len(u)))
    for angle in 2.0 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS:
        # Where p z + q conj(z) is the error.
        turned = error * np.exp(1j * angle)
        safe = np.where(determinant == 0, np.inf, determinant)
        z = (np.conj(p) * turned - q * np.conj(turned)) / safe
        size = np.abs(z)
        ahead = NEXT * z / np.maximum(size, np.finfo(float).tiny)
        moved = from_gradient(*slopes(fit, u + ahead.real, v + ahead.imag))
        # The fit tells nothing of what lies further than its samples.
        change = np.abs(np.stack(moved) - np.stack([p, q])) / NEXT
        square += (change * np.minimum(size, 1.0)) ** 2
    return np.asarray(np.sqrt(square.max(axis=0) / DIRECTIONS))


def clear_of_zero(
    fit: HeightFit, u: np.ndarray, v: np.ndarray, p: np.ndarray, q: np.ndarray
) -> np.ndarray:
    """(b,) least length of the deviator on the best of a few circles around (u, v) on which it
    turns as around the zero p z + q conj(z); 0 where there is none."""
    best = np.zeros(len(u))
    turns = np.sign(np.abs(p) - np.abs(q))
    angle = 2.0 * np.pi * np.arange(CIRCLE) / CIRCLE
    cosine, sine = np.cos(angle)[:, None], np.sin(angle)[:, None]
    for size in CIRCLES:
        around = deviator_at(fit.coefficients, u + size * cosine, v + size * sine)
        jump = np.angle(np.roll(around, -1, axis=0) * around.conj())
        right = np.rint(jump.sum(axis=0) / (2.0 * np.pi)) == turns
        best = np.where(right, np.maximum(best, np.abs(around).min(axis=0)), best)
    return best
