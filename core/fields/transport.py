"""Carrying tangent vectors between tangent planes."""

from __future__ import annotations

import numpy as np

from ..base.unit import phase
from .frames import frame

# Normals closer to opposite than this have no unique smallest rotation between them.
_OPPOSITE = 1e-12


def tangents(normals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit tangents (n, 3) with e1 x e2 = normal for unit normals (n, 3)."""
    e1, e2 = frame(normals.T)
    return np.ascontiguousarray(e1.T), np.ascontiguousarray(e2.T)


def carried(vectors: np.ndarray, source: np.ndarray, target: np.ndarray) -> np.ndarray:
    """Tangent vectors at unit normals `source`, turned by the smallest rotation to `target`.

    All arguments and the result are (n, 3). For v perpendicular to the source normal s the
    rotation s -> t gives v - (s + t) (v.t) / (1 + s.t). Between opposite normals it is not
    unique; v itself is returned then, which is tangent to both.
    """
    cosine = np.einsum("ij,ij->i", source, target)
    along = np.einsum("ij,ij->i", vectors, target) / np.maximum(1.0 + cosine, _OPPOSITE)
    return vectors - (source + target) * along[:, None]


def rotation(source: np.ndarray, target: np.ndarray) -> np.ndarray:
    """(r,) complex, of length one: a tangent vector that is the complex number z in the frame
    m = e1 + i e2 (3, r) of one tangent plane is z times this in that of another, carried there by
    the smallest rotation.

    It is conj(m_source) . m_target, the rotation in the polar decomposition of the projection
    between the planes; 1 between opposite ones.
    """
    return phase(np.einsum("cr,cr->r", source.conj(), target))


def as_complex(vectors: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """(...) complex128: tangent vectors (..., 3) in orthonormal axes x, y (..., 3)."""
    real = np.einsum("...c,...c->...", vectors, x)
    return np.asarray(real + 1j * np.einsum("...c,...c->...", vectors, y))


def doubled_angle(
    vectors: np.ndarray, e1: np.ndarray, e2: np.ndarray, length: np.ndarray | float = 1.0
) -> np.ndarray:
    """(n,) complex: unit tangents (n, 3) in the frames e1, e2 with their angle doubled, times
    `length`; the deviator of an operator with this direction and that gap."""
    return length * as_complex(vectors, e1, e2) ** 2
