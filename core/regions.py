"""Spherical and planar regions: areas where the gap of the curvatures is nothing but noise.

On a sphere, a plane or along a line of umbilics there are no isolated umbilics; the zeros that
an estimate of the shape operators has there are confetti. Each connected area is reported once,
with the sum of the indices of its triangles, which is the index of the direction field around
its border.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from .detection import Region
from .surface import Surface
from .tolerances import (
    PLANAR_BEND,
    REGION_BEND,
    REGION_NOISE,
    REGION_NOISE_EDGE,
    REGION_RATIO,
    REGION_SIZE,
    ROUND_OFF_GAP,
)

PLANAR = "planar"
SPHERICAL = "spherical"


@dataclass(frozen=True)
class RegionMap:
    """Which triangles of a surface lie in which region.

    Attributes
    ----------
    label:
        (m,) int32 number of the region of each triangle of the surface, -1 outside.
    count:
        How many there are.
    """

    label: np.ndarray
    count: int

    def rows(self) -> list[np.ndarray]:
        """For each region the rows of its triangles, ascending."""
        inside = np.flatnonzero(self.label >= 0)
        inside = inside[np.argsort(self.label[inside], kind="stable")]
        ends = np.cumsum(np.bincount(self.label[inside], minlength=self.count))
        return np.split(inside, ends[:-1]) if self.count else []


def find_regions(
    surface: Surface, gap: np.ndarray, noise: np.ndarray, radius: np.ndarray
) -> RegionMap:
    """Connected areas in which the gap does not rise above its noise.

    Parameters
    ----------
    surface:
        The surface, n vertices and m triangles.
    gap, noise:
        (n,) k1 - k2 and its standard error, in the coordinates of the surface. Vertices where
        either is not finite lie in no region.
    radius:
        (n,) root mean square distance of what the shape operator was fitted to.
    """
    ratio = _ratio(gap, noise, radius)
    bent = ~(gap * radius <= REGION_BEND)
    ratio = np.where(bent, np.inf, ratio)
    within = (ratio <= REGION_NOISE_EDGE)[surface.triangles].all(axis=1)
    if not within.any():
        return RegionMap(np.full(len(surface.triangles), -1, dtype=np.int32), 0)
    label, count = _connected(surface, within)
    _, area = surface.face_normal_area
    # A region must be larger than what one fit sees, be it here or there.
    seen = np.pi * radius**2
    least = REGION_SIZE * _mean_per_label(seen[surface.triangles].mean(axis=1), area, label, count)
    size = np.bincount(label[within], weights=area[within], minlength=count)
    core = (ratio <= REGION_NOISE)[surface.triangles].all(axis=1) & within
    core_size = np.bincount(label[core], weights=area[core], minlength=count)
    good = (size >= least) & (core_size >= 0.5 * least)
    middle = ratio[surface.triangles].max(axis=1)
    for number in np.flatnonzero(good):
        rows = np.flatnonzero(label == number)
        good[number] = _weighted_median(middle[rows], area[rows]) <= REGION_RATIO
    return _filled(surface, good[label] & within, area, least, good)


def _ratio(gap: np.ndarray, noise: np.ndarray, radius: np.ndarray) -> np.ndarray:
    """(n,) gap over its error, round-off included; infinite where it is not known."""
    tiny = np.finfo(float).tiny
    floor = ROUND_OFF_GAP * np.finfo(float).eps / np.maximum(radius, 1e-6) ** 2
    ratio = gap / np.maximum(np.maximum(noise, floor), tiny)
    return np.where(np.isfinite(ratio), ratio, np.inf)
