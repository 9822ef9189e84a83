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
from .crosses import Crosses, crosses
from .layout import Layout
from .motorcycle_graph import motorcycle_graph
from .pole_moves import with_better_poles
from .seamless_map import SeamlessMap, pose
from .sectors import shut_corners
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
    avoided: np.ndarray,
    progress: Progress,
) -> LaidOut:
    """A layout of the surface.

    Parameters
    ----------
    size:
        (m,) float64 length of a quad's edge in each triangle.
    undirected:
        (m,) bool triangles where the curvature means nothing.
    avoided:
        (n,) bool vertices where no pole is wanted.

    Raises
    ------
    RemeshError
        There is none.
    """
    surface = working.surface
    feature = working.feature
    smoothness = settings.smoothness
    smoothed = dropped = 0
    for attempt in range(ATTEMPTS):
        part = progress.part("Mapping the surface", attempt / ATTEMPTS, (attempt + 1) / ATTEMPTS)
        cross, crossed, fewer = _crossed(
            working,
            GuidanceSettings(smoothness=smoothness, feature_angle=180.0),
            feature,
            size,
            undirected,
            avoided,
            part,
        )
        dropped += np.count_nonzero(feature) > np.count_nonzero(fewer)
        feature = fewer
        problem = pose(crossed)
        x, faults = injective_map(problem, part.part("Mapping the surface", 0.2, 0.9))
        if not faults.any():
            map_ = SeamlessMap(crossed, problem.seams, problem.places(x))
            layout = motorcycle_graph(map_, part.part("Drawing the layout", 0.9, 1.0))
            if layout is not None:
                kept = WorkingSurface(surface, working.field, feature, working.whole)
                warnings = _warnings(smoothed, dropped, smoothness > settings.smoothness)
                return LaidOut(kept, cross, map_, layout, warnings)
        near = _grown(surface.triangles, faults, SMOOTHED_RINGS * (1 + attempt))
        touched = near[surface.triangles].any(axis=1)
        residual = ((problem.jacobian(x) - problem.target) ** 2).sum(axis=1)
        chosen = _least(working, feature, near, residual)
        if chosen is not None and attempt % 2 == 0:
            feature = feature & ~chosen
            dropped += 1
        elif (touched & ~undirected).any() and attempt % 4 < 2:
            undirected = undirected | touched
            smoothed += 1
        else:
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


def _crossed(
    working: WorkingSurface,
    settings: GuidanceSettings,
    feature: np.ndarray,
    size: np.ndarray,
    undirected: np.ndarray,
    avoided: np.ndarray,
    progress: Progress,
) -> tuple[CrossField, Crosses, np.ndarray]:
    """The field, its crosses, and the features without those that meet at no angle."""
    surface = working.surface
    while True:
        progress.step(0.1)
        cross = cross_field(
            surface,
            working.field,
            settings,
            Progress(),
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
        shut = shut_corners(crossed)
        chosen = np.zeros(len(feature), bool)
        for vertex in np.flatnonzero(shut).tolist():
            at = np.zeros(len(shut), bool)
            at[vertex] = True
            least = _least(working, feature, at, None)
            if least is not None:
                chosen |= least
        if not chosen.any():
            return cross, with_better_poles(crossed, avoided), feature
        feature = feature & ~chosen


def _least(
    working: WorkingSurface,
    feature: np.ndarray,
    near: np.ndarray,
    residual: np.ndarray | None,
) -> np.ndarray | None:
    """(3 m,) bool the feature that matters least of those with an edge at the vertices `near`;
    None where there is none. Short ones matter little, and those along which the map is bent far
    from the crosses, by `residual` (m,), do harm."""
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
    worth = length
    if residual is not None:
        beside = 0.5 * (residual[edges // 3] + residual[surface.twin[edges] // 3])
        count = np.bincount(chain)
        worth = length * count / np.maximum(np.bincount(chain, weights=beside), 1e-12)
    gone = edges[chain == close[worth[close].argmin()]]
    chosen = np.zeros(len(feature), bool)
    chosen[gone] = chosen[surface.twin[gone]] = True
    return chosen


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
