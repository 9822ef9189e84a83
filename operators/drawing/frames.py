"""Frames of umbilics: z along the normal, x along a separatrix."""

from __future__ import annotations

import numpy as np

from ... import core


def _middle(separatrix: np.ndarray) -> np.ndarray:
    """(k, 3) of each umbilic's separatrices (k, 3, 3) the one amid the others, or NaN."""
    known = np.nan_to_num(separatrix)
    along = np.einsum("kij,kj->ki", known, known.sum(axis=1))
    along = np.where(np.isfinite(separatrix[:, :, 0]), along, -np.inf)
    return separatrix[np.arange(len(separatrix)), np.argmax(along, axis=1)]


def frames_of(umbilics: core.Umbilics) -> np.ndarray:
    """(k, 4, 4) world matrices: z along the normal, x along a separatrix where it is known."""
    z = umbilics.normal
    across = _middle(umbilics.separatrix)
    known = np.isfinite(across).all(axis=1, keepdims=True)
    # Elsewhere any tangent will do: the axis least along the normal, made perpendicular to it.
    least = np.eye(3)[np.argmin(np.abs(z), axis=1)] if len(z) else z
    across = np.where(known, across, least)
    x = across - np.sum(across * z, axis=1, keepdims=True) * z
    x = x / np.maximum(np.linalg.norm(x, axis=1, keepdims=True), np.finfo(float).tiny)
    frames = np.zeros((len(z), 4, 4))
    frames[:, :3, 0] = x
    frames[:, :3, 1] = np.cross(z, x)
    frames[:, :3, 2] = z
    frames[:, :3, 3] = umbilics.position
    frames[:, 3, 3] = 1.0
    return frames
