"""From a working surface to a layout of rectangles, giving way where there is none.

Not every cross field has an injective map. Where one fails the field is smoothed around the place
first, then the features there are left out, then the whole field is smoothed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...base.errors import RemeshError
from ...base.progress import Progress
from ...mesh.half_edges import following
from ..cross_field import CrossField, cross_field
from ..settings import GuidanceSettings
from .chains import chains
from .crosses import crosses
from .layout import Layout
from .motorcycle_graph import motorcycle_graph
from .sectors import impossible_corners
from .seamless_map import SeamlessMap, pose
from .settings import RemeshSettings
from .untangling import injective_map
from .working_surface import WorkingSurface

# Rings around a fault in which the field is smoothed, and by how much they grow each time.
SMOOTHED_RINGS = 4
# What the smoothness grows by once neither that nor fewer features help.
SMOOTHER = 0.15
# Attempts before giving up.
ATTEMPTS = 12


@dataclass(frozen=True)
class LaidOut:
    """A working surface with its field, map and layout.

    Attributes
    ----------
    working, cross, map_, layout:
        See there; the features of `working` are those that were kept.
    warnings:
        Sentences about what gave way.
    """

    working: WorkingSurface
    cross: CrossField
    map_: SeamlessMap
    layout: Layout
    warnings: tuple[str, ...]


def laid_out(
    working: WorkingSurface,
    settings: RemeshSettings,
    size: np.ndarray,
    undirected: np.ndarray,
    progress: Progress,
) -> LaidOut:
    """A layout of the surface.

    Parameters
    ----------
    size:
        (m,) float64 length of a quad's edge in each triangle.
    undirected:
        (m,) bool triangles where the curvature means nothing.

    Raises
    ------
    RemeshError
        There is none.
    """
    surface = working.surface
    feature = working.feature.copy()
    undirected = undirected.copy()
    smoothness = settings.smoothness
    smoothed = dropped = 0
    for attempt in range(ATTEMPTS):
        part = progress.part("Mapping the surface", attempt / ATTEMPTS, (attempt + 1) / ATTEMPTS)
        cross = cross_field(
            surface,
            working.field,
            GuidanceSettings(smoothness=smoothness, feature_angle=180.0),
            part.part("Smoothing the cross field", 0.0, 0.2),
            sharp=_pairs(surface.triangles, feature),
            undirected=undirected,
        )
        crossed = crosses(
            surface.vertices,
            surface.triangles,
            surface.twin,
            cross.face_direction,
            size,
            feature,
        )
        faults = impossible_corners(crossed)
        if not faults.any():
            problem = pose(crossed)
            x, faults = injective_map(problem, part.part("Mapping the surface", 0.2, 0.9))
        if not faults.any():
            map_ = SeamlessMap(crossed, problem.seams, problem.places(x))
            layout = motorcycle_graph(map_, part.part("Drawing the layout", 0.9, 1.0))
            if layout is not None:
                warnings = _warnings(smoothed, dropped, smoothness > settings.smoothness)
                return LaidOut(
                    WorkingSurface(surface, working.field, feature, working.whole),
                    cross,
                    map_,
                    layout,
                    warnings,
                )
        near = _grown(surface.triangles, faults, SMOOTHED_RINGS * (1 + attempt))
        touched = near[surface.triangles].any(axis=1)
        new = touched & ~undirected
        if attempt % 3 < 1 and new.any():
            smoothed += 1
            undirected |= touched
            continue
        fewer = _without_least(working, feature, near)
        if attempt % 3 < 2 and fewer is not None:
            feature = fewer
            dropped += 1
            continue
        smoothness = min(smoothness + SMOOTHER, 1.0)
        if smoothness >= 1.0 and feature.any():
            feature = np.zeros_like(feature)
            dropped += 1
    raise RemeshError(
        "No layout of quads was found for a piece of the mesh. Raise the smoothness, leave "
        "creases out or repair the mesh around its folds and slivers."
    )


def _pairs(triangles: np.ndarray, feature: np.ndarray) -> np.ndarray:
    """(s, 2) ends of the feature edges."""
    edge = np.flatnonzero(feature)
    corners = triangles.ravel()
    pairs = np.sort(np.column_stack([corners[edge], corners[following(edge)]]), axis=1)
    return np.unique(pairs, axis=0)


def _grown(triangles: np.ndarray, seed: np.ndarray, rings: int) -> np.ndarray:
    found = seed.copy()
    for _ in range(rings):
        found[triangles[found[triangles].any(axis=1)]] = True
    return found


def _without_least(
    working: WorkingSurface, feature: np.ndarray, near: np.ndarray
) -> np.ndarray | None:
    """The features without the shortest chain near a fault, None where there is none."""
    surface = working.surface
    edges = np.flatnonzero(feature)
    edges = edges[edges < surface.twin[edges]]
    if not len(edges):
        return None
    chain, length = chains(surface, edges)
    corners = surface.triangles.ravel()
    touches = near[corners[edges]] | near[corners[following(edges)]]
    if not touches.any():
        return None
    close = np.unique(chain[touches])
    least = close[length[close].argmin()]
    gone = edges[chain == least]
    result = feature.copy()
    result[gone] = result[surface.twin[gone]] = False
    return result


def _warnings(smoothed: int, dropped: int, smoother: bool) -> tuple[str, ...]:
    found = []
    if smoothed:
        found.append(
            "The directions were smoothed in places where quads along the curvature would fold."
        )
    if dropped:
        found.append(
            f"{dropped} crease{'' if dropped == 1 else 's'} left out: no quads fit between "
            f"{'it' if dropped == 1 else 'them'} and what is around."
        )
    if smoother:
        found.append(
            "The directions were smoothed more than asked for: no quads follow the curvature "
            "everywhere."
        )
    return tuple(found)
