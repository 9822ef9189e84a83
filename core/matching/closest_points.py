"""Iterated closest points between shapes that need not overlap everywhere.

Distances are measured to the tangent planes (Chen & Medioni 1992, doi
10.1016/0262-8856(92)90066-C). How much of the shapes overlaps is chosen with the motion: the share
f of the nearest points for which their root mean square distance over f^1.3 is least (Phillips, Liu
& Tomasi 2007, doi 10.1109/3DIM.2007.39), which neither takes points without a counterpart nor
leaves good ones out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from .covariance import clustered_covariance
from .proposals import Similarity
from .shape import ROUGH, Shape

# From 0.5 to 3 the same 21 of 24 parts of the hand, Spot and the rocker arm are brought onto the
# whole (a quarter to all of the surface, errors of 0 to 0.3 edges), with less the slower; 60 % of
# the torso are with 0.5, 0.95, 1.6 and 3, and elsewhere with 1.3 and 2.
_POWER = 1.3
# Least share of the samples that is believed to be an overlap.
LEAST_OVERLAP = 0.2
# Distance, in sizes, beyond which a sample has no counterpart.
FAR = 0.15
# Standard deviations within which samples count at the end, and steps there.
_DEVIATIONS, _POLISHING, _CHECKING = 3.0, 15, 4
# Cosine of normals within a pair.
_FACING = 0.5


@dataclass(frozen=True)
class Fit:
    """A motion and how well the shapes lie on each other.

    Attributes
    ----------
    motion:
        Of the first shape onto the second.
    overlap:
        Share of the first shape's surface that lies on the second.
    error:
        Root mean square distance to the second shape there, in its units.
    worth:
        error over overlap^1.3 in units of the first shape: the less the better.
    equations:
        Those of the last step.
    """

    motion: Similarity
    overlap: float
    error: float
    worth: float
    equations: Equations


@dataclass(frozen=True)
class Equations:
    """What a small motion changes in the heights of samples over the planes that they meet.

    Attributes
    ----------
    image:
        (s, 3) where the samples are.
    design:
        (s, 7) derivatives of the heights by a rotation about the middle in radians, a shift and
        the logarithm of the scale; (s, 6) without the last for rigid motions.
    height:
        (s,) signed, in length.
    middle:
        (3,) about which the rotation is meant.
    """

    image: np.ndarray
    design: np.ndarray
    height: np.ndarray
    middle: np.ndarray

    def moved(self, motion: Similarity) -> Similarity:
        """The motion followed by the small one that makes the heights least."""
        matrix, right = self.design.T @ self.design, -self.design.T @ self.height
        step = np.linalg.lstsq(matrix, right, rcond=1e-10)[0]
        turn = rotation_by(step[:3])
        grow = float(np.exp(np.clip(step[6], -0.2, 0.2))) if len(step) == 7 else 1.0
        shift = grow * (turn @ (motion.shift - self.middle)) + self.middle + step[3:6]
        return Similarity(turn @ motion.rotation, grow * motion.scale, shift)

    def covariance(self, places: np.ndarray) -> np.ndarray:
        """(7, 7) or (6, 6) of the small motion's parts; samples at neighbouring `places` (s, d)
        may be wrong together."""
        return clustered_covariance(self.design, self.height, places)


def refined(
    start: Similarity, one: Shape, other: Shape, scaled: bool, steps: int, rough: bool = False
) -> Fit | None:
    """The best fit that `steps` of iterated closest points meet from a start, a `rough` one of
    fewer samples; None where the shapes hardly meet."""
    points, normals = one.samples
    target = other.target
    if rough:
        points, normals, target = points[:ROUGH], normals[:ROUGH], other.rough_target
    least = int(LEAST_OVERLAP * len(points))
    best: Fit | None = None
    motion = start
    for _ in range(steps):
        met = _met(motion, (points, normals), target, other)
        rows = np.flatnonzero(met.usable)
        if len(rows) <= least:
            break
        height = met.height
        rows = rows[np.argsort(np.abs(height[rows]), kind="stable")]
        share = np.arange(1, len(rows) + 1) / len(points)
        rms = np.sqrt(np.cumsum(height[rows] ** 2) / np.arange(1, len(rows) + 1))
        # Not below what the samples resolve: else a few perfect points would win.
        floor = 1e-4 * other.size
        worth = np.hypot(rms, floor) / (motion.scale * share**_POWER)
        worth[:least] = np.inf
        cut = int(np.argmin(worth)) + 1
        rows = rows[:cut]
        system = met.equations(rows, scaled)
        fit = Fit(
            motion,
            float(share[cut - 1]),
            float(rms[cut - 1]),
            float(worth[cut - 1]),
            system,
        )
        if best is not None and fit.worth >= best.worth * (1.0 - 1e-6):
            break
        best = fit
        motion = system.moved(motion)
    return best


def polished(
    fit: Fit, one: Shape, other: Shape, scaled: bool, far: float, fine: bool = True
) -> Fit:
    """The fit over all of both shapes' overlap, `fine` over more samples and to the end, with its
    true error.

    What is left out are samples without a counterpart alone: within some standard deviations all
    count, so that the error is not that of the best ones. What lies nearer than `far` overlaps.
    """
    motion = fit.motion
    # Of the nearest share of normal deviates the root mean square falls short; a little more is
    # no matter, as what counts is chosen anew.
    reach = _DEVIATIONS * 1.5 * max(fit.error, 1e-6 * other.size)
    samples = one.fine_samples if fine else one.samples
    for _ in range(_POLISHING if fine else _CHECKING):
        met = _met(motion, samples, other.target, other)
        rows = np.flatnonzero(met.usable & (np.abs(met.height) <= reach))
        if len(rows) <= 10:
            return fit
        system = met.equations(rows, scaled)
        error = float(np.sqrt(np.mean(met.height[rows] ** 2)))
        fit = Fit(
            motion,
            float(np.mean(met.usable & (np.abs(met.height) <= max(far, reach)))),
            error,
            fit.worth,
            system,
        )
        reach = _DEVIATIONS * max(error, 1e-6 * other.size)
        motion = system.moved(motion)
    return fit


@dataclass(frozen=True)
class _Met:
    """Samples (s, 3) where a motion takes them, the points and normals of the other shape nearest
    to them, their height over the plane there, and which have a counterpart."""

    image: np.ndarray
    goal: np.ndarray
    normal: np.ndarray
    height: np.ndarray
    usable: np.ndarray

    def equations(self, rows: np.ndarray, scaled: bool) -> Equations:
        """Of n . (x + w x (x - m) + v + s (x - m) - goal) over the rows."""
        image, normal = self.image[rows], self.normal[rows]
        middle = image.mean(axis=0)
        arm = image - middle
        columns = [np.cross(arm, normal), normal]
        if scaled:
            columns.append(np.einsum("sc,sc->s", arm, normal)[:, None])
        return Equations(image, np.concatenate(columns, axis=1), self.height[rows], middle)


def _met(
    motion: Similarity,
    samples: tuple[np.ndarray, np.ndarray],
    target: tuple[cKDTree, np.ndarray],
    other: Shape,
) -> _Met:
    points, normals = samples
    tree, planes = target
    image = motion(points)
    # Without a bound the search from afar would go through the whole tree.
    distance, near = tree.query(image, distance_upper_bound=FAR * other.size)
    there = np.isfinite(distance)
    near = np.where(there, near, 0)
    normal, goal = planes[near], np.asarray(tree.data)[near]
    facing = np.einsum("sc,sc->s", normals @ motion.rotation.T, normal) > _FACING
    # Beside a border the nearest point is no counterpart: only what lies above a plane is.
    height = np.einsum("sc,sc->s", image - goal, normal)
    aside = np.sqrt(np.maximum(np.where(there, distance, 0.0) ** 2 - height**2, 0.0))
    usable = there & facing & (aside <= _reach_aside(other, len(planes)) + 2.0 * np.abs(height))
    return _Met(image, goal, normal, height, usable)


def _reach_aside(other: Shape, count: int) -> float:
    """How far beside a sample its own plane still stands for the surface: three times the mean
    distance of samples."""
    area = float(other.face_normal_area[1].sum())
    return 3.0 * float(np.sqrt(area / count))


def rotation_by(vector: np.ndarray) -> np.ndarray:
    """(3, 3) rotation about a vector by its length in radians (Rodrigues)."""
    angle = float(np.linalg.norm(vector))
    if angle == 0.0:
        return np.eye(3)
    x, y, z = vector / angle
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * (cross @ cross)
