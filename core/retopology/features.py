"""Edges that a cross field runs along: creases, edges marked sharp, open borders."""

from __future__ import annotations

import numpy as np

from ..mesh.creases import bent_half_edges, marked_half_edges
from ..mesh.surface import Surface
from .settings import GuidanceSettings


def feature_half_edges(
    surface: Surface, settings: GuidanceSettings, sharp: np.ndarray | None
) -> np.ndarray:
    """Half-edges on features, one of each edge, ascending.

    Parameters
    ----------
    sharp:
        (s, 2) pairs of input vertices whose edges are marked sharp, or None.
    """
    found = [np.flatnonzero(surface.twin < 0)] if settings.align_borders else []
    if settings.feature_angle < 180.0:
        found.append(bent_half_edges(surface, settings.feature_angle))
    if settings.align_sharp:
        found.append(marked_half_edges(surface, sharp))
    return np.unique(np.concatenate(found)) if found else np.zeros(0, np.int64)


def is_convex(surface: Surface, half_edges: np.ndarray) -> np.ndarray:
    """(e,) bool, True where the surface bends outwards at an edge, and on borders."""
    twin = surface.twin[half_edges]
    normal, _ = surface.face_normal_area
    inner = twin >= 0
    opposite = surface.triangles.ravel()[np.where(twin % 3 == 0, twin + 2, twin - 1)]
    tail = surface.triangles.ravel()[half_edges]
    height = np.einsum(
        "ec,ec->e",
        normal[half_edges // 3],
        surface.vertices[opposite] - surface.vertices[tail],
    )
    return ~inner | (height <= 0)


def along_features(
    surface: Surface, settings: GuidanceSettings, sharp: np.ndarray | None, axis: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Which vertices lie on features, and the fourth power of their direction there.

    Parameters
    ----------
    axis:
        (3, n) complex tangent frames e1 + i e2.

    Returns
    -------
    feature, wanted:
        (n,) bool and (n,) complex128: the mean over the feature's edges at the vertex, of
        length 1 where they agree up to right angles and near 0 where they do not.
    """
    n = len(surface.vertices)
    edges = feature_half_edges(surface, settings, sharp)
    total, count = np.zeros(n, complex), np.zeros(n)
    tail = surface.triangles.ravel()[edges]
    head = surface.triangles[:, [1, 2, 0]].ravel()[edges]
    along = surface.vertices[head] - surface.vertices[tail]
    for corner in (tail, head):
        value = np.einsum("ce,ec->e", axis[:, corner], along)
        size = np.abs(value)
        value = np.divide(value, size, out=np.zeros_like(value), where=size > 0) ** 4
        total += np.bincount(corner, weights=value.real, minlength=n)
        total += 1j * np.bincount(corner, weights=value.imag, minlength=n)
        count += np.bincount(corner, minlength=n)
    return count > 0, total / np.maximum(count, 1)
