"""Spherical and planar regions: areas where the gap of the curvatures is nothing but noise.

On a sphere, a plane or along a line of umbilics there are no isolated umbilics; the zeros that
an estimate of the shape operators has there are confetti. Each connected area is reported once,
with the sum of the indices of its triangles: the index of the direction field around its border.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from ..curvature.tolerances import (
    PLANAR_BEND,
    PLANAR_ERRORS,
    REGION_BEND,
    REGION_MEDIAN,
    REGION_RATIO,
    REGION_SIZE,
    ROUND_OFF_GAP,
)
from ..mesh.exact_shapes import PLANAR, SPHERICAL
from ..mesh.surface import Surface
from ..mesh.tessellated import Tessellation
from .region_shapes import RoundShape, grown_labels, round_shapes
from .result import CURVE, Region
from .unresolved import UnresolvedSets


@dataclass(frozen=True)
class RegionMap:
    """Which triangles of a surface lie in which region.

    Attributes
    ----------
    label:
        (m,) int32 number of the region of each triangle of the surface, -1 outside.
    count:
        How many there are.
    faces:
        The exact faces that the first of them are; None without.
    curves:
        How many of the last of them are curves of umbilics.
    """

    label: np.ndarray
    count: int
    faces: Tessellation | None = None
    curves: int = 0

    @classmethod
    def none(cls, surface: Surface) -> RegionMap:
        """No region at all."""
        return cls(np.full(len(surface.triangles), -1, dtype=np.int32), 0)

    def rows(self) -> list[np.ndarray]:
        """For each region the rows of its triangles, ascending."""
        inside = np.flatnonzero(self.label >= 0)
        inside = inside[np.argsort(self.label[inside], kind="stable")]
        ends = np.cumsum(np.bincount(self.label[inside], minlength=self.count))
        return np.split(inside, ends[:-1]) if self.count else []


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
    a, b, c = surface.triangles.T
    within = ~(clear[a] | clear[b] | clear[c]) & (known[a] | known[b] | known[c])
    if not within.any():
        return RegionMap.none(surface)
    _, area = surface.face_normal_area
    label, count = connected(surface, within)
    size = np.bincount(label[within], weights=area[within], minlength=count)
    seen = largest_disc(surface, radius, label, count)
    good = size >= REGION_SIZE * seen
    for number, rows in enumerate(RegionMap(label, count).rows()):
        if good[number]:
            good[number] = (
                _weighted_median(np.nanmean(ratio[surface.triangles[rows]], axis=1), area[rows])
                <= REGION_MEDIAN
            )
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


def without(regions: RegionMap, dropped: Sequence[bool] | np.ndarray) -> RegionMap:
    """The regions but for those that are `dropped`, numbered anew."""
    good = ~np.asarray(dropped, bool)
    renumbered = np.append(np.where(good, np.cumsum(good) - 1, -1), -1).astype(np.int32)
    return RegionMap(renumbered[regions.label], int(good.sum()))


def with_faces(faces: Tessellation, found: RegionMap) -> RegionMap:
    """The exact faces of a tessellated part as regions, and what is left of those `found`
    beside them."""
    outside = np.where(faces.face < 0, found.label, -1)
    kept, label = np.unique(outside[outside >= 0], return_inverse=True)
    labels = faces.face.copy()
    labels[outside >= 0] = len(faces.kinds) + label
    return RegionMap(labels, len(faces.kinds) + len(kept), faces)


def with_curves(
    surface: Surface, regions: RegionMap, sets: UnresolvedSets, triangle_index: np.ndarray
) -> RegionMap:
    """The regions, and beside them the curves of umbilics: unresolved sets that are long and
    narrow, and around which the directions do not turn.

    Where they do, there is an umbilic, whatever the shape of the set. A set that touches a region
    is the rim of that one, where its own fits and others meet.

    Parameters
    ----------
    triangle_index:
        (m,) index in each triangle of the surface.
    """
    label = sets.label
    inside = np.flatnonzero(label >= 0)
    count = len(sets.length)
    index = np.bincount(label[inside], weights=triangle_index[inside], minlength=count)
    held = np.zeros(len(surface.vertices), bool)
    held[surface.triangles[regions.label >= 0]] = True
    beside = np.zeros(count, bool)
    beside[label[inside[held[surface.triangles[inside]].any(axis=1)]]] = True
    curve = sets.curves & (index == 0.0) & ~beside
    if not curve.any():
        return regions
    number = np.append(np.where(curve, regions.count + np.cumsum(curve) - 1, -1), -1)
    labels = np.where(number[label] >= 0, number[label], regions.label).astype(np.int32)
    curves = int(curve.sum())
    return RegionMap(labels, regions.count + curves, regions.faces, curves)


def describe_regions(
    surface: Surface,
    regions: RegionMap,
    mean_curvature: np.ndarray,
    noise: np.ndarray,
    radius: np.ndarray,
    triangle_index: np.ndarray,
) -> list[Region]:
    """The regions as they are reported, in the rows and units of the input mesh.

    Parameters
    ----------
    mean_curvature, noise, radius:
        (n,) (k1 + k2) / 2, standard error of k1 - k2 and radius of the fit, in the coordinates
        of the surface.
    triangle_index:
        (m,) index in each triangle of the surface.
    """
    _, area = surface.face_normal_area
    found = []
    for number, rows in enumerate(regions.rows()):
        if regions.faces is not None and number < len(regions.faces.kinds):
            found.append(
                Region(
                    triangles=_of_input(surface, rows),
                    area=float(area[rows].sum()) * surface.unit * surface.unit,
                    index=float(triangle_index[rows].sum()),
                    kind=regions.faces.kinds[number],
                    curvature=float(regions.faces.mean_curvature[number]) / surface.unit,
                )
            )
            continue
        weight = area[rows]
        total = float(weight.sum())
        corners = surface.triangles[rows]
        # The median leaves out the margin, where fits reach beyond the region.
        known = np.isfinite(mean_curvature[corners]).all(axis=1)
        curvature = _weighted_median(mean_curvature[corners[known]].mean(axis=1), weight[known])
        # The errors of fits that share samples are not independent.
        independent = total / (np.pi * max(_mean(radius[corners], weight) ** 2, 1e-300))
        error = 0.5 * _mean(noise[corners], weight) / np.sqrt(max(independent, 1.0))
        extent = np.sqrt(max(total, np.finfo(float).tiny) / np.pi)
        flat = max(PLANAR_BEND / extent, PLANAR_ERRORS * error)
        kind = PLANAR if abs(curvature) <= flat else SPHERICAL
        if number >= regions.count - regions.curves:
            kind = CURVE
        found.append(
            Region(
                triangles=_of_input(surface, rows),
                area=total * surface.unit * surface.unit,
                index=float(triangle_index[rows].sum()),
                kind=kind,
                curvature=curvature / surface.unit,
            )
        )
    return found


def _of_input(surface: Surface, rows: np.ndarray) -> np.ndarray:
    """Input triangles of the surface's (r,), ascending and each once."""
    given = surface.source_triangle[rows]
    return np.unique(given) if len(surface.recut) else given


def _ratio(gap: np.ndarray, noise: np.ndarray, radius: np.ndarray) -> np.ndarray:
    """(n,) gap over its standard error; NaN where unknown, infinite where the surface bends."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        round_off = ROUND_OFF_GAP * np.finfo(float).eps / np.square(radius)
        ratio = gap / np.maximum(noise, round_off)
        ratio[gap * radius > REGION_BEND] = np.inf
    return np.where(np.isnan(ratio), np.nan, ratio)


def connected(surface: Surface, within: np.ndarray) -> tuple[np.ndarray, int]:
    """Number the edge-connected sets of the chosen triangles; (m,) int32, -1 elsewhere."""
    place = np.cumsum(within, dtype=np.int32) - 1
    chosen = np.flatnonzero(within)
    twin = surface.twin.reshape(-1, 3)[chosen]
    other = twin // 3
    joined = (twin >= 0) & within[other] & (other < chosen[:, None])
    first = np.repeat(np.arange(len(chosen), dtype=np.int32), joined.sum(axis=1))
    second = place[other[joined]]
    graph = sparse.coo_array(
        (np.ones(len(first), dtype=np.int8), (first, second)), shape=(len(chosen), len(chosen))
    )
    count, piece = csgraph.connected_components(graph, directed=False)
    label = np.full(len(within), -1, dtype=np.int32)
    label[chosen] = piece
    return label, int(count)


def largest_disc(
    surface: Surface, radius: np.ndarray, label: np.ndarray, count: int
) -> np.ndarray:
    """(count,) area of the disc that one fit sees, on average over each labelled set."""
    inside = np.flatnonzero(label >= 0)
    corners = radius[surface.triangles[inside]]
    known = np.isfinite(corners)
    square = np.where(known, corners, 0.0) ** 2
    total = np.bincount(label[inside], weights=square.sum(axis=1), minlength=count)
    number = np.bincount(label[inside], weights=known.sum(axis=1), minlength=count)
    return np.pi * total / np.maximum(number, 1)


def _grown(
    surface: Surface, regions: RegionMap, rings: int, shapes: Sequence[RoundShape] | None
) -> RegionMap:
    label = grown_labels(surface, regions.label, rings, shapes)
    return RegionMap(label, regions.count)


def _weighted_median(values: np.ndarray, weights: np.ndarray) -> float:
    if len(values) == 0:
        return 0.0
    order = np.argsort(values)
    share = np.cumsum(weights[order])
    return float(values[order[np.searchsorted(share, 0.5 * share[-1])]])


def _mean(corners: np.ndarray, weights: np.ndarray) -> float:
    """Mean over triangles of what is known at their corners (r, 3), by area."""
    known = np.isfinite(corners)
    weights = np.broadcast_to(weights[:, None], corners.shape)[known]
    total = float(weights.sum())
    if total > 0.0:
        return float((corners[known] * weights).sum() / total)
    return float(corners[known].mean()) if known.any() else 0.0


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
