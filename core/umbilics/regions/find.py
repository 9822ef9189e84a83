"""Spherical and planar regions: areas where the gap of the curvatures is nothing but noise.

On a sphere, a plane or along a line of umbilics there are no isolated umbilics; the zeros that
an estimate of the shape operators has there are confetti. Each connected area is reported once,
with the sum of the indices of its triangles: the index of the direction field around its border.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...curvature.tolerances import (
    REGION_BEND,
    REGION_MEDIAN,
    REGION_RATIO,
    REGION_SIZE,
    ROUND_OFF_GAP,
)
from ...mesh.surface import Surface
from .region_map import RegionMap, connected, largest_disc, without
from .round_shapes import RoundShape, grown_labels, round_shapes


def find_regions(
    surface: Surface,
    gap: np.ndarray,
    noise: np.ndarray,
    radius: np.ndarray,
    rings: int = 0,
    mean: np.ndarray | None = None,
) -> RegionMap:
    """Connected areas in which the gap does not rise out of its noise.

    Fits within their reach of a region's border mix it with what lies beyond. Each region is
    grown by that reach: the border is about there, and umbilics in between are the mixture's.

    Parameters
    ----------
    surface:
        The surface, n vertices and m triangles.
    gap, noise:
        (n,) k1 - k2 and its standard error, in the coordinates of the surface. A vertex where
        one of them is not finite goes with those around it.
    radius:
        (n,) root mean square distance of the samples of each shape operator.
    rings:
        Rings of samples, by which the regions grow.
    mean:
        (n,) mean curvature, by which regions must have the normals of a sphere or plane; None
        not to ask.
    """
    ratio = _ratio(gap, noise, radius)
    clear, known = ratio > REGION_RATIO, np.isfinite(ratio)
    a, b, c = surface.at_corners(clear)
    within = ~(a | b | c)
    if not known.all():
        a, b, c = surface.at_corners(known)
        within &= a | b | c
    if not within.any():
        return RegionMap.none(surface)
    _, area = surface.face_normal_area
    label, count = connected(surface, within)
    size = np.bincount(label[within], weights=area[within], minlength=count)
    seen = largest_disc(surface, radius, label, count)
    good = size >= REGION_SIZE * seen
    for number, rows in enumerate(RegionMap(label, count).rows()):
        if good[number]:
            middle = _mean_known(*(ratio.take(corner) for corner in surface.triangles[rows].T))
            # Half of the area at least: what the median by area says without a sort.
            low = area[rows[middle <= REGION_MEDIAN]].sum()
            good[number] = low >= 0.5 * area[rows].sum()
    if not good.any():
        return RegionMap.none(surface)
    regions = without(RegionMap(label, count), ~good)
    shapes = None
    if mean is not None:
        regions, shapes = _only(regions, round_shapes(surface, regions.rows(), mean))
    return _without_holes(surface, _grown(surface, regions, rings, shapes), seen.max())


def _only(
    regions: RegionMap, shapes: Sequence[RoundShape | None]
) -> tuple[RegionMap, list[RoundShape]]:
    """The regions that have a shape, numbered anew, and their shapes."""
    kept = without(regions, [shape is None for shape in shapes])
    return kept, [shape for shape in shapes if shape is not None]


def _ratio(gap: np.ndarray, noise: np.ndarray, radius: np.ndarray) -> np.ndarray:
    """(n,) gap over its standard error; NaN where unknown, infinite where the surface bends."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        round_off = ROUND_OFF_GAP * np.finfo(float).eps / np.square(radius)
        ratio = gap / np.maximum(noise, round_off)
        ratio[gap * radius > REGION_BEND] = np.inf
    return np.where(np.isnan(ratio), np.nan, ratio)


def _mean_known(*values: np.ndarray) -> np.ndarray:
    """(k,) the means of those of some numbers (k,) that are known, one at least of each."""
    known = [np.isfinite(some) for some in values]
    total = sum(np.where(there, some, 0.0) for there, some in zip(known, values, strict=True))
    return np.asarray(total / np.sum(known, axis=0))


def _grown(
    surface: Surface, regions: RegionMap, rings: int, shapes: Sequence[RoundShape] | None
) -> RegionMap:
    label = grown_labels(surface, regions.label, rings, shapes)
    return RegionMap(label, regions.count)


def _without_holes(surface: Surface, regions: RegionMap, least: float) -> RegionMap:
    """Close the gaps that lie within one region and are smaller than a region may be."""
    outside, holes = connected(surface, regions.label < 0)
    rows = np.flatnonzero(outside >= 0)
    _, area = surface.face_normal_area
    size = np.bincount(outside[rows], weights=area[rows], minlength=holes)
    twin = surface.twin.reshape(-1, 3)[rows]
    beside = np.where(twin >= 0, regions.label[twin // 3], -1)
    lowest = np.full(holes, regions.count)
    highest = np.full(holes, -1)
    hole = np.repeat(outside[rows], 3).reshape(-1, 3)[beside >= 0]
    np.minimum.at(lowest, hole, beside[beside >= 0])
    np.maximum.at(highest, hole, beside[beside >= 0])
    fill = (size < REGION_SIZE * least) & (lowest == highest)
    label = regions.label.copy()
    filled = rows[fill[outside[rows]]]
    label[filled] = highest[outside[filled]]
    return RegionMap(label, regions.count)
