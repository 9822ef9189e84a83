"""Planes of symmetry, of a mesh and of its umbilics."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize
from scipy.spatial import cKDTree

import core


@dataclass(frozen=True)
class Mirror:
    """The plane n.x = c; `residual` is the median distance that mirroring leaves."""

    normal: np.ndarray
    offset: float
    residual: float

    def image(self, points: np.ndarray) -> np.ndarray:
        """(k, 3) mirrored points."""
        return points - 2.0 * (points @ self.normal - self.offset)[:, None] * self.normal


def of_mesh(vertices: np.ndarray) -> Mirror:
    """The plane, near one across a coordinate axis, that mirrors the vertices best."""
    sample = vertices[:: max(len(vertices) // 1000, 1)]
    tree = cKDTree(vertices)
    size = np.ptp(vertices, axis=0).max()

    def mirror(parameters: np.ndarray, axis: int) -> tuple[np.ndarray, float]:
        normal = np.eye(3)[axis].copy()
        normal[[(axis + 1) % 3, (axis + 2) % 3]] = parameters[1:]
        return normal / np.linalg.norm(normal), parameters[0] * size

    def residual(parameters: np.ndarray, axis: int) -> float:
        plane = Mirror(*mirror(parameters, axis), 0.0)
        distance, _ = tree.query(plane.image(sample))
        # The mean of what is well mirrored: parts without a counterpart must not pull.
        return float(np.sort(distance)[: int(0.8 * len(distance))].mean())

    best = None
    for axis in range(3):
        middle = 0.5 * (vertices[:, axis].min() + vertices[:, axis].max()) / size
        for shift in (-0.04, 0.0, 0.04):
            start = (middle + shift, 0.0, 0.0)
            found = minimize(residual, start, args=(axis,), method="Nelder-Mead")
            if best is None or found.fun < best[0]:
                best = (found.fun, *mirror(found.x, axis))
    plane = Mirror(best[1], float(best[2]), 0.0)
    distance, _ = tree.query(plane.image(sample))
    return Mirror(plane.normal, plane.offset, float(np.median(distance)))


def mirrored_share(
    umbilics: core.Umbilics, mirror: Mirror, reach: float, vertices: np.ndarray
) -> tuple[float, float]:
    """The share of umbilics with one of their index within `reach` of their mirror image, and
    the same for vertices taken at random."""
    hits, chance = 0, 0.0
    for sign in (-1.0, 1.0):
        rows = np.sign(umbilics.index) == sign
        if not rows.any():
            continue
        points = umbilics.position[rows]
        tree = cKDTree(points)
        hits += np.count_nonzero(tree.query(mirror.image(points))[0] <= reach)
        near = tree.query(mirror.image(vertices))[0] <= reach
        chance += near.mean() * len(points)
    return hits / max(len(umbilics), 1), chance / max(len(umbilics), 1)


def from_umbilics(umbilics: core.Umbilics, reach: float) -> Mirror:
    """The plane between two umbilics that mirrors most of them onto others.

    Every two umbilics of the same index whose curvatures differ by less than a fifth propose
    the plane half way between them; those that are mirrored within `reach` vote.
    """
    position, index, curvature = umbilics.position, umbilics.index, umbilics.curvature
    first, second = np.triu_indices(len(umbilics), 1)
    alike = (index[first] == index[second]) & (
        np.abs(curvature[first] - curvature[second])
        < 0.2 * np.maximum(np.abs(curvature[first]), np.abs(curvature[second]))
    )
    first, second = first[alike], second[alike]
    step = position[second] - position[first]
    length = np.linalg.norm(step, axis=1)
    far = length > 5.0 * reach
    normal = step[far] / length[far, None]
    offset = np.einsum("ij,ij->i", normal, 0.5 * (position[first] + position[second])[far])
    trees = {sign: cKDTree(position[index == sign]) for sign in np.unique(index)}
    best, most = Mirror(np.array([1.0, 0.0, 0.0]), 0.0, np.nan), -1.0
    for n, c in zip(normal, offset, strict=True):
        plane = Mirror(n, float(c), 0.0)
        votes = 0.0
        for sign, tree in trees.items():
            distance, _ = tree.query(plane.image(position[index == sign]))
            # Nearer images count more, so that of the planes around the best one it is taken.
            votes += np.clip(1.0 - distance / reach, 0.0, None).sum()
        if votes > most:
            best, most = plane, votes
    return best


def difference(one: Mirror, other: Mirror, vertices: np.ndarray) -> tuple[float, float]:
    """Angle between two planes in degrees and their distance at the middle of the mesh."""
    cosine = float(np.clip(one.normal @ other.normal, -1.0, 1.0))
    middle = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    sign = np.sign(cosine) or 1.0
    apart = (one.normal @ middle - one.offset) - sign * (other.normal @ middle - other.offset)
    return float(np.degrees(np.arccos(abs(cosine)))), float(abs(apart))
