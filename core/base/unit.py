"""Vectors and complex numbers made one long, what becomes of those that are nothing, the angles
between them and what is across them."""

from __future__ import annotations

import numpy as np


def unit(vectors: np.ndarray) -> np.ndarray:
    """(..., 3) vectors made one long; zero vectors stay zero."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0)


def cross(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """(..., 3) vectors across two (..., 3): to the bit what `numpy.cross` gives, which takes a
    multiple of the time where there are few."""
    x, y, z = one[..., 0], one[..., 1], one[..., 2]
    u, v, w = other[..., 0], other[..., 1], other[..., 2]
    found = np.empty(np.broadcast_shapes(one.shape, other.shape))
    np.subtract(y * w, z * v, out=found[..., 0])
    np.subtract(z * u, x * w, out=found[..., 1])
    np.subtract(x * v, y * u, out=found[..., 2])
    return found


def angles_between(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """(...) radians between unit vectors (..., 3): by their differences, which tell small angles
    better than cosines do."""
    apart = one - other
    half = 0.5 * np.sqrt(np.einsum("...c,...c->...", apart, apart))
    return np.asarray(2.0 * np.arcsin(np.clip(half, 0.0, 1.0)))


def phase(values: np.ndarray) -> np.ndarray:
    """Complex numbers made one long; 1, no turn at all, where they are zero and leave it open."""
    size = np.abs(values)
    return np.divide(values, size, out=np.ones_like(values), where=size > 0)
