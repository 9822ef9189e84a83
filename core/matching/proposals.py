"""Similarities that pairs of umbilics propose, and how many umbilics agree with each.

Two umbilics and their normals make a frame with a length. What it looks like from within (angles,
curvatures times the length, cubic invariants) does not change with pose and scale, as in the pair
features of Drost et al. (2010, doi 10.1109/CVPR.2010.5540108); pairs that look alike propose the
similarity that takes one onto the other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from ..base.unit import unit
from ..umbilics.result import Umbilics
from .shape import Shape

# What counts as alike: in the cosines of a pair, in the inverse hyperbolic sine of curvature times
# length, in |q| / (|p| + |q|), in the logarithm of a length. Chosen on ellipsoids and on the hand
# under noise of 5 % of an edge; held on the bunny, spot and the rocker arm.
_COSINE, _CURVATURE, _CUBIC, _LENGTH = 0.06, 0.2, 0.15, 0.03
# Pairs of the other shape that each pair is held against, and proposals that are counted: bounds
# of the work. Of 24 parts of the hand, Spot and the rocker arm (a quarter to all of the surface,
# errors of 0 to 0.3 edges) the same 21 are brought onto the whole with 1 to 16 and with 100 to
# 10,000; 60 % of the torso are with one pair, and elsewhere with the others.
_NEAREST, _COUNTED = 8, 3000
# Distance, in sizes, at which an umbilic meets another, cosine of their normals, and relative
# difference of their curvatures.
REACH, NORMAL, CURVATURE = 0.04, 0.8, 0.25


@dataclass(frozen=True)
class Similarity:
    """x -> scale * rotation @ x + shift."""

    rotation: np.ndarray
    scale: float
    shift: np.ndarray

    def __call__(self, points: np.ndarray) -> np.ndarray:
        """The points (k, 3), moved."""
        return self.scale * (points @ self.rotation.T) + self.shift

    @property
    def matrix(self) -> np.ndarray:
        """(4, 4) of homogeneous coordinates."""
        matrix = np.eye(4)
        matrix[:3, :3] = self.scale * self.rotation
        matrix[:3, 3] = self.shift
        return matrix


@dataclass(frozen=True)
class Motions:
    """(h, 3, 3) rotations, (h,) scales and (h, 3) shifts of as many similarities."""

    rotation: np.ndarray
    scale: np.ndarray
    shift: np.ndarray

    @classmethod
    def of_frames(
        cls,
        frame: np.ndarray,
        onto: np.ndarray,
        place: np.ndarray,
        goal: np.ndarray,
        scale: np.ndarray,
    ) -> Motions:
        """Those by factors `scale` (h,) that take frames (h, 3, 3), axes in columns, at places
        (h, 3) onto others at their goals."""
        rotation = onto @ frame.transpose(0, 2, 1)
        moved = np.einsum("hij,hj->hi", rotation, place)
        return cls(rotation, scale, goal - scale[:, None] * moved)


def proposed(one: Shape, other: Shape, scaled: bool, count: int) -> list[Similarity]:
    """At most `count` similarities of shape `one` onto `other`, those with the most votes first.

    With `scaled` their sizes may differ; else all are rigid motions.
    """
    ours, theirs = _pairs(one, scaled), _pairs(other, scaled)
    if ours is None or theirs is None:
        return []
    away, near = cKDTree(theirs.feature).query(
        ours.feature, k=min(_NEAREST, len(theirs.feature)), distance_upper_bound=6.0
    )
    near = near.reshape(len(ours.feature), -1)
    away = away.reshape(near.shape)
    row, place = np.nonzero(np.isfinite(away))
    order = np.argsort(away[row, place], kind="stable")[:_COUNTED]
    a, b = row[order], near[row[order], place[order]]
    scale = theirs.length[b] / ours.length[a] if scaled else np.ones(len(a))
    motions = Motions.of_frames(
        ours.frame[a], theirs.frame[b], ours.middle[a], theirs.middle[b], scale
    )
    return voted(one, other, motions, count)


def singly_proposed(one: Shape, other: Shape, scaled: bool, count: int) -> list[Similarity]:
    """As `proposed`, from single umbilics: each has a normal, directions of its separatrices and a
    curvature. Less sharp than pairs, for shapes that have hardly any in common."""
    a, ours = _frames(one.umbilics)
    b, theirs = _frames(other.umbilics)
    if not len(a) or not len(b):
        return []
    first, second = (grid.ravel() for grid in np.meshgrid(np.arange(len(a)), np.arange(len(b))))
    i, j = a[first], b[second]
    bent, wanted = one.umbilics.curvature[i], other.umbilics.curvature[j]
    off = np.abs(one.cubic[1][i] - other.cubic[1][j])
    alike = np.sign(one.umbilics.index[i]) == np.sign(other.umbilics.index[j])
    alike &= (off < _CUBIC) & (bent * wanted > 0)
    if not scaled:
        larger = np.maximum(np.abs(bent), np.abs(wanted))
        alike &= np.abs(bent - wanted) <= CURVATURE * larger
    order = np.flatnonzero(alike)
    order = order[np.argsort(off[order], kind="stable")][:_COUNTED]
    i, j = i[order], j[order]
    scale = bent[order] / wanted[order] if scaled else np.ones(len(order))
    here, there = one.umbilics.position[i], other.umbilics.position[j]
    motions = Motions.of_frames(ours[first[order]], theirs[second[order]], here, there, scale)
    return voted(one, other, motions, count)


def _frames(umbilics: Umbilics) -> tuple[np.ndarray, np.ndarray]:
    """(f,) umbilics and (f, 3, 3) frames of normal and separatrix, one for each separatrix."""
    row, ray = np.nonzero(np.isfinite(umbilics.separatrix[:, :, 0]))
    along, normal = umbilics.separatrix[row, ray], umbilics.normal[row]
    along = unit(along - np.einsum("fc,fc->f", along, normal)[:, None] * normal)
    return row, np.stack([along, normal, np.cross(along, normal)], axis=2)


def voted(one: Shape, other: Shape, motions: Motions, count: int) -> list[Similarity]:
    """At most `count` of the motions that are apart from each other, with the most votes first."""
    votes = _votes(one, other, motions)
    chosen: list[Similarity] = []
    corners = _corners(one)
    for h in np.argsort(-votes, kind="stable"):
        motion = Similarity(motions.rotation[h], float(motions.scale[h]), motions.shift[h])
        if all(_apart(motion, kept, corners) > REACH * other.size for kept in chosen):
            chosen.append(motion)
        if len(chosen) == count:
            break
    return chosen


@dataclass(frozen=True)
class _Pairs:
    """Ordered pairs of umbilics: (h, f) features in units of their tolerance, (h, 3, 3) frames,
    (h, 3) middles and (h,) lengths."""

    feature: np.ndarray
    frame: np.ndarray
    middle: np.ndarray
    length: np.ndarray


def _pairs(shape: Shape, scaled: bool) -> _Pairs | None:
    umbilics = shape.umbilics
    count = len(umbilics)
    i, j = np.nonzero(~np.eye(count, dtype=bool))
    position, normal = umbilics.position, umbilics.normal
    across = position[j] - position[i]
    length = np.linalg.norm(across, axis=1)
    along = across / np.maximum(length, np.finfo(float).tiny)[:, None]
    up = normal[i] + normal[j]
    up -= np.einsum("hc,hc->h", up, along)[:, None] * along
    height = np.linalg.norm(up, axis=1)
    # Without a common side there is no frame, and close pairs have none that is sharp.
    sound = (height > 0.2) & (length > 0.05 * shape.size)
    if not sound.any():
        return None
    i, j, along, length = i[sound], j[sound], along[sound], length[sound]
    up = up[sound] / height[sound, None]
    frame = np.stack([along, up, np.cross(along, up)], axis=2)
    _, ratio = shape.cubic
    curvature = umbilics.curvature
    side = np.sign(umbilics.index)
    parts = [
        np.einsum("hc,hc->h", normal[i], along) / _COSINE,
        np.einsum("hc,hc->h", normal[j], along) / _COSINE,
        np.einsum("hc,hc->h", normal[i], normal[j]) / _COSINE,
        np.einsum("hc,hc->h", along, np.cross(normal[i], normal[j])) / _COSINE,
        np.arcsinh(curvature[i] * length) / _CURVATURE,
        np.arcsinh(curvature[j] * length) / _CURVATURE,
        ratio[i] / _CUBIC,
        ratio[j] / _CUBIC,
        # Of another index is another umbilic.
        100.0 * side[i],
        100.0 * side[j],
    ]
    if not scaled:
        parts.append(np.log(length) / _LENGTH)
    middle = 0.5 * (position[i] + position[j])
    return _Pairs(np.stack(parts, axis=1), frame, middle, length)


def matched(one: Shape, other: Shape, motion: Similarity) -> tuple[np.ndarray, np.ndarray]:
    """(p, 2) rows of the umbilics that meet, and (p,) their distances."""
    if not len(one.umbilics) or not len(other.umbilics):
        return np.zeros((0, 2), np.int64), np.zeros(0)
    motions = Motions(motion.rotation[None], np.array([motion.scale]), motion.shift[None])
    distance, near, good = _meeting(one.umbilics, other, motions)
    rows = np.flatnonzero(good[0])
    return np.stack([rows, near[0, rows]], axis=1), distance[0, rows]


def _meeting(
    ours: Umbilics, other: Shape, motions: Motions
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(h, k) distances to the umbilics nearest to where each motion takes ours, their rows, and
    whether the two could be the same."""
    theirs = other.umbilics
    turned = np.einsum("hij,kj->hki", motions.rotation, ours.position)
    places = motions.scale[:, None, None] * turned + motions.shift[:, None]
    distance, near = cKDTree(theirs.position).query(places)
    normal = np.einsum("hij,kj->hki", motions.rotation, ours.normal)
    good = distance <= REACH * other.size
    good &= np.einsum("hki,hki->hk", normal, theirs.normal[near]) > NORMAL
    good &= np.sign(ours.index) == np.sign(theirs.index[near])
    curvature = ours.curvature / motions.scale[:, None]
    larger = np.maximum(np.abs(curvature), np.abs(theirs.curvature[near]))
    good &= np.abs(curvature - theirs.curvature[near]) <= CURVATURE * larger
    return distance, near, good


def _votes(one: Shape, other: Shape, motions: Motions) -> np.ndarray:
    """(h,) how many umbilics meet, near ones more; of several that meet one only the nearest."""
    distance, near, good = _meeting(one.umbilics, other, motions)
    worth = np.where(good, 1.0 - distance / (REACH * other.size), 0.0)
    best = np.zeros((len(motions.scale), len(other.umbilics)))
    motion = np.broadcast_to(np.arange(len(best))[:, None], near.shape)
    np.maximum.at(best, (motion, near), worth)
    return best.sum(axis=1)


def _corners(shape: Shape) -> np.ndarray:
    low, high = shape.vertices.min(axis=0), shape.vertices.max(axis=0)
    unit = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    return np.asarray(low + unit * (high - low))


def _apart(one: Similarity, two: Similarity, corners: np.ndarray) -> float:
    return float(np.linalg.norm(one(corners) - two(corners), axis=1).max())
