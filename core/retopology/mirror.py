"""The mirror plane of a shape, from pairs of umbilics that are images of each other.

Pairs of the same kind and curvature propose planes; those that map many umbilics onto umbilics
are refined on the whole surface by iterated closest points (Besl & McKay 1992), with the plane
of least squares in closed form at each step.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from ..base.errors import GuidanceError
from ..base.progress import Progress
from ..mesh.samples import spread_points
from ..umbilics.result import Umbilics

# Relative difference of curvature, and cosine of normals and separatrices, within a pair.
CURVATURE, NORMAL, RAY = 0.25, 0.85, 0.8
# Umbilics of which pairs are made: the most persistent ones.
MOST = 80
# Planes that are refined, samples of the surface that refine them, and steps.
REFINED, SAMPLES, STEPS = 16, 1500, 40
# Of those as many are refined to the end.
FINALISTS = 3
# Below this error, in sizes, the vertices are each other's images, and samples would only blur it.
EXACT = 1e-7
# Steps that polish any other plane.
POLISHING = 10
# Part of the samples that count: a mark on one side must not tilt the plane.
TRIMMED = 0.85
# Distance to its image, in sizes of the shape, at which an umbilic counts as matched.
MATCHED = 0.04
# Root mean square distance, in sizes, beyond which the shape is not symmetric.
ASYMMETRIC = 0.004


@dataclass(frozen=True)
class MirrorPlane:
    """A plane of symmetry.

    Attributes
    ----------
    point, normal:
        (3,) float64 the point of the plane nearest to the middle of the shape, and its unit
        normal.
    error:
        Root mean square distance between the shape and its mirror image over the best 85 % of
        it, in length.
    score:
        0 to 1: 1 where the image lies on the shape, 0 at the limit of what counts as symmetric.
    pairs:
        (p, 2) int64 rows of the umbilics that are images of each other; equal on the plane.
    angle_error, offset_error:
        Standard errors of the plane's direction, in degrees, and of its distance from the middle
        of the shape, in length, as if the distances were independent at the vertices.
    """

    point: np.ndarray
    normal: np.ndarray
    error: float
    score: float
    pairs: np.ndarray
    angle_error: float
    offset_error: float


def find_mirror_plane(
    vertices: np.ndarray,
    face_normal_area: tuple[np.ndarray, np.ndarray],
    triangles: np.ndarray,
    umbilics: Umbilics,
    progress: Progress,
) -> MirrorPlane:
    """The best mirror plane of a surface.

    Parameters
    ----------
    vertices, triangles:
        (n, 3) and (m, 3) of the surface.
    face_normal_area:
        (m, 3) unit normals and (m,) areas.
    umbilics:
        k umbilics in the same coordinates.

    Raises
    ------
    GuidanceError
        There are too few umbilics, or no plane maps the surface onto itself.
    """
    size = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    middle, samples, target = _sampled(vertices, triangles, face_normal_area)
    planes = _proposed(umbilics, size)
    if not len(planes) and not len(umbilics):
        raise GuidanceError(
            "Too few umbilics match in kind and curvature to propose a mirror plane. Lower the "
            "persistence to keep more."
        )
    # Where noise has moved the umbilics: the plane of a mirrored shape lies across an axis of
    # inertia, through its middle.
    corner = vertices[triangles] - middle
    area = face_normal_area[1]
    sums = corner.sum(axis=1)
    # Of a triangle's second moments: its corners' and that of their sum, over 12 and its area.
    spread = np.einsum("t,tki,tkj->ij", area, corner, corner) + (area * sums.T) @ sums
    planes += [(axis, float(axis @ middle)) for axis in np.linalg.eigh(spread)[1].T]
    rough = []
    for done, plane in enumerate(planes):
        progress.step(0.8 * done / len(planes))
        rough.append(_refined(plane, samples, target, 4))
    rough.sort(key=lambda item: item[1])
    finals = [_refined(plane, samples, target, STEPS) for plane, _ in rough[:FINALISTS]]
    best, least = min(finals, key=lambda item: item[1])
    # On meshes that are symmetric vertex by vertex this finds the plane to the last digits.
    corners, tree = _of_vertices(vertices, triangles, face_normal_area)
    exact, remaining = _refined(best, corners, tree, STEPS)
    if remaining < least:
        best, least = exact, remaining
    if least > EXACT * size:
        best = _polished(best, middle, samples, target)
    angle_error, offset_error = _standard_errors(_tilt(best, middle, samples, target))
    normal, offset = best
    score = 1.0 - least / (ASYMMETRIC * size)
    if score <= 0.0:
        raise GuidanceError(
            "No mirror plane: the best one leaves the shape "
            f"{100.0 * least / size:.1f} % of its size away from its image."
        )
    if normal[np.abs(normal).argmax()] < 0:
        normal, offset = -normal, -offset
    return MirrorPlane(
        point=middle - (middle @ normal - offset) * normal,
        normal=normal,
        error=float(least),
        score=float(score),
        pairs=_pairs(umbilics, normal, offset, MATCHED * size),
        angle_error=angle_error,
        offset_error=offset_error,
    )


def _sampled(
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


@dataclass(frozen=True)
class _Tilt:
    """How the distances of mirrored samples to the tangent planes change with the plane: (s, 3)
    for a tilt about two axes (2, 3) and a move, and (s,) the distances themselves."""

    design: np.ndarray
    off: np.ndarray
    axes: np.ndarray


def _tilt(
    plane: tuple[np.ndarray, float],
    middle: np.ndarray,
    samples: np.ndarray,
    target: tuple[cKDTree, np.ndarray],
) -> _Tilt:
    normal, offset = plane
    tree, normals = target
    image = _reflected(samples, normal, offset)
    distance, near = tree.query(image)
    order = np.argsort(distance)[: int(TRIMMED * len(distance))]
    across = normals[near[order]]
    off = np.einsum("sc,sc->s", image[order] - tree.data[near[order]], across)
    # Within three standard deviations, not the nearest ones: these would say too little.
    kept = np.abs(off) <= 3.0 * np.sqrt(np.mean(off**2))
    order, across, off = order[kept], across[kept], off[kept]
    arm = samples[order] - middle
    height = samples[order] @ normal - offset
    along = across @ normal
    one = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
    one /= np.linalg.norm(one)
    axes = np.stack([one, np.cross(normal, one)])
    # The image p - 2 (n p - o) n changes by -2 (dn p) n - 2 (n p - o) dn and by 2 do n.
    columns = [-2.0 * (arm @ axis) * along - 2.0 * height * (across @ axis) for axis in axes]
    return _Tilt(np.stack([*columns, 2.0 * along], axis=1), off, axes)


def _polished(
    plane: tuple[np.ndarray, float],
    middle: np.ndarray,
    samples: np.ndarray,
    target: tuple[cKDTree, np.ndarray],
) -> tuple[np.ndarray, float]:
    """The plane for which the distances to the tangent planes are least (Gauss and Newton)."""
    for _ in range(POLISHING):
        tilt = _tilt(plane, middle, samples, target)
        step = np.linalg.lstsq(tilt.design, -tilt.off, rcond=1e-10)[0]
        normal, offset = plane
        turned = normal + step[:2] @ tilt.axes
        turned /= np.linalg.norm(turned)
        # The tilt is about the middle.
        plane = turned, float(turned @ middle + (offset - normal @ middle) + step[2])
    return plane


def _standard_errors(tilt: _Tilt) -> tuple[float, float]:
    """Of the plane's direction, in degrees, and of its distance from the middle.

    Samples that are each other's images tell the same: half of them count.
    """
    spread = np.linalg.pinv(tilt.design.T @ tilt.design)
    deviation = np.sqrt(2.0 * np.mean(tilt.off**2) * np.maximum(np.diag(spread), 0.0))
    return float(np.degrees(np.hypot(*deviation[:2]))), float(deviation[2])


def _of_vertices(
    vertices: np.ndarray, triangles: np.ndarray, face_normal_area: tuple[np.ndarray, np.ndarray]
) -> tuple[Any, ...]:
    """Some vertices to reflect, and a tree of all of them with their normals."""
    normal, area = face_normal_area
    total: np.ndarray = np.stack(
        [
            np.bincount(
                triangles.ravel(), np.repeat(normal[:, axis] * area, 3), minlength=len(vertices)
            )
            for axis in range(3)
        ],
        axis=1,
    )
    total /= np.maximum(np.linalg.norm(total, axis=1, keepdims=True), np.finfo(float).tiny)
    step = max(1, len(vertices) // (4 * SAMPLES))
    return vertices[::step], (cKDTree(vertices), total)


def _reflected(points: np.ndarray, normal: np.ndarray, offset: float | np.ndarray) -> np.ndarray:
    return points - 2.0 * (points @ normal - offset)[:, None] * normal


def _proposed(umbilics: Umbilics, size: float) -> list[tuple[np.ndarray, float]]:
    """Planes between umbilics that could be mirror images, those with the most votes first."""
    weight = np.nan_to_num(umbilics.persistence, nan=0.0, posinf=1e30)
    rows = np.argsort(-weight, kind="stable")[:MOST]
    one, two = np.triu_indices(len(rows), 1)
    one, two = rows[one], rows[two]
    curvature = umbilics.curvature
    larger = np.maximum(np.abs(curvature[one]), np.abs(curvature[two]))
    alike = umbilics.kind[one] == umbilics.kind[two]
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
            len(_pairs(umbilics.select(rows), axis, place, MATCHED * size))
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


def _turned(vectors: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Vectors (…, p, 3) mirrored along unit normals (p, 3)."""
    return vectors - 2.0 * np.sum(vectors * normal, axis=-1, keepdims=True) * normal


def _pairs(umbilics: Umbilics, normal: np.ndarray, offset: float, reach: float) -> np.ndarray:
    """(p, 2) umbilics whose mirror images lie within reach of one of the same kind."""
    if not len(umbilics):
        return np.zeros((0, 2), np.int64)
    image = _reflected(umbilics.position, normal, offset)
    distance, near = cKDTree(umbilics.position).query(image)
    good = (distance <= reach) & (umbilics.kind[near] == umbilics.kind)
    pair = np.stack([np.arange(len(umbilics)), near], axis=1)[good]
    return np.unique(np.sort(pair, axis=1), axis=0)


def _refined(
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
        image = _reflected(samples, *plane)
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
