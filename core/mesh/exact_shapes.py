"""Planes, cylinders, cones and spheres that are exact: told by the facets of a part.

The facets' normals tell the kind, their vertices and middles how far it goes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

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
# Angle between the normals of facets and of the sphere at their middles, for 16 segments around.
# Larger facets would fit the sphere through the rims of a cylinder.
ON_SPHERE = 0.35


@dataclass(frozen=True)
class ExactShape:
    """What an exact face is part of.

    Attributes
    ----------
    kind:
        "planar", "cylindrical", "conical" or "spherical".
    mean_curvature:
        Of the face, in the coordinates of the surface; of a cone
        at the median distance of its vertices from the axis.
    axis:
        (3,) float64 unit axis of a cylinder or cone, zero for the others.
    """

    kind: str
    mean_curvature: float
    axis: np.ndarray


def shape_of(surface: Surface, rows: np.ndarray, rounding: np.ndarray) -> ExactShape | None:
    """The shape that triangles `rows` (t,) with the `normal_rounding` (t,) make up a face of, if
    they do."""
    normal, area = surface.face_normal_area
    n, weight = normal[rows], area[rows]
    known = weight > 0
    if not known.any():
        return ExactShape(PLANAR, 0.0, np.zeros(3))
    n, weight, rounding = n[known], weight[known], rounding[known]
    mean = weight @ n
    length = np.linalg.norm(mean)
    # Normals that all are near to one another hardly shorten their mean.
    near = length > 0.5 * weight.sum()
    if near and (angles_between(n, mean / length) <= 2.0 * FLAT + 2.0 * rounding).all():
        return ExactShape(PLANAR, 0.0, np.zeros(3))
    corners = np.unique(surface.triangles[rows])
    points = surface.vertices[corners]
    a, b, c = surface.triangles[rows[known]].T
    middles = (surface.vertices[a] + surface.vertices[b] + surface.vertices[c]) / 3.0
    # The rims of a cylinder lie on a sphere too, but the normals of a sphere on no circle.
    found = _of_revolution(points, middles, n, weight, float(rounding.max()))
    return found if found is not None else _sphere(points, middles, n, weight)


def _sphere(
    points: np.ndarray, middles: np.ndarray, normals: np.ndarray, weight: np.ndarray
) -> ExactShape | None:
    """The sphere that points (p, 3) lie on and fix, if any.

    Triangles (t,) on it have `middles` and `normals` (t, 3) and areas `weight`.
    """
    if len(points) < FEWEST:
        return None
    middle = points.mean(axis=0)
    local = points - middle
    size = float(np.abs(local).max())
    if size == 0.0:
        return None
    local = local / size
    system = np.column_stack([2.0 * local, np.ones(len(local))])
    solution, _, rank, singular = np.linalg.lstsq(system, (local**2).sum(axis=1), rcond=1e-6)
    if rank < 4 or singular[-1] < 1e-3 * singular[0]:
        return None
    radius = float(np.sqrt(max(solution[3] + (solution[:3] ** 2).sum(), 0.0)))
    away = np.abs(np.linalg.norm(local - solution[:3], axis=1) - radius)
    if away.max() > ON_SHAPE * radius:
        return None
    away = unit(middles - middle - size * solution[:3])
    cosine = np.einsum("tc,tc->t", away, normals)
    outward = float(np.sign(weight @ cosine))
    if (outward * cosine).min() < np.cos(ON_SPHERE):
        return None
    return ExactShape(SPHERICAL, outward / (size * radius), np.zeros(3))


def _of_revolution(
    points: np.ndarray,
    middles: np.ndarray,
    normals: np.ndarray,
    weight: np.ndarray,
    rounding: float,
) -> ExactShape | None:
    """The circular cylinder or cone, if any: normals at one angle to the axis, vertices in circles
    around it. The parameters are those of `_sphere`."""
    if len(points) < FEWEST:
        return None
    axis, u, v = _axes(normals, weight)
    along = normals @ axis
    slope = _median(along)
    if np.abs(along - slope).max() > ON_AXIS + 2.0 * rounding:
        return None
    sides = np.stack([u, v], axis=1)
    plane, height = points @ sides, points @ axis
    middle = plane.mean(axis=0)
    local = plane - middle
    scale = float(np.abs(local).max())
    local, up = local / scale, (height - height.mean()) / scale
    square = (local**2).sum(axis=1)
    # Circles about one axis whose radius changes evenly: |p - c| = r + k h, and the slope of the
    # normals says k.
    change = 0.0 if abs(slope) < ON_AXIS else -slope / np.sqrt(max(1.0 - slope**2, 1e-12))
    for sign in (1.0, -1.0):
        k = sign * change
        # |p|^2 - 2 p.c + |c|^2 = r^2 + 2 r k h + k^2 h^2, linear in c, r and r^2 - |c|^2.
        system = np.ones((len(up), 3 if k == 0.0 else 4))
        system[:, :2] = 2.0 * local
        if k != 0.0:
            system[:, 2] = 2.0 * k * up
        wanted = square - k**2 * up**2
        solution, _, rank, _ = np.linalg.lstsq(system, wanted, rcond=1e-9)
        if rank < system.shape[1]:
            continue
        radius = np.sqrt(max(solution[-1] + (solution[:2] ** 2).sum(), 0.0))
        far = np.hypot(*(local - solution[:2]).T)
        if np.abs(far - np.abs(radius + k * up)).max() > ON_SHAPE * max(far.max(), 1e-300):
            continue
        typical = _median(far) * scale
        across = middles @ sides - (solution[:2] * scale + middle)
        outward = float(np.sign(weight @ np.einsum("tc,tc->t", across, normals @ sides)))
        kind = CYLINDRICAL if abs(slope) < ON_AXIS else CONICAL
        bend = 0.5 * outward * float(np.sqrt(1.0 - slope**2)) / typical
        return ExactShape(kind, bend, axis)
    return None


def _axes(normals: np.ndarray, weight: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The axis (3,) about which normals (t, 3) of areas `weight` (t,) lie on a circle, and two unit
    vectors square to it."""
    centred = normals - weight @ normals / weight.sum()
    spread, axes = np.linalg.eigh((centred * weight[:, None]).T @ centred / weight.sum())
    axis, u, v = axes.T
    if spread[1] < 1e-4 * spread[2]:
        # Two facets only: of all the circles through their normals that of a cylinder.
        far = np.argmax(np.abs(centred @ v))
        axis = unit(np.cross(normals[far], v))
        u = np.cross(v, axis)
    return axis, u, v


def _median(values: np.ndarray) -> float:
    """As NumPy's, which takes longer than all else on a face of some hundred triangles."""
    half = len(values) // 2
    ordered = np.partition(values, (half, len(values) - half - 1))
    return float(0.5 * (ordered[half] + ordered[len(values) - half - 1]))


def normal_rounding(surface: Surface, triangles: np.ndarray) -> np.ndarray:
    """(t,) angle that single precision leaves in the normals of triangles, by their heights."""
    _, area = surface.face_normal_area
    longest = np.sqrt(surface.side_squares[:, triangles].max(axis=0))
    height = 2.0 * area[triangles] / np.maximum(longest, np.finfo(float).tiny)
    step = np.finfo(np.float32).eps * (1.0 + np.abs(surface.origin).max() / surface.unit)
    return 2.0 * step / np.maximum(height, 10.0 * step)
