"""Planes that pairs of umbilics propose: each maps one onto another of its kind and curvature."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from ..umbilics.result import UNCERTAIN, Umbilics

# Relative difference of curvature, and cosine of normals and separatrices, within a pair.
CURVATURE, NORMAL, RAY = 0.25, 0.85, 0.8
# Umbilics of which pairs are made: the most persistent ones.
MOST = 80
# Planes that are refined.
REFINED = 16
# Distance to its image, in sizes of the shape, at which an umbilic counts as matched.
MATCHED = 0.04


def proposed_planes(umbilics: Umbilics, size: float) -> list[tuple[np.ndarray, float]]:
    """Planes between umbilics that could be mirror images, those with the most votes first."""
    weight = np.nan_to_num(umbilics.persistence, nan=0.0, posinf=1e30)
    rows = np.argsort(-weight, kind="stable")[:MOST]
    one, two = np.triu_indices(len(rows), 1)
    one, two = rows[one], rows[two]
    curvature = umbilics.curvature
    larger = np.maximum(np.abs(curvature[one]), np.abs(curvature[two]))
    alike = _alike(umbilics, one, two)
    alike &= np.abs(curvature[one] - curvature[two]) <= CURVATURE * larger
    across = umbilics.position[one] - umbilics.position[two]
    length = np.linalg.norm(across, axis=1)
    alike &= length > 1e-6 * size
    one, two, across, length = one[alike], two[alike], across[alike], length[alike]
    if not len(one):
        return []
    normal = across / length[:, None]
    offset = 0.5 * np.einsum("pc,pc->p", normal, umbilics.position[one] + umbilics.position[two])
    image = _turned(umbilics.normal[one], normal)
    fits = np.einsum("pc,pc->p", image, umbilics.normal[two]) > NORMAL
    rays = _turned(umbilics.separatrix[one].transpose(1, 0, 2), normal).transpose(1, 0, 2)
    cosine = np.einsum("pic,pjc->pij", np.nan_to_num(rays), np.nan_to_num(umbilics.separatrix[two]))
    best = np.where(np.isfinite(rays[:, :, 0]), cosine.max(axis=2), 1.0).min(axis=1)
    fits &= best > RAY
    normal, offset = normal[fits], offset[fits]
    votes = np.array(
        [
            len(mirrored_pairs(umbilics.select(rows), axis, place, MATCHED * size))
            for axis, place in zip(normal, offset, strict=True)
        ],
        float,
    )
    chosen: list[tuple[np.ndarray, float]] = []
    for row in np.argsort(-votes, kind="stable"):
        new = all(
            abs(normal[row] @ axis) < 0.98
            or abs(offset[row] - np.sign(normal[row] @ axis) * place) > MATCHED * size
            for axis, place in chosen
        )
        if new:
            chosen.append((normal[row], float(offset[row])))
        if len(chosen) == REFINED:
            break
    return chosen


def _alike(umbilics: Umbilics, one: np.ndarray, two: np.ndarray) -> np.ndarray:
    """(p,) bool, umbilics of one index and, as far as that is known, of one kind."""
    kind, index = umbilics.kind, umbilics.index
    same = (kind[one] == kind[two]) | (kind[one] == UNCERTAIN) | (kind[two] == UNCERTAIN)
    return np.asarray(same & (index[one] == index[two]))


def _turned(vectors: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Vectors (…, p, 3) mirrored along unit normals (p, 3)."""
    return vectors - 2.0 * np.sum(vectors * normal, axis=-1, keepdims=True) * normal


def mirrored_pairs(
    umbilics: Umbilics, normal: np.ndarray, offset: float, reach: float
) -> np.ndarray:
    """(p, 2) umbilics whose mirror images lie within reach of one like them."""
    if not len(umbilics):
        return np.zeros((0, 2), np.int64)
    image = reflected(umbilics.position, normal, offset)
    distance, near = cKDTree(umbilics.position).query(image)
    rows = np.arange(len(umbilics))
    good = (distance <= reach) & _alike(umbilics, rows, near)
    pair = np.stack([rows, near], axis=1)[good]
    return np.unique(np.sort(pair, axis=1), axis=0)


def reflected(points: np.ndarray, normal: np.ndarray, offset: float | np.ndarray) -> np.ndarray:
    """Points (p, 3) mirrored in the plane at `offset` along a unit normal."""
    return points - 2.0 * (points @ normal - offset)[:, None] * normal
