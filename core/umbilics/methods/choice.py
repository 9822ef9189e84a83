"""The method that the settings ask for, S, I or C, and what it wants besides the operators."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...base.errors import ChartError
from ...base.progress import Progress
from ...base.settings import Settings
from ...curvature.estimate import Estimate
from ...fields.winding import certified_index
from ...mesh.surface import Surface
from .curvature_tensor import (
    Unfolding,
    detect_by_curvature_tensor,
    unfolded_along_seams,
    unfolded_by_uv,
)
from .over_map import corner_deviators
from .raw import RawUmbilics
from .shape_operators import face_deviators, nearest_inside, zero_crossings, zero_weights
from .vertex_index import detect_by_index, merged_clusters


@dataclass(frozen=True)
class MethodResult:
    """Umbilics as a method finds them, and the index of every triangle of the surface."""

    raw: RawUmbilics
    triangle_index: np.ndarray


def found_by_method(
    surface: Surface,
    fitted: Estimate,
    settings: Settings,
    triangles: np.ndarray,
    seams: np.ndarray | None,
    uv: np.ndarray | None,
    progress: Progress,
) -> MethodResult:
    """The umbilics of a surface by the method of the settings; parameters as those of `detect`.

    Raises
    ------
    ChartError, CancelledError
        With a sentence for the user.
    """
    shape = fitted.field
    if settings.method == "S":
        unfolding = None
        if settings.parametrization in ("uv", "charts"):
            unfolding = _unfolded(surface, settings, triangles, seams, uv, progress)
        return _by_shape_operators(surface, fitted, settings, unfolding, progress)
    if settings.method == "I":
        raw = detect_by_index(surface, shape, progress)
        if settings.merge:
            around = _index(surface, fitted, progress.quiet())
            raw = merged_clusters(surface, raw, around)
    else:
        unfolding = _unfolded(surface, settings, triangles, seams, uv, progress)
        raw = detect_by_curvature_tensor(surface, shape, unfolding, progress)
    index = np.bincount(raw.triangle, weights=raw.index, minlength=len(surface.triangles))
    return MethodResult(raw, index)


def _unfolded(
    surface: Surface,
    settings: Settings,
    triangles: np.ndarray,
    seams: np.ndarray | None,
    uv: np.ndarray | None,
    progress: Progress,
) -> Unfolding:
    """The charts that the settings name, in the plane; parameters as those of `detect`."""
    as_it_lies = settings.method == "S" and settings.parametrization == "uv"
    charts = "uv" if as_it_lies else settings.charts
    if charts in ("islands", "uv"):
        if uv is None:
            raise ChartError(
                "The mesh has no UV map: unwrap it, or choose a method and a parametrization that "
                "need none."
            )
        return unfolded_by_uv(surface, triangles, uv, charts == "islands")
    marked = np.zeros((0, 2), int) if seams is None else seams
    return unfolded_along_seams(surface, marked, progress, charts == "automatic")


def _index(surface: Surface, fitted: Estimate, progress: Progress) -> np.ndarray:
    """(m,) certified index of each triangle."""
    if fitted.winding is not None:
        return fitted.winding.index
    return certified_index(surface, fitted.field.d1, fitted.field.d2, progress)


def _by_shape_operators(
    surface: Surface,
    fitted: Estimate,
    settings: Settings,
    unfolding: Unfolding | None,
    progress: Progress,
) -> MethodResult:
    """Method S: interpolation says where in a triangle an umbilic is, and the certified index, or
    interpolation alone as published, in which triangles."""
    shape = fitted.field
    mapped = None if unfolding is None else corner_deviators(surface, shape, unfolding)
    refused = np.zeros(len(surface.triangles), bool)

    def deviators(rows: np.ndarray) -> np.ndarray:
        local = "conformal" if mapped else settings.parametrization
        in_faces = face_deviators(surface, shape, rows, local)
        refused[rows] = in_faces.refused if mapped is None else mapped[1][rows]
        if mapped is None:
            return in_faces.values
        return np.where(refused[rows, None], in_faces.values, mapped[0][rows])

    if settings.triangles == "published":
        rows, weights, found = zero_crossings(deviators, len(surface.triangles))
        index = np.zeros(len(surface.triangles))
        index[rows] = found
    else:
        index = _index(surface, fitted, progress)
        rows = np.flatnonzero(index)
        weights, _ = zero_weights(deviators(rows))
        weights = nearest_inside(surface.vertices[surface.triangles[rows]], weights)
    warnings = []
    if refused.any():
        warnings.append(
            f"The parametrization was refused in {int(refused.sum())} folded or steep triangles; "
            "the conformal one was used there."
        )
    raw = RawUmbilics(
        triangle=rows,
        barycentric=weights,
        index=index[rows],
        vertex=np.full(len(rows), -1),
        conformal_scale=np.full(len(surface.vertices), np.nan),
        warnings=warnings,
    )
    return MethodResult(raw, index)
