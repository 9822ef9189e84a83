"""Angles of triangles and their cotangents, of which discrete Laplacians are made."""

from __future__ import annotations

import numpy as np

from .lscm import flattened

# Cotangents beyond this are of slivers, whose round-off must not rule an equation.
_STEEPEST = 1e4


def angles_and_cotangents(
    vertices: np.ndarray, triangles: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(m, 3) angles at the corners of triangles, in radians, and their cotangents."""
    flat = flattened(vertices, triangles)
    to_next = np.roll(flat, -1, axis=1) - flat
    to_last = np.roll(flat, 1, axis=1) - flat
    spanned = np.conj(to_next) * to_last
    across = np.maximum(spanned.imag, np.finfo(float).tiny)
    most = _STEEPEST * across
    cotangent = np.clip(spanned.real, -most, most) / across
    return np.abs(np.angle(spanned)), cotangent
