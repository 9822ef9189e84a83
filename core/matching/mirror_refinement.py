"""A mirror plane refined on the surface: iterated closest points (Besl & McKay 1992).

Each step takes the plane of least squares in closed form, the last ones are Gauss and Newton's.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from ..mesh.samples import mean_normals, spread_points
from .covariance import clustered_covariance
from .mirror_planes import reflected

# Samples of the surface that refine a plane.
SAMPLES = 1500
# Steps that polish a plane.
POLISHING = 10
# Standard deviations within which samples count then.
DEVIATIONS = 3.0
# How far beside an image its counterpart may be, in medians of all.
ASIDE = 4.0
# Part of the samples that count before: a mark on one side must not tilt the plane.
TRIMMED = 0.85


def refined_plane(
    plane: tuple[np.ndarray, float],
    samples: np.ndarray,
    target: tuple[cKDTree, np.ndarray],
    steps: int,
) -> tuple[tuple[np.ndarray, float], float]:
    """Iterated closest points; the best plane that was met and its error.

    The error is measured to the tangent planes at the closest points, so that it does not
    depend on how densely they lie.
    """
    tree, normals = target
    best, least = plane, np.inf
    for _ in range(steps):
        image = reflected(samples, *plane)
        distance, near = tree.query(image)
        order = np.argsort(distance)[: int(TRIMMED * len(distance))]
        off = np.einsum("sc,sc->s", image - tree.data[near], normals[near])[order]
        error = float(np.sqrt(np.mean(off**2)))
        if error >= least:
            break
        best, least = plane, error
        source, goal = samples[order], tree.data[near[order]]
        # Reflections with |R p - q|^2 least: the middle of all pairs lies on the plane, and the
        # normal is the eigenvector of the least eigenvalue of the symmetric part of sum p q^T.
        middle = 0.5 * (source.mean(axis=0) + goal.mean(axis=0))
        spread = (source - middle).T @ (goal - middle)
        _, axes = np.linalg.eigh(spread + spread.T)
        plane = axes[:, 0], float(axes[:, 0] @ middle)
    return best, least


@dataclass(frozen=True)
class Tilt:
    """How the distances of mirrored samples to the tangent planes change with the plane: (s, 3)
    for a tilt about two axes (2, 3) and a move, and (s,) the distances themselves; (s, 3) the
    samples, those behind the plane mirrored."""

    design: np.ndarray
    off: np.ndarray
    axes: np.ndarray
    folded: np.ndarray


def tilt_of(
    plane: tuple[np.ndarray, float],
    middle: np.ndarray,
    samples: np.ndarray,
    target: tuple[cKDTree, np.ndarray],
    reach: float,
) -> Tilt:
    """Of the samples whose image lies within `reach` of a tangent plane: of the nearest ones alone
    the distances would hardly change with the plane."""
    normal, offset = plane
    tree, normals = target
    image = reflected(samples, normal, offset)
    distance, near = tree.query(image)
    across = normals[near]
    off = np.einsum("sc,sc->s", image - tree.data[near], across)
    # Beyond a border the nearest point is no counterpart.
    aside = np.sqrt(np.maximum(distance**2 - off**2, 0.0))
    kept = (np.abs(off) <= reach) & (aside <= ASIDE * np.median(aside))
    image, across, off = image[kept], across[kept], off[kept]
    arm = samples[kept] - middle
    height = samples[kept] @ normal - offset
    along = across @ normal
    one = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
    one /= np.linalg.norm(one)
    axes = np.stack([one, np.cross(normal, one)])
    # The image p - 2 (n p - o) n changes by -2 (dn p) n - 2 (n p - o) dn and by 2 do n.
    columns = [-2.0 * (arm @ axis) * along - 2.0 * height * (across @ axis) for axis in axes]
    folded = np.where(height[:, None] < 0.0, image, samples[kept])
    return Tilt(np.stack([*columns, 2.0 * along], axis=1), off, axes, folded)


def polished_plane(
    plane: tuple[np.ndarray, float],
    middle: np.ndarray,
    samples: np.ndarray,
    target: tuple[cKDTree, np.ndarray],
    reach: float,
) -> tuple[tuple[np.ndarray, float], float]:
    """The plane for which the distances to the tangent planes are least (Gauss and Newton), of
    samples within three standard deviations, and these."""
    for _ in range(POLISHING):
        tilt = tilt_of(plane, middle, samples, target, reach)
        step = np.linalg.lstsq(tilt.design, -tilt.off, rcond=1e-10)[0]
        normal, offset = plane
        turned = normal + step[:2] @ tilt.axes
        turned /= np.linalg.norm(turned)
        # The tilt is about the middle.
        plane = turned, float(turned @ middle + (offset - normal @ middle) + step[2])
        reach = DEVIATIONS * float(np.sqrt(np.mean(tilt.off**2)))
    return plane, reach


def standard_errors(tilt: Tilt) -> tuple[float, float]:
    """Of the plane's direction, in degrees, and of its distance from the middle."""
    deviation = np.sqrt(np.diag(clustered_covariance(tilt.design, tilt.off, tilt.folded)))
    return float(np.degrees(np.hypot(*deviation[:2]))), float(deviation[2])


def spread_samples(
    vertices: np.ndarray, triangles: np.ndarray, face_normal_area: tuple[np.ndarray, np.ndarray]
) -> tuple[Any, ...]:
    """Centroid, (s, 3) points spread by area, and a tree of a denser set with its normals."""
    _, area = face_normal_area
    centre = vertices[triangles].mean(axis=1)
    middle = np.average(centre, axis=0, weights=area)
    random = np.random.default_rng(0)
    samples, _ = spread_points(vertices, triangles, face_normal_area, SAMPLES, random)
    dense, normals = spread_points(vertices, triangles, face_normal_area, 16 * SAMPLES, random)
    return middle, samples, (cKDTree(dense), normals)


def vertex_samples(
    vertices: np.ndarray, triangles: np.ndarray, face_normal_area: tuple[np.ndarray, np.ndarray]
) -> tuple[Any, ...]:
    """Some vertices to reflect, and a tree of all of them with their normals."""
    normals = mean_normals(vertices, triangles, face_normal_area)
    step = max(1, len(vertices) // (4 * SAMPLES))
    return vertices[::step], (cKDTree(vertices), normals)
