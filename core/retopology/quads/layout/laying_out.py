"""From a working surface to a layout of rectangles, giving way where there is none.

Not every cross field has an injective map. Where one fails some of what was wished for goes, and
the field and its map are made anew.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ....base.progress import Progress
from ..field.crosses import Crosses, crosses
from ..field.directions import direction_weights, guiding_directions, turned_to
from ..field.planned import PlannedField, planned_field
from ..field.pole_moves import with_better_poles
from ..field.sectors import shut_corners
from ..field.wishes import Wishes
from ..mapping.seamless_map import SeamlessMap, pose
from ..mapping.untangling import injective_map
from ..surface.subdivision import CREASE_BIT, MARK_BIT
from ..surface.working_surface import WorkingSurface
from .effort import Effort
from .giving_way import SMOOTHER, least_feature, next_wishes
from .motorcycle_graph import motorcycle_graph
from .rectangles import Layout

# Attempts before giving up.
ATTEMPTS = 9
# Quads for each pole: with fewer there is nothing between them to be regular.
FEWEST_EACH = 8
# With fewer than so many some lie side by side: there are about as many vertices as quads, of which
# every second could be a pole. A sphere has eight at least: up to twice as many are no excess.
LEAST_EACH, FEW = 2, 16


@dataclass(frozen=True)
class LaidOut:
    """A working surface with its field, map and layout, and the wishes that were fulfilled."""

    working: WorkingSurface
    wishes: Wishes
    planned: PlannedField
    map_: SeamlessMap
    layout: Layout

    @property
    def loose_end(self) -> np.ndarray:
        """(n,) bool vertices where a crease ends in the open: it fades there, and nothing says
        where. Ends of edges that a user has marked are none."""
        crosses = self.map_.crosses
        n = len(crosses.vertices)
        ends = np.bincount(crosses.tail[crosses.feature], minlength=n) == 1
        ends &= ~crosses.border
        marked = self.wishes.feature & MARK_BIT > 0
        ends[crosses.tail[marked]] = False
        return np.asarray(ends)


def laid_out(
    working: WorkingSurface,
    wishes: Wishes,
    progress: Progress,
    effort: Effort,
    attempts: int = ATTEMPTS,
) -> LaidOut | None:
    """A layout of the surface, in so many attempts at most while there is effort left, in one
    anyway; None where none was found."""
    asked = wishes
    size = len(working.surface.triangles)
    none = np.zeros(len(working.surface.vertices), bool)
    tried = None
    for attempt in range(attempts):
        if attempt and not effort.left:
            return None
        if wishes is tried:
            # A map without a fault has no layout, and nothing has given way: it has none again.
            wishes = next_wishes(working, asked, wishes, none, None, attempt)
            continue
        part = progress.part("Mapping the surface", attempt / attempts, (attempt + 1) / attempts)
        found = _affordable(working, wishes, part, effort)
        if found is None:
            return None
        planned, crossed, wishes = found
        tried = wishes
        effort.spend(size if attempt else 0)
        # Moves of poles can take too much from the end of a crease.
        shut = shut_corners(crossed) | (crossed.singular & (crossed.quarter_turns < 2))
        if shut.any():
            wishes = next_wishes(working, asked, wishes, shut, None, attempt)
            continue
        guiding = guiding_directions(working, wishes, planned, crossed)
        crossed = turned_to(crossed, guiding)
        problem = pose(crossed, direction_weights(working, wishes, planned, crossed))
        x, faults = injective_map(problem, part.part("Mapping the surface", 0.2, 0.9))
        if not faults.any():
            map_ = SeamlessMap(crossed, problem.seams, problem.places(x))
            layout = motorcycle_graph(map_, part.part("Drawing the layout", 0.9, 1.0))
            if layout is not None:
                return LaidOut(working, wishes, planned, map_, layout)
        residual = ((problem.jacobian(x) - problem.target) ** 2).sum(axis=1)
        wishes = next_wishes(working, asked, wishes, faults, residual, attempt)
    return None


def _affordable(
    working: WorkingSurface, wishes: Wishes, progress: Progress, effort: Effort
) -> tuple[PlannedField, Crosses, Wishes] | None:
    """As `_crossed`, the directions smoother while they have more poles than there are quads for,
    if that makes fewer; None where all have more than quads go between."""
    _, area = working.surface.face_normal_area
    quads = float((area / wishes.size**2).sum())
    best: tuple[PlannedField, Crosses, Wishes] | None = None
    fewest, most = 0, max(quads / LEAST_EACH, FEW)
    while True:
        found = _crossed(working, wishes, progress, effort, most)
        if found is not None:
            poles = int(np.count_nonzero(found[1].singular))
            if best is not None and poles >= fewest:
                return best
            if poles <= most or wishes.wanted is not None:
                best, fewest = found, poles
            if poles * FEWEST_EACH <= quads or wishes.wanted is not None:
                return best
            wishes = found[2]
        if wishes.smoothness >= 1.0 or not effort.left:
            return best
        wishes = replace(wishes, smoothness=min(wishes.smoothness + SMOOTHER, 1.0))


def _crossed(
    working: WorkingSurface, wishes: Wishes, progress: Progress, effort: Effort, most: float
) -> tuple[PlannedField, Crosses, Wishes] | None:
    """The field, its crosses, and the wishes without features that meet at no angle; None where
    the field has more than `most` poles."""
    surface = working.surface
    while True:
        progress.step(0.1)
        effort.spend(len(surface.triangles))
        planned = planned_field(working, wishes, most, progress)
        if planned is None:
            return None
        crossed = crosses(
            surface.vertices,
            surface.triangles,
            surface.twin,
            planned.cross.face_direction,
            wishes.size,
            wishes.feature > 0,
        )
        fewer = wishes
        for vertex in np.flatnonzero(shut_corners(crossed)).tolist():
            at = np.zeros(len(surface.vertices), bool)
            at[vertex] = True
            for bits in (CREASE_BIT, MARK_BIT):
                least = least_feature(working, fewer.feature & bits > 0, at, None)
                if least is not None:
                    fewer = fewer.without(least)
                    break
        if fewer is wishes:
            return planned, _bettered(crossed, wishes), wishes
        wishes = fewer


def _bettered(crossed: Crosses, wishes: Wishes) -> Crosses:
    avoided = wishes.avoided if wishes.failed is None else wishes.avoided | wishes.failed
    return with_better_poles(crossed, avoided, wishes.mirror, wishes.reach, wishes.plain)
