"""From a working surface to a layout of rectangles, giving way where there is none.

Not every cross field has an injective map. Where one fails the features there are left out one by
one and the field is smoothed around the place; in the end all is begun anew without creases, more
and more smoothly.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from ....base.progress import Progress
from ....mesh.half_edges import following
from ....umbilics.result import Umbilics
from ...by_hand import Strokes, WantedPoles
from ..field.crosses import Crosses, crosses
from ..field.planned import PlannedField, planned_field
from ..field.pole_moves import with_better_poles
from ..field.sectors import shut_corners
from ..mapping.seamless_map import SeamlessMap, pose
from ..mapping.untangling import injective_map
from ..surface.chains import chains
from ..surface.subdivision import CREASE, MARK
from ..surface.working_surface import WorkingSurface
from .motorcycle_graph import motorcycle_graph
from .rectangles import Layout

# Rings around faults that make one place of them, and that are smoothed in each attempt more.
FAULT_RINGS, SMOOTHED_RINGS = 3, 3
# Attempts before giving up; those in which one crease goes in each place, and those in which only
# places give way.
ATTEMPTS, ONE_EACH, LAST_LOCAL = 9, 2, 3
# What the smoothness grows by in each beginning anew, and where there are more poles than quads.
SMOOTHER = 0.3
# What the reach of poles that cancel grows by in each attempt but the first ones.
FARTHER = 4.0
# Quads for each pole: with fewer there is nothing between them to be regular.
FEWEST_EACH = 8


@dataclass(frozen=True)
class Wishes:
    """What a layout should respect on a working surface of n vertices and m triangles.

    Attributes
    ----------
    smoothness:
        Of the cross field, see `GuidanceSettings`.
    feature:
        (3 m,) int8 half-edges on features inside the surface, as in `Triangles`.
    size:
        (m,) float64 length of a quad's edge in each triangle.
    undirected:
        (m,) bool triangles where the curvature means nothing.
    avoided:
        (n,) bool vertices where no pole is wanted.
    mirror:
        (n,) bool vertices on the plane of symmetry.
    umbilics, umbilic_row:
        Those kept on the surface, in its triangles, and the rows (u,) int64 that they have among
        all that were kept.
    strokes:
        Lines that the field is to run along, None for none.
    wanted:
        All the poles that there are to be, None where the field tells them.
    reach:
        Opposite poles cancel that are nearer than so many times what they always do.
    smoothed, dropped, unmarked:
        How many places were smoothed, creases left out and marks left out so far.
    """

    smoothness: float
    feature: np.ndarray
    size: np.ndarray
    undirected: np.ndarray
    avoided: np.ndarray
    mirror: np.ndarray
    umbilics: Umbilics
    umbilic_row: np.ndarray
    strokes: Strokes | None = None
    wanted: WantedPoles | None = None
    reach: float = 1.0
    smoothed: int = 0
    dropped: int = 0
    unmarked: int = 0

    def without(self, edges: np.ndarray) -> Wishes:
        """Without one feature, whose half-edges are given as (3 m,) bool."""
        marked = bool((self.feature[edges] & MARK).any())
        return replace(
            self,
            feature=np.where(edges, np.int8(0), self.feature),
            dropped=self.dropped + (not marked),
            unmarked=self.unmarked + marked,
        )


@dataclass(frozen=True)
class LaidOut:
    """A working surface with its field, map and layout, and the wishes that were fulfilled."""

    working: WorkingSurface
    wishes: Wishes
    planned: PlannedField
    map_: SeamlessMap
    layout: Layout


def laid_out(
    working: WorkingSurface, wishes: Wishes, progress: Progress, attempts: int = ATTEMPTS
) -> LaidOut | None:
    """A layout of the surface, in so many attempts at most; None where none was found."""
    asked = wishes
    for attempt in range(attempts):
        part = progress.part("Mapping the surface", attempt / attempts, (attempt + 1) / attempts)
        planned, crossed, wishes = _affordable(working, wishes, part)
        # Moves of poles can take too much from the end of a crease.
        shut = shut_corners(crossed) | (crossed.singular & (crossed.quarter_turns < 2))
        if shut.any():
            wishes = _next(working, asked, wishes, shut, None, attempt)
            continue
        problem = pose(crossed)
        x, faults = injective_map(problem, part.part("Mapping the surface", 0.2, 0.9))
        if not faults.any():
            map_ = SeamlessMap(crossed, problem.seams, problem.places(x))
            layout = motorcycle_graph(map_, part.part("Drawing the layout", 0.9, 1.0))
            if layout is not None:
                return LaidOut(working, wishes, planned, map_, layout)
        residual = ((problem.jacobian(x) - problem.target) ** 2).sum(axis=1)
        wishes = _next(working, asked, wishes, faults, residual, attempt)
    return None


def _next(
    working: WorkingSurface,
    asked: Wishes,
    wishes: Wishes,
    faults: np.ndarray,
    residual: np.ndarray | None,
    attempt: int,
) -> Wishes:
    """What is wished for after an attempt that failed: places give way, and every second time
    after that all is begun anew. Opposite poles cancel that are ever farther apart."""
    number, between = divmod(attempt - LAST_LOCAL, 2)
    if attempt >= LAST_LOCAL and not between:
        return replace(_bare(working, asked, number), reach=FARTHER ** (2 * number))
    farther = wishes.reach * FARTHER if attempt >= ONE_EACH else wishes.reach
    return replace(gentler(working, wishes, faults, residual, attempt), reach=farther)


def _bare(working: WorkingSurface, asked: Wishes, number: int) -> Wishes:
    """What was asked for without any crease, in the first of such beginnings with all marks; the
    directions as they were measured, the smoother the later. Creases that shut each other in bend
    a map everywhere, and where the curvature is not heard at all nothing keeps its poles apart."""
    kept = np.where(number == 0, asked.feature & MARK, 0).astype(np.int8)
    left_out = np.flatnonzero((asked.feature > 0) & (kept == 0))
    left_out = left_out[left_out < working.surface.twin[left_out]]
    chain, _ = chains(working.surface, left_out)
    _, first = np.unique(chain, return_index=True)
    marked = int(np.count_nonzero(asked.feature[left_out[first]] & MARK))
    return replace(
        asked,
        feature=kept,
        smoothness=min(asked.smoothness + SMOOTHER * number, 1.0),
        dropped=asked.dropped + len(first) - marked,
        unmarked=asked.unmarked + marked,
    )


def _affordable(
    working: WorkingSurface, wishes: Wishes, progress: Progress
) -> tuple[PlannedField, Crosses, Wishes]:
    """As `_crossed`, the directions smoother while they have more poles than there are quads for,
    if that makes fewer."""
    _, area = working.surface.face_normal_area
    quads = float((area / wishes.size**2).sum())
    best: tuple[PlannedField, Crosses, Wishes] | None = None
    fewest = 0
    while True:
        found = _crossed(working, wishes, progress)
        poles = int(np.count_nonzero(found[1].singular))
        if best is None or poles < fewest:
            best, fewest = found, poles
        if poles * FEWEST_EACH <= quads or wishes.wanted is not None or wishes.smoothness >= 1.0:
            return best
        wishes = replace(found[2], smoothness=min(wishes.smoothness + SMOOTHER, 1.0))


def gentler(
    working: WorkingSurface,
    wishes: Wishes,
    faults: np.ndarray,
    residual: np.ndarray | None,
    attempt: int,
) -> Wishes:
    """Fewer wishes around the vertices `faults` (n,) bool where the last have failed.

    In each of the places the least crease goes, later every crease; where none is left, and in
    every second attempt, the directions are smoothed.
    """
    surface = working.surface
    places = grown(surface.triangles, faults, FAULT_RINGS)
    # What a user has marked stays as long as anything else can go.
    bits = CREASE if attempt < LAST_LOCAL else CREASE | MARK
    fewer, bare = _without_creases(
        working, wishes, places, bits, residual, every=attempt >= ONE_EACH
    )
    smoothed = bare if attempt % 2 == 0 else places
    near = grown(surface.triangles, smoothed, SMOOTHED_RINGS * attempt)
    touched = near[surface.triangles].any(axis=1)
    if (touched & ~fewer.undirected).any():
        undirected = fewer.undirected | touched
        fewer = replace(fewer, undirected=undirected, smoothed=fewer.smoothed + 1)
    return fewer


def without_open_creases(working: WorkingSurface, wishes: Wishes, near: np.ndarray) -> Wishes:
    """Without the creases at the vertices `near` (n,) bool that end somewhere in the open: of all
    features these are the least sure."""
    surface = working.surface
    corners = surface.triangles.ravel()
    edges = np.flatnonzero(wishes.feature)
    edges = edges[edges < surface.twin[edges]]
    if not len(edges):
        return wishes
    tail, head = corners[edges], corners[following(edges)]
    degree = np.bincount(np.concatenate([tail, head]), minlength=len(near))
    open_ = (degree == 1) & ~surface.border
    chain, _ = chains(surface, edges)
    count = int(chain.max()) + 1
    gone = np.bincount(chain, weights=open_[tail] | open_[head], minlength=count) > 0
    gone &= np.bincount(chain, weights=near[tail] | near[head], minlength=count) > 0
    gone &= np.bincount(chain, weights=wishes.feature[edges] & MARK, minlength=count) == 0
    for number in np.flatnonzero(gone).tolist():
        chosen = np.zeros(len(wishes.feature), bool)
        mine = edges[chain == number]
        chosen[mine] = chosen[surface.twin[mine]] = True
        wishes = wishes.without(chosen)
    return wishes


def _without_creases(
    working: WorkingSurface,
    wishes: Wishes,
    places: np.ndarray,
    bits: int,
    residual: np.ndarray | None,
    every: bool,
) -> tuple[Wishes, np.ndarray]:
    """Without the least feature in each connected part of the vertices `places` (n,) bool, or
    without `every` one, and the vertices (n,) bool of the parts that had none."""
    triangles = working.surface.triangles
    tail, head = triangles.ravel(), triangles[:, [1, 2, 0]].ravel()
    inside = places[tail] & places[head]
    n = len(places)
    graph = sparse.coo_array((np.ones(inside.sum()), (tail[inside], head[inside])), shape=(n, n))
    _, label = csgraph.connected_components(graph, directed=False)
    bare = np.zeros(n, bool)
    fewer = wishes
    for part in np.unique(label[places]).tolist():
        mine = places & (label == part)
        least = _least(working, fewer.feature & bits > 0, mine, residual)
        if least is None:
            bare |= mine
        while least is not None:
            fewer = fewer.without(least)
            least = _least(working, fewer.feature & bits > 0, mine, residual) if every else None
    return fewer, bare


def grown(triangles: np.ndarray, seed: np.ndarray, rings: int) -> np.ndarray:
    """(n,) bool, a set of vertices and so many rings around."""
    found = seed.copy()
    for _ in range(rings):
        found[triangles[found[triangles].any(axis=1)]] = True
    return found


def _crossed(
    working: WorkingSurface, wishes: Wishes, progress: Progress
) -> tuple[PlannedField, Crosses, Wishes]:
    """The field, its crosses, and the wishes without features that meet at no angle."""
    surface = working.surface
    while True:
        progress.step(0.1)
        planned = planned_field(
            working,
            wishes.smoothness,
            wishes.feature,
            wishes.undirected,
            wishes.umbilics,
            wishes.avoided,
            wishes.strokes,
            wishes.wanted,
        )
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
            for bits in (CREASE, MARK):
                least = _least(working, fewer.feature & bits > 0, at, None)
                if least is not None:
                    fewer = fewer.without(least)
                    break
        if fewer is wishes:
            return planned, _bettered(crossed, wishes), wishes
        wishes = fewer


def _bettered(crossed: Crosses, wishes: Wishes) -> Crosses:
    return with_better_poles(crossed, wishes.avoided, wishes.mirror, wishes.reach)


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
