"""Regions as they are reported: area, index, kind and curvature in units of the input."""

from __future__ import annotations

import numpy as np

from ...base.median import weighted_median
from ...curvature.tolerances import PLANAR_BEND, PLANAR_ERRORS
from ...mesh.exact_shapes import PLANAR, SPHERICAL
from ...mesh.surface import Surface
from ..result import CURVE, UNRESOLVED, Region
from .region_map import RegionMap


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
        curvature = weighted_median(mean_curvature[corners[known]].mean(axis=1), weight[known])
        # The errors of fits that share samples are not independent.
        reach = max(_mean(radius[corners], weight) ** 2, np.finfo(float).tiny)
        independent = total / (np.pi * reach)
        error = 0.5 * _mean(noise[corners], weight) / np.sqrt(max(independent, 1.0))
        extent = np.sqrt(max(total, np.finfo(float).tiny) / np.pi)
        flat = max(PLANAR_BEND / extent, PLANAR_ERRORS * error)
        kind = PLANAR if abs(curvature) <= flat else SPHERICAL
        few = regions.count - regions.few
        if number >= few:
            kind = UNRESOLVED
        elif number >= few - regions.curves:
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


def _mean(corners: np.ndarray, weights: np.ndarray) -> float:
    """Mean over triangles of what is known at their corners (r, 3), by area."""
    known = np.isfinite(corners)
    weights = np.broadcast_to(weights[:, None], corners.shape)[known]
    total = float(weights.sum())
    if total > 0.0:
        return float((corners[known] * weights).sum() / total)
    return float(corners[known].mean()) if known.any() else 0.0
