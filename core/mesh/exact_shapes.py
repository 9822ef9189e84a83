"""Planes, cylinders, cones and spheres that are exact: told by the facets of a part.

The facets' normals tell the kind, their vertices and middles how far it goes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from ..base.unit import angles_between, unit
from .surface import Surface

PLANAR, CYLINDRICAL, CONICAL, SPHERICAL = "planar", "cylindrical", "conical", "spherical"

# Angle in radians that facets of one plane may differ by, beside what single precision leaves.
FLAT = 5e-4
# Distance of vertices from a cylinder or sphere, in its radius, and spread in radians of the angle
# between normals and an axis, beside what single precision leaves: vertices may lie on the chord
# of a facet (of 10 degrees 0.4 % of the radius inside), and programs write three or four digits.
ON_SHAPE, ON_AXIS = 1e-2, 1e-2
# Vertices that fix a shape: a cone has six unknowns.
FEWEST = 6
# Facets that the slope of a cone is read off, all around it: of fewer each is a face of its own.
# Its vertices lie on one that is steeper, by one over the cosine of half the turn between facets.
ROUND = 8
# Angle between the normals of facets and of the sphere at their middles, for 16 segments around.
# Larger facets would fit the sphere through the rims of a cylinder.
ON_SPHERE = 0.35


# Numbers of the kinds in arrays; none is exact.
KINDS = (PLANAR, CYLINDRICAL, CONICAL, SPHERICAL)
NONE = -1
# Share of the squared spread of points along all directions below which that along one is
# round-off: the sums hold about 1e-16 of it.
UNSPREAD = 1e-13
# Triangles whose faces are looked at together.
BLOCK = 1 << 18


@dataclass(frozen=True)
class ExactShapes:
    """What f faces are part of.

    Attributes
    ----------
    kind:
        (f,) int8 the number of "planar", "cylindrical", "conical" or "spherical" in `KINDS`; `NONE`
        for what is none of these.
    mean_curvature:
        (f,) float64 of each face, in the coordinates of the surface; of a cone at the median
        distance of its vertices from the axis.
    axis:
        (f, 3) float64 unit axis of each cylinder or cone, zero for the others.
    """

    kind: np.ndarray
    mean_curvature: np.ndarray
    axis: np.ndarray


def shapes_of(
    surface: Surface, rows: np.ndarray, starts: np.ndarray, rounding: np.ndarray
) -> ExactShapes:
    """The shapes that triangles make up faces of, if they do.

    Parameters
    ----------
    rows:
        (t,) triangles, face after face.
    starts:
        (f + 1,) where each face begins in them, and the end; none is empty.
    rounding:
        (m,) as from `normal_rounding`.
    """
    f = len(starts) - 1
    shapes = ExactShapes(np.full(f, NONE, np.int8), np.zeros(f), np.zeros((f, 3)))
    begin = 0
    while begin < f:
        end = int(np.searchsorted(starts, starts[begin] + BLOCK, side="right")) - 1
        end = max(end, begin + 1)
        some = rows[starts[begin] : starts[end]]
        part = slice(begin, end)
        count = np.diff(starts[begin : end + 1])
        _tell(
            surface,
            some,
            count,
            rounding[some],
            ExactShapes(shapes.kind[part], shapes.mean_curvature[part], shapes.axis[part]),
        )
        begin = end
    return shapes


class _Groups:
    """Values of groups one after the other, `count` (g,) of each, at least one."""

    def __init__(self, count: np.ndarray) -> None:
        self.count = count
        self.start = np.cumsum(count) - count
        self.of = np.repeat(np.arange(len(count)), count)

    def sums(self, values: np.ndarray) -> np.ndarray:
        """(..., g) sums of values (..., t)."""
        return np.asarray(np.add.reduceat(values, self.start, axis=-1))

    def largest(self, values: np.ndarray) -> np.ndarray:
        """(..., g) maxima of values (..., t)."""
        return np.asarray(np.maximum.reduceat(values, self.start, axis=-1))

    def medians(self, values: np.ndarray) -> np.ndarray:
        """(g,) medians of values (t,)."""
        low, high = values.min(), values.max()
        # One key for group and value: several times faster to order than two.
        size = max(float(high - low), float(np.finfo(float).tiny))
        half = self.start + self.count // 2
        other = self.start + (self.count - 1) // 2
        key = self.of + (values - low) / (1.001 * size)
        ordered = values[np.argpartition(key, np.union1d(half, other))]
        return np.asarray(0.5 * (ordered[half] + ordered[other]))

    def only(self, wanted: np.ndarray) -> tuple[np.ndarray, _Groups]:
        """Which values are of the groups `wanted` (g,) bool, (t,) bool, and these groups."""
        return np.repeat(wanted, self.count), _Groups(self.count[wanted])


@dataclass(frozen=True)
class _Facets:
    """Facets of g faces, and the vertices of these.

    Attributes
    ----------
    face, vertex:
        How facets (t,) and vertices (p,) are grouped, face after face.
    normals, middles, points:
        (3, t), (3, t) and (3, p) of facets and vertices.
    weight, rounding:
        (t,) areas of the facets, and as from `normal_rounding`.
    """

    face: _Groups
    vertex: _Groups
    normals: np.ndarray
    middles: np.ndarray
    points: np.ndarray
    weight: np.ndarray
    rounding: np.ndarray

    def only(self, wanted: np.ndarray) -> _Facets:
        """Those of the faces `wanted` (g,) bool."""
        if wanted.all():
            return self
        facets, face = self.face.only(wanted)
        points, vertex = self.vertex.only(wanted)
        return _Facets(
            face,
            vertex,
            self.normals[:, facets],
            self.middles[:, facets],
            self.points[:, points],
            self.weight[facets],
            self.rounding[facets],
        )


def _tell(
    surface: Surface,
    rows: np.ndarray,
    count: np.ndarray,
    rounding: np.ndarray,
    shapes: ExactShapes,
) -> None:
    """Write to `shapes` what faces of triangles `rows` (t,) are, `count` (f,) of each."""
    normal, area = surface.face_normal_area
    weight = area[rows]
    # Triangles without an area say nothing of a face, unless there are no others.
    known = weight > 0
    count = np.add.reduceat(known, np.cumsum(count) - count, dtype=count.dtype)
    shapes.kind[count == 0] = KINDS.index(PLANAR)
    face = np.flatnonzero(count)
    if not len(face):
        return
    rows, weight, rounding = rows[known], weight[known], rounding[known]
    groups = _Groups(count[face])
    normals = np.ascontiguousarray(normal[rows].T)
    mean = groups.sums(weight * normals)
    length = np.linalg.norm(mean, axis=0)
    # Normals that all are near to one another hardly shorten their mean.
    flat = length > 0.5 * groups.sums(weight)
    mean /= np.maximum(length, np.finfo(float).tiny)
    apart = angles_between(normals.T, mean[:, groups.of].T) - 2.0 * rounding
    flat &= groups.largest(apart) <= 2.0 * FLAT
    shapes.kind[face[flat]] = KINDS.index(PLANAR)
    if flat.all():
        return
    inside, groups = groups.only(~flat)
    face, rows = face[~flat], rows[inside]
    coordinates, corners = surface.coordinates, surface.triangles[rows]
    vertices, vertex = _vertices_of(corners, groups, coordinates.shape[1])
    facets = _Facets(
        groups,
        vertex,
        normals[:, inside],
        sum(coordinates.take(corner, axis=1) for corner in corners.T) / 3.0,
        coordinates[:, vertices],
        weight[inside],
        rounding[inside],
    )
    fixed = vertex.count >= FEWEST
    # The rims of a cylinder lie on a sphere too, but the normals of a sphere on no circle.
    for find in (_of_revolution, _spheres):
        if not fixed.any():
            break
        found = find(facets.only(fixed))
        told = face[fixed]
        shapes.kind[told], shapes.mean_curvature[told] = found.kind, found.mean_curvature
        shapes.axis[told] = found.axis
        fixed[fixed] = found.kind == NONE


def _vertices_of(corners: np.ndarray, groups: _Groups, n: int) -> tuple[np.ndarray, _Groups]:
    """(p,) the vertices, out of n, of triangles (t, 3) in groups, each once in a group."""
    starts = np.append(3 * groups.start, corners.size)
    ones = np.ones(corners.size, bool)
    # By counting, there and back, which takes a fifth of the time of a sort.
    of = sparse.csr_array((ones, corners.ravel(), starts), shape=(len(groups.count), n))
    of = of.tocsc().tocsr()
    of.sum_duplicates()
    return of.indices, _Groups(np.diff(of.indptr))


def _nothing(count: int) -> ExactShapes:
    return ExactShapes(np.full(count, NONE, np.int8), np.zeros(count), np.zeros((count, 3)))


def _spheres(facets: _Facets) -> ExactShapes:
    """The spheres that the vertices lie on and fix, if any."""
    face, vertex = facets.face, facets.vertex
    shapes = _nothing(len(face.count))
    middle = vertex.sums(facets.points) / vertex.count
    local = facets.points - middle[:, vertex.of]
    size = np.maximum(vertex.largest(np.abs(local)).max(axis=0), np.finfo(float).tiny)
    local /= size[vertex.of]
    square = np.einsum("cp,cp->p", local, local)
    # |p|^2 - 2 p.c = r^2 - |c|^2, linear in c; what it leaves on average is r^2 - |c|^2.
    centre, spread = _solved(vertex, 2.0 * local, square)
    level = vertex.sums(square) / vertex.count
    radius = np.sqrt(np.maximum(level + np.square(centre).sum(axis=0), 0.0))
    singular = np.sqrt(np.maximum(np.column_stack([spread, vertex.count]), 0.0))
    fixed = singular.min(axis=1) >= 1e-3 * singular.max(axis=1)
    away = np.abs(np.linalg.norm(local - centre[:, vertex.of], axis=0) - radius[vertex.of])
    fixed &= vertex.largest(away) <= ON_SHAPE * radius
    place = middle + size * centre
    out = unit((facets.middles - place[:, face.of]).T)
    cosine = np.einsum("tc,ct->t", out, facets.normals)
    outward = np.sign(face.sums(facets.weight * cosine))
    fixed &= face.largest(-outward[face.of] * cosine) <= -np.cos(ON_SPHERE)
    shapes.kind[fixed] = KINDS.index(SPHERICAL)
    shapes.mean_curvature[fixed] = (outward / (size * radius))[fixed]
    return shapes


def _of_revolution(facets: _Facets) -> ExactShapes:
    """The circular cylinders and cones, if any: normals at one angle to the axis, vertices in
    circles around it."""
    face = facets.face
    shapes = _nothing(len(face.count))
    axes = _axes(face, facets.normals, facets.weight)
    along = np.einsum("ct,ct->t", facets.normals, axes[0][:, face.of])
    slope = face.medians(along)
    allowed = ON_AXIS + 2.0 * face.largest(facets.rounding)
    left = face.largest(np.abs(along - slope[face.of])) <= allowed
    # Circles about one axis whose radius changes evenly: |p - c| = r + k h, and the slope of the
    # normals says k.
    straight = np.abs(slope) < ON_AXIS
    change = -slope / np.sqrt(np.maximum(1.0 - slope**2, 1e-12))
    change[straight] = 0.0
    for sign in (1.0, -1.0):
        if not left.any():
            break
        some = facets.only(left)
        bend = _bends(some, axes[:, :, left], sign * change[left])
        found = np.flatnonzero(left)[np.isfinite(bend)]
        kinds = np.where(straight[found], KINDS.index(CYLINDRICAL), KINDS.index(CONICAL))
        shapes.kind[found], shapes.axis[found] = kinds, axes[0][:, found].T
        inclined = np.sqrt(np.maximum(1.0 - slope[found] ** 2, 0.0))
        shapes.mean_curvature[found] = 0.5 * inclined * bend[np.isfinite(bend)]
        left[found] = False
        left &= ~straight
    return shapes


def _bends(facets: _Facets, axes: np.ndarray, change: np.ndarray) -> np.ndarray:
    """(g,) one over the median distance of the vertices from the axes of the surfaces of revolution
    that they lie on, negative where these are hollow; NaN where they lie on none.

    Parameters
    ----------
    axes:
        (3, 3, g) an axis of each, and two unit vectors square to it.
    change:
        (g,) how fast the radius grows along the axis.
    """
    face, vertex = facets.face, facets.vertex
    sides = axes[1:]
    local = np.einsum("kcp,cp->kp", axes[:, :, vertex.of], facets.points)
    middle = vertex.sums(local) / vertex.count
    local -= middle[:, vertex.of]
    scale = np.maximum(vertex.largest(np.abs(local[1:])).max(axis=0), np.finfo(float).tiny)
    local /= scale[vertex.of]
    up, plane = local[0], local[1:]
    circles = _circles(vertex, plane, up, change)
    # Facets lie inside the cone that their vertices lie on.
    spread = np.maximum(vertex.sums(up * up), np.finfo(float).tiny)
    steep = vertex.sums(circles.far * up) / spread
    steeper = np.abs(steep) * np.cos(np.pi / ROUND) <= np.abs(change)
    steeper &= (steep * change > 0.0) & (np.abs(steep) > np.abs(change))
    if steeper.any():
        circles = _circles(vertex, plane, up, np.where(steeper, steep, change))
    centre, far = circles.centre, circles.far
    fits = circles.fixed
    fits &= vertex.largest(circles.off) <= ON_SHAPE * vertex.largest(far)
    place = middle[1:] + scale * centre
    across, facing = (
        np.einsum("kct,ct->kt", sides[:, :, face.of], vectors)
        for vectors in (facets.middles, facets.normals)
    )
    across -= place[:, face.of]
    outward = np.sign(face.sums(facets.weight * np.einsum("kt,kt->t", across, facing)))
    typical = np.maximum(vertex.medians(far) * scale, np.finfo(float).tiny)
    return np.where(fits, outward / typical, np.nan)


@dataclass(frozen=True)
class _Circles:
    """Circles about one axis for each of g groups of p points, whose radius changes evenly along
    it.

    Attributes
    ----------
    centre, fixed:
        (2, g) of each, and (g,) bool whether the points fix it.
    far, off:
        (p,) distances from the axis, and from the circles.
    """

    centre: np.ndarray
    fixed: np.ndarray
    far: np.ndarray
    off: np.ndarray


def _circles(vertex: _Groups, plane: np.ndarray, up: np.ndarray, change: np.ndarray) -> _Circles:
    """The circles through points at `plane` (2, p) and `up` (p,) along the axis, of groups about
    zero, whose radii grow by `change` (g,) along it."""
    growth = change[vertex.of] * up
    # |p|^2 - 2 p.c + |c|^2 = r^2 + 2 r k h + k^2 h^2, linear in c, r and r^2 - |c|^2.
    unknown = np.stack([*(2.0 * plane), 2.0 * growth])
    wanted = np.einsum("cp,cp->p", plane, plane) - growth**2
    solution, spread = _solved(vertex, unknown, wanted)
    centre = solution[:2]
    least = np.where(change == 0.0, spread[:, 1], spread[:, 0])
    level = vertex.sums(wanted) / vertex.count
    radius = np.sqrt(np.maximum(level + np.square(centre).sum(axis=0), 0.0))
    far = np.hypot(*(plane - centre[:, vertex.of]))
    off = np.abs(far - np.abs(radius[vertex.of] + growth))
    return _Circles(centre, least > UNSPREAD * spread[:, 2], far, off)


def _solved(
    groups: _Groups, unknown: np.ndarray, wanted: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Least squares in each group with a constant beside the columns `unknown` (3, p), whose mean
    is zero: their (3, g) coefficients, zero along what the points do not tell, and (g, 3) ascending
    squares of the singular values."""
    pairs = np.einsum("ip,jp->ijp", unknown, unknown)
    spread, axes = np.linalg.eigh(np.moveaxis(groups.sums(pairs), 2, 0))
    right = groups.sums(unknown * wanted)
    known = spread > UNSPREAD * spread[:, 2:]
    inverse = np.divide(1.0, spread, out=np.zeros_like(spread), where=known)
    solution = np.einsum("gik,gk,gjk,jg->ig", axes, inverse, axes, right)
    return np.asarray(solution), np.asarray(spread)


def _axes(groups: _Groups, normals: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """(3, 3, g) the axes about which normals (3, t) of areas `weight` (t,) lie on circles, and two
    unit vectors square to each."""
    total = groups.sums(weight)
    centred = normals - (groups.sums(weight * normals) / total)[:, groups.of]
    pairs = np.einsum("t,ct,dt->cdt", weight, centred, centred)
    spread, vectors = np.linalg.eigh(np.moveaxis(groups.sums(pairs) / total, 2, 0))
    axes = np.ascontiguousarray(vectors.transpose(2, 1, 0))
    for face in np.flatnonzero(spread[:, 1] < 1e-4 * spread[:, 2]):
        # Two facets only: of all the circles through their normals that of a cylinder.
        own = slice(groups.start[face], groups.start[face] + groups.count[face])
        v = axes[2, :, face]
        far = np.argmax(np.abs(v @ centred[:, own]))
        axes[0, :, face] = unit(np.cross(normals[:, own][:, far], v))
        axes[1, :, face] = np.cross(v, axes[0, :, face])
    return axes


def normal_rounding(surface: Surface, triangles: np.ndarray | None = None) -> np.ndarray:
    """(t,) angle that single precision leaves in the normals of some triangles, or of all, by their
    heights."""
    rows = slice(None) if triangles is None else triangles
    _, area = surface.face_normal_area
    longest = np.sqrt(surface.side_squares[:, rows].max(axis=0))
    height = 2.0 * area[rows] / np.maximum(longest, np.finfo(float).tiny)
    step = np.finfo(np.float32).eps * (1.0 + np.abs(surface.origin).max() / surface.unit)
    return np.asarray(2.0 * step / np.maximum(height, 10.0 * step))
