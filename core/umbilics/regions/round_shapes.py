"""Whether a region has the shape that it is called by, and how far that shape goes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ...base.median import weighted_median
from ...base.unit import angles_between, unit
from ...mesh.surface import Surface

# Angle in radians between the normals of a region and of the sphere or plane through it, in the
# middle by area, from which on it is none. Noise of a tenth of the edges makes 0.15 (spheres),
# the sides of a closed box against the plane of two of them 1.6. Triangles that are turned
# further are not taken in where a region grows, unless so many times its own median is more.
OFF_SHAPE, MARGIN = 0.35, 3.0
# Median ratio of the gap to its error, by fits over twice the rings, from which on a region is
# none. On noisy spheres, half balls and flat caps it is 1.6 at most, at the tips of ellipsoids, of
# which narrow fits make spheres at 10 % of noise, 5.9 at least.
STANDS_OUT = 4.0
# Median distance of a region's points from the sphere or plane through them, over the standard
# deviation of points about fits, from which on it is none. It is 0.67 for independent noise, at
# most 0.84 in spheres, caps of capsules and planes, noisy, out of marching cubes or decimated;
# 1.59 for a cylinder that was rounded off by subdivision, whose noise hides how round it is.
STANDS_OFF = 1.2
# Distances that round-off makes, for coordinates of order 1.
ROUND_OFF = 1e-12
# Vertices of each region at which both are asked.
ASKED = 30


@dataclass(frozen=True)
class RoundShape:
    """A sphere or plane.

    Attributes
    ----------
    centre, radius:
        Of the sphere, negative with normals inwards; infinite for a plane, whose normal is
        then `centre`.
    spread:
        Median angle, in radians, between the normals of the region and those of the shape.
    """

    centre: np.ndarray
    radius: float
    spread: float

    def off(self, points: np.ndarray, normals: np.ndarray) -> np.ndarray:
        """(t,) angle between unit normals (t, 3) at points (t, 3) and those of the shape."""
        if np.isinf(self.radius):
            wanted = np.broadcast_to(self.centre, normals.shape)
        else:
            wanted = unit((points - self.centre) * np.sign(self.radius))
        return angles_between(wanted, normals)


def round_shapes(
    surface: Surface, regions: Sequence[np.ndarray], mean: np.ndarray
) -> list[RoundShape | None]:
    """The sphere or plane of each region (its rows of triangles), None where it has neither.

    Parameters
    ----------
    mean:
        (n,) mean curvature at the vertices, in the coordinates of the surface.
    """
    return [_round_shape(surface, rows, mean) for rows in regions]


def _round_shape(surface: Surface, rows: np.ndarray, mean: np.ndarray) -> RoundShape | None:
    normal, area = surface.face_normal_area
    weight, corners = area[rows], surface.triangles[rows]
    points, normals = surface.vertices[corners].mean(axis=1), normal[rows]
    bend = mean[corners].mean(axis=1)
    known = np.isfinite(bend) & (weight > 0)
    if not known.any():
        return None
    points, normals, weight, bend = points[known], normals[known], weight[known], bend[known]
    best = None
    for curvature in (0.0, weighted_median(bend, weight)):
        if curvature == 0.0:
            centre = weight @ normals
            length = float(np.linalg.norm(centre))
            if length == 0.0:
                continue
            shape = RoundShape(centre / length, np.inf, 0.0)
        else:
            middle = weight @ (points - normals / curvature) / weight.sum()
            shape = RoundShape(middle, 1.0 / curvature, 0.0)
        spread = weighted_median(shape.off(points, normals), weight)
        if best is None or spread < best.spread:
            best = RoundShape(shape.centre, shape.radius, spread)
    return best if best is not None and best.spread <= OFF_SHAPE else None


def grown_labels(
    surface: Surface, label: np.ndarray, rings: int, shapes: Sequence[RoundShape] | None
) -> np.ndarray:
    """(m,) labels of triangles after all regions have grown at once by so many rings; where two
    meet, both stop.

    Parameters
    ----------
    label:
        (m,) int32 region of each triangle, -1 for none.
    shapes:
        The shape of each region, that triangles must have to be taken in; None to take all.
    """
    label = label.copy()
    held = np.full(len(surface.vertices), -1, np.int32)
    inside = np.flatnonzero(label >= 0)
    for corner in surface.triangles[inside].T:
        np.maximum.at(held, corner, label[inside])
    normal, _ = surface.face_normal_area
    for _ in range(rings):
        corners = held[surface.triangles]
        largest = corners.max(axis=1)
        touching = np.flatnonzero((label < 0) & (largest >= 0))
        own = largest[touching]
        # No triangle between two regions.
        alone = ((corners[touching] < 0) | (corners[touching] == own[:, None])).all(axis=1)
        touching, own = touching[alone], own[alone]
        if shapes is not None:
            points = surface.vertices[surface.triangles[touching]].mean(axis=1)
            fits = np.zeros(len(touching), bool)
            for number in np.unique(own):
                mine, shape = own == number, shapes[number]
                off = shape.off(points[mine], normal[touching[mine]])
                fits[mine] = off <= max(MARGIN * shape.spread, OFF_SHAPE)
            touching, own = touching[fits], own[fits]
        if not len(touching):
            break
        label[touching] = own
        for corner in surface.triangles[touching].T:
            free = held[corner] < 0
            held[corner[free]] = own[free]
    return label


def deepest(surface: Surface, inside: np.ndarray, rings: int) -> np.ndarray:
    """Vertices of the triangles `inside` (m,) that lie so many rings from all others or, where no
    vertex does, as many as some do; none where all touch others."""
    held = np.ones(len(surface.vertices), bool)
    held[surface.triangles[~inside]] = False
    for _ in range(rings):
        if held.all():
            break
        deeper = held.copy()
        deeper[surface.triangles[surface.touching(~held)]] = False
        if not deeper.any():
            break
        held = deeper
    return np.flatnonzero(held)


def resolved_by_wider_fits(
    surface: Surface,
    regions: Sequence[np.ndarray],
    rings: int,
    ratio: Callable[[np.ndarray], np.ndarray],
) -> list[bool]:
    """Whether a gap stands out of its error in the middle of each region (its rows of triangles)
    by fits over so many rings: what is nothing but noise is so at that scale too.

    Parameters
    ----------
    ratio:
        Gives the gap over its error at vertices (v,) by such fits, NaN where they tell nothing.
    """
    found = []
    for rows in regions:
        inside = np.zeros(len(surface.triangles), bool)
        inside[rows] = True
        middle = deepest(surface, inside, rings)
        values = ratio(middle[:: max(len(middle) // ASKED, 1)])
        known = values[np.isfinite(values)]
        found.append(bool(len(known) and np.median(known) > STANDS_OUT))
    return found


def standing_off(
    surface: Surface, regions: Sequence[np.ndarray], rings: int, scatter: np.ndarray
) -> list[bool]:
    """Whether the points in the middle of each region (its rows of triangles) stand further off
    the sphere and the plane through them than noise lets them: what hides in the noise of the
    curvatures need not hide in that of the points.

    Parameters
    ----------
    surface:
        The surface, n vertices.
    regions, rings:
        Rows of triangles, and how far from others the middle is, as in `deepest`.
    scatter:
        (n,) standard deviation of points about fits, in length; NaN where unknown.
    """
    found = []
    for rows in regions:
        inside = np.zeros(len(surface.triangles), bool)
        inside[rows] = True
        middle = deepest(surface, inside, rings)
        least = np.median(scatter[middle]) if len(middle) else np.nan
        off = min(_off_sphere(surface.vertices[middle]), _off_plane(surface.vertices[middle]))
        # Of few points little is known, and round-off is no shape.
        known = len(middle) >= ASKED and off > ROUND_OFF
        found.append(bool(known and off > STANDS_OFF * least))
    return found


def _off_sphere(points: np.ndarray) -> float:
    """Median distance of points (r, 3) from the sphere fitted to them (linear in the squares)."""
    if len(points) < 4:
        return 0.0
    offset = points - points.mean(axis=0)
    rows = np.column_stack([2.0 * offset, np.ones(len(offset))])
    solution = np.linalg.lstsq(rows, np.square(offset).sum(axis=1), rcond=None)[0]
    centre = solution[:3]
    radius = np.sqrt(max(solution[3] + centre @ centre, 0.0))
    return float(np.median(np.abs(np.linalg.norm(offset - centre, axis=1) - radius)))


def _off_plane(points: np.ndarray) -> float:
    """Median distance of points (r, 3) from the plane fitted to them."""
    if len(points) < 3:
        return 0.0
    offset = points - points.mean(axis=0)
    normal = np.linalg.eigh(offset.T @ offset)[1][:, 0]
    return float(np.median(np.abs(offset @ normal)))
