"""Which wishes go first where a layout fails.

Around the places that fail features are left out one by one, the least first, and the directions
are smoothed; in the end all is begun anew without creases, more and more smoothly.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from ....mesh.half_edges import ends_of
from ....mesh.rings import with_rings
from ..field.wishes import Wishes
from ..surface.chains import chains
from ..surface.subdivision import CREASE_BIT, MARK_BIT
from ..surface.working_surface import WorkingSurface

# Rings around faults that make one place of them, and that are smoothed in each attempt more.
FAULT_RINGS, SMOOTHED_RINGS = 3, 3
# Attempts in which one crease goes in each place, and those in which only places give way.
ONE_EACH, LAST_LOCAL = 2, 3
# What the smoothness grows by in each beginning anew, and where there are more poles than quads.
SMOOTHER = 0.3
# What the reach of poles that cancel grows by in each attempt but the first ones.
FARTHER = 4.0


def next_wishes(
    working: WorkingSurface,
    asked: Wishes,
    wishes: Wishes,
    faults: np.ndarray,
    residual: np.ndarray | None,
    attempt: int,
) -> Wishes:
    """What is wished for after an attempt that failed: places give way, and every second time
    after that all is begun anew. Opposite poles cancel that are ever farther apart. The same
    wishes where nothing changes."""
    number, between = divmod(attempt - LAST_LOCAL, 2)
    if attempt >= LAST_LOCAL and not between:
        return replace(_bare(working, asked, number), reach=FARTHER ** (2 * number))
    fewer = gentler(working, wishes, faults, residual, attempt) if faults.any() else wishes
    return fewer if attempt < ONE_EACH else replace(fewer, reach=wishes.reach * FARTHER)


def gentler(
    working: WorkingSurface,
    wishes: Wishes,
    faults: np.ndarray,
    residual: np.ndarray | None,
    attempt: int,
) -> Wishes:
    """Fewer wishes around the vertices `faults` (n,) bool where the last have failed.

    In each of the places the least crease goes, later every crease; where none is left, and in
    every second attempt, the directions are smoothed. Corners there get the number of quads that
    their angle is nearest to, and poles leave the faults, but for those that a user placed: beside
    another one, nearer than a quad, a map may unfold around the next vertex what belongs here.
    """
    surface = working.surface
    places = with_rings(surface.triangles, faults, FAULT_RINGS)
    # What a user has marked stays as long as anything else can go.
    bits = CREASE_BIT if attempt < LAST_LOCAL else CREASE_BIT | MARK_BIT
    fewer, bare = _without_creases(
        working, wishes, places, bits, residual, every=attempt >= ONE_EACH
    )
    smoothed = bare if attempt % 2 == 0 else places
    near = with_rings(surface.triangles, smoothed, SMOOTHED_RINGS * attempt)
    touched = near[surface.triangles].any(axis=1)
    if (touched & ~fewer.undirected).any():
        undirected = fewer.undirected | touched
        fewer = replace(fewer, undirected=undirected, smoothed=fewer.smoothed + 1)
    plain = places if wishes.plain is None else wishes.plain | places
    failed = faults if wishes.failed is None else wishes.failed | faults
    return replace(fewer, plain=plain, failed=failed if wishes.wanted is None else None)


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
    tail, head = ends_of(triangles)
    inside = places[tail] & places[head]
    n = len(places)
    graph = sparse.coo_array((np.ones(inside.sum()), (tail[inside], head[inside])), shape=(n, n))
    _, label = csgraph.connected_components(graph, directed=False)
    bare = np.zeros(n, bool)
    fewer = wishes
    for part in np.unique(label[places]).tolist():
        mine = places & (label == part)
        least = least_feature(working, fewer.feature & bits > 0, mine, residual)
        if least is None:
            bare |= mine
        while least is not None:
            fewer = fewer.without(least)
            if not every:
                break
            least = least_feature(working, fewer.feature & bits > 0, mine, residual)
    return fewer, bare


def without_open_creases(working: WorkingSurface, wishes: Wishes, near: np.ndarray) -> Wishes:
    """Without the creases at the vertices `near` (n,) bool that end somewhere in the open: of all
    features these are the least sure."""
    surface = working.surface
    edges = np.flatnonzero(wishes.feature)
    edges = edges[edges < surface.twin[edges]]
    if not len(edges):
        return wishes
    tail, head = ends_of(surface.triangles, edges)
    degree = np.bincount(np.concatenate([tail, head]), minlength=len(near))
    open_ = (degree == 1) & ~surface.border
    chain, _ = chains(surface, edges)
    count = int(chain.max()) + 1
    gone = np.bincount(chain, weights=open_[tail] | open_[head], minlength=count) > 0
    gone &= np.bincount(chain, weights=near[tail] | near[head], minlength=count) > 0
    gone &= np.bincount(chain, weights=wishes.feature[edges] & MARK_BIT, minlength=count) == 0
    for number in np.flatnonzero(gone).tolist():
        chosen = np.zeros(len(wishes.feature), bool)
        mine = edges[chain == number]
        chosen[mine] = chosen[surface.twin[mine]] = True
        wishes = wishes.without(chosen)
    return wishes


def _bare(working: WorkingSurface, asked: Wishes, number: int) -> Wishes:
    """What was asked for without any crease, in the first of such beginnings with all marks; the
    directions as they were measured, the smoother the later. Creases that shut each other in bend
    a map everywhere, and where the curvature is not heard at all nothing keeps its poles apart."""
    kept = np.where(number == 0, asked.feature & MARK_BIT, 0).astype(np.int8)
    left_out = np.flatnonzero((asked.feature > 0) & (kept == 0))
    left_out = left_out[left_out < working.surface.twin[left_out]]
    chain, _ = chains(working.surface, left_out)
    _, first = np.unique(chain, return_index=True)
    marked = int(np.count_nonzero(asked.feature[left_out[first]] & MARK_BIT))
    return replace(
        asked,
        feature=kept,
        smoothness=min(asked.smoothness + SMOOTHER * number, 1.0),
        dropped=asked.dropped + len(first) - marked,
        unmarked=asked.unmarked + marked,
    )


def least_feature(
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
    tail, head = ends_of(surface.triangles, edges)
    touches = near[tail] | near[head]
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
