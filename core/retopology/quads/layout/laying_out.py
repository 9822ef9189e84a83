"""From a working surface to a layout of rectangles, giving way where there is none.

Not every cross field has an injective map. Where one fails the field is smoothed around the place
first, then the features there are left out, then the whole field is smoothed.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ....base.errors import RemeshError
from ....base.progress import Progress
from ....mesh.half_edges import following
from ...cross_field import CrossField, cross_field
from ...settings import GuidanceSettings
from ..field.crosses import Crosses, crosses
from ..field.pole_moves import with_better_poles
from ..field.sectors import shut_corners
from ..mapping.seamless_map import SeamlessMap, pose
from ..mapping.untangling import injective_map
from ..surface.chains import chains
from ..surface.working_surface import WorkingSurface
from .motorcycle_graph import motorcycle_graph
from .rectangles import Layout

# Rings around a fault in which the field is smoothed, and by how much they grow each time.
SMOOTHED_RINGS = 4
# What the smoothness grows by once neither that nor fewer features help.
SMOOTHER = 0.15
# Attempts before giving up.
ATTEMPTS = 12


@dataclass(frozen=True)
class Wishes:
    """What a layout should respect on a working surface of n vertices and m triangles.

    Attributes
    ----------
    smoothness:
        Of the cross field, see `GuidanceSettings`.
    feature:
        (3 m,) bool half-edges on features inside the surface.
    size:
        (m,) float64 length of a quad's edge in each triangle.
    undirected:
        (m,) bool triangles where the curvature means nothing.
    avoided:
        (n,) bool vertices where no pole is wanted.
    mirror:
        (n,) bool vertices on the plane of symmetry.
    smoothed, dropped:
        How many places were smoothed and features left out so far.
    """

    smoothness: float
    feature: np.ndarray
    size: np.ndarray
    undirected: np.ndarray
    avoided: np.ndarray
    mirror: np.ndarray
    smoothed: int = 0
    dropped: int = 0


@dataclass(frozen=True)
class LaidOut:
    """A working surface with its field, map and layout, and the wishes that were fulfilled."""

    working: WorkingSurface
    wishes: Wishes
    cross: CrossField
    map_: SeamlessMap
    layout: Layout


def laid_out(
    working: WorkingSurface, wishes: Wishes, progress: Progress, attempts: int = ATTEMPTS
) -> LaidOut:
    """A layout of the surface, in so many attempts at most.

    Raises
    ------
    RemeshError
        There is none.
    """
    for attempt in range(attempts):
        part = progress.part("Mapping the surface", attempt / attempts, (attempt + 1) / attempts)
        cross, crossed, wishes = _crossed(working, wishes, part)
        problem = pose(crossed)
        x, faults = injective_map(problem, part.part("Mapping the surface", 0.2, 0.9))
        if not faults.any():
            map_ = SeamlessMap(crossed, problem.seams, problem.places(x))
            layout = motorcycle_graph(map_, part.part("Drawing the layout", 0.9, 1.0))
            if layout is not None:
                return LaidOut(working, wishes, cross, map_, layout)
        residual = ((problem.jacobian(x) - problem.target) ** 2).sum(axis=1)
        near = grown(working.surface.triangles, faults, SMOOTHED_RINGS * (1 + attempt))
        wishes = gentler(working, wishes, near, residual, attempt)
    raise RemeshError(
        "No layout of quads was found for a piece of the mesh. Raise the smoothness, leave "
        "creases out or repair the mesh around its folds and slivers."
    )


def gentler(
    working: WorkingSurface,
    wishes: Wishes,
    near: np.ndarray,
    residual: np.ndarray | None,
    attempt: int,
) -> Wishes:
    """Fewer wishes around the vertices `near` (n,) bool where the last have failed: a feature
    less, then directions smoothed, in turns, and in the end everywhere."""
    touched = near[working.surface.triangles].any(axis=1)
    chosen = _least(working, wishes.feature, near, residual)
    if chosen is not None and attempt % 2 == 0:
        return replace(wishes, feature=wishes.feature & ~chosen, dropped=wishes.dropped + 1)
    if (touched & ~wishes.undirected).any() and attempt % 4 < 2:
        undirected = wishes.undirected | touched
        return replace(wishes, undirected=undirected, smoothed=wishes.smoothed + 1)
    smoothness = min(wishes.smoothness + SMOOTHER, 1.0)
    if smoothness < 1.0 or not wishes.feature.any():
        return replace(wishes, smoothness=smoothness)
    none = np.zeros_like(wishes.feature)
    return replace(wishes, smoothness=smoothness, feature=none, dropped=wishes.dropped + 1)


def _pairs(triangles: np.ndarray, feature: np.ndarray) -> np.ndarray:
    """(s, 2) ends of the feature edges."""
    edge = np.flatnonzero(feature)
    corners = triangles.ravel()
    pairs = np.sort(np.column_stack([corners[edge], corners[following(edge)]]), axis=1)
    return np.unique(pairs, axis=0)


def grown(triangles: np.ndarray, seed: np.ndarray, rings: int) -> np.ndarray:
    """(n,) bool, a set of vertices and so many rings around."""
    found = seed.copy()
    for _ in range(rings):
        found[triangles[found[triangles].any(axis=1)]] = True
    return found


def _crossed(
    working: WorkingSurface, wishes: Wishes, progress: Progress
) -> tuple[CrossField, Crosses, Wishes]:
    """The field, its crosses, and the wishes without features that meet at no angle."""
    surface = working.surface
    settings = GuidanceSettings(smoothness=wishes.smoothness, feature_angle=180.0)
    while True:
        progress.step(0.1)
        cross = cross_field(
            surface,
            working.field,
            settings,
            Progress(),
            sharp=_pairs(surface.triangles, wishes.feature),
            undirected=wishes.undirected,
        )
        crossed = crosses(
            surface.vertices,
            surface.triangles,
            surface.twin,
            cross.face_direction,
            wishes.size,
            wishes.feature,
        )
        chosen = np.zeros(len(wishes.feature), bool)
        dropped = wishes.dropped
        for vertex in np.flatnonzero(shut_corners(crossed)).tolist():
            at = np.zeros(len(surface.vertices), bool)
            at[vertex] = True
            least = _least(working, wishes.feature & ~chosen, at, None)
            if least is not None:
                chosen |= least
                dropped += 1
        if not chosen.any():
            return cross, _bettered(crossed, wishes), wishes
        wishes = replace(wishes, feature=wishes.feature & ~chosen, dropped=dropped)


def _bettered(crossed: Crosses, wishes: Wishes) -> Crosses:
    return with_better_poles(crossed, wishes.avoided, wishes.mirror)


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


def words(wishes: list[Wishes], smoothness: float) -> list[str]:
    """Sentences about what gave way, over all pieces."""
    found = []
    smoothed = sum(one.smoothed for one in wishes)
    dropped = sum(one.dropped for one in wishes)
    if smoothed:
        found.append(
            f"The directions were smoothed in {smoothed} place{'' if smoothed == 1 else 's'} "
            "where quads along the curvature would fold."
        )
    if dropped:
        found.append(
            f"{dropped} crease{'' if dropped == 1 else 's'} left out: no quads fit between "
            f"{'it' if dropped == 1 else 'them'} and what is around."
        )
    if any(one.smoothness > smoothness for one in wishes):
        found.append(
            "The directions were smoothed more than asked for: no quads follow the curvature "
            "everywhere."
        )
    return found
