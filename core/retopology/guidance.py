"""What a plan for a quad mesh is, in the rows of the input mesh."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..base.words import counted
from ..mesh.creases import is_convex
from ..mesh.input_map import at_triangles, at_vertices, places_on_surface, sums_at_triangles
from ..mesh.surface import Surface
from .crosses.cross_field import CrossField
from .features import Features
from .poles import Poles


@dataclass(frozen=True)
class Guidance:
    """The cross field of an input mesh of n vertices and m triangles, and its poles.

    Attributes
    ----------
    direction, normal:
        (n, 3) float64 one unit direction of the cross at each vertex and the unit normal; NaN at
        vertices without a face.
    confidence:
        (n,) float64 how much the curvature says there, 0 to 1.
    face_direction:
        (m, 3) float64 one unit direction in each triangle; NaN for triangles left out.
    triangle_index:
        (m,) float64 index of the cross field, a multiple of one quarter.
    index_sum, expected_index_sum:
        Sum of the indices, and the Euler characteristic (NaN where the surface is open).
    poles:
        The pole plan.
    feature_triangle, feature_side, feature_convex:
        (e,) the edges that the field runs along: input triangle, side k (from corner k to the
        next), and whether the surface is convex there.
    timings:
        Seconds spent in each stage, by name.
    warnings:
        Sentences for the user, each saying what of the plan the surface does not allow.
    """

    direction: np.ndarray
    normal: np.ndarray
    confidence: np.ndarray
    face_direction: np.ndarray
    triangle_index: np.ndarray
    index_sum: float
    expected_index_sum: float
    poles: Poles
    feature_triangle: np.ndarray
    feature_side: np.ndarray
    feature_convex: np.ndarray
    timings: dict[str, float] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()


def guidance_of(
    surface: Surface,
    counts: tuple[int, int],
    cross: CrossField,
    poles: Poles,
    features: Features,
    timings: dict[str, float],
    warnings: tuple[str, ...],
) -> Guidance:
    """The guidance of an input mesh with `counts` vertices and triangles."""
    edges = features.half_edge
    n, m = counts
    closed = bool(surface.closed.all())
    return Guidance(
        direction=at_vertices(surface, cross.direction, n, np.nan),
        normal=at_vertices(surface, cross.normal, n, np.nan),
        confidence=at_vertices(surface, cross.confidence, n, 0.0),
        face_direction=at_triangles(surface, cross.face_direction, m, np.nan),
        triangle_index=sums_at_triangles(surface, cross.triangle_index, m),
        index_sum=float(cross.triangle_index.sum()),
        expected_index_sum=float(surface.euler_characteristic.sum()) if closed else float("nan"),
        poles=poles,
        feature_triangle=surface.source_triangle[edges // 3],
        feature_side=edges % 3,
        feature_convex=is_convex(surface, edges),
        timings=timings,
        warnings=warnings,
    )


def disagreements(
    surface: Surface, stayed: int, cross: CrossField, poles: Poles
) -> tuple[str, ...]:
    """Sentences on what could not be had.

    Parameters
    ----------
    stayed:
        How many umbilics could not leave the directions.
    cross:
        The field that has the poles as far as it can.
    """
    found = []
    if stayed:
        found.append(
            f"{counted(stayed, 'umbilic')} that should go stay in the field: nothing opposite is "
            "left to cancel with, or the surface is too rough there."
        )
    planned = np.zeros(len(cross.triangle_index))
    at, _ = places_on_surface(surface, poles.triangle, poles.barycentric)
    np.add.at(planned, at, 4 - poles.valence)
    differing = int(np.count_nonzero(planned != np.rint(4.0 * cross.triangle_index)))
    differing = max(differing, cross.astray)
    if differing:
        found.append(
            f"The cross field has other poles than planned in {counted(differing, 'place')}: the "
            "sum of the planned ones does not allow them, or triangles are too few there."
        )
    return tuple(found)
