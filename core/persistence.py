"""Which umbilics are really there: persistence by cancelling charges in the merge tree.

After Wang & Hotz, Robustness for 2D symmetric tensor field topology (2017). Every umbilic
is a node of value 0 joined to the corners of its triangle; sublevel sets of the gap k1 - k2
grow over the edges of the mesh. Where two of them merge whose umbilics left over have indices
of opposite sign, the closest opposite pairs cancel at that gap until one sign is left. The sum
of the indices is therefore the same at every level.

The tree is contracted before anything is walked in Python: vertices run down to the minimum
below them, and a basin without an umbilic joins the basin across its lowest pass, which is
where the sublevel sets would join it and where nothing can cancel.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from .surface import Surface
from .tolerances import PAIR_CROWD, PAIR_NOISE

# Fewer candidates than this are compared faster without arrays.
_FEW = 24


def measure_persistence(
    surface: Surface,
    gap: np.ndarray,
    triangle: np.ndarray,
    index: np.ndarray,
    regions: Sequence[np.ndarray] = (),
) -> tuple[np.ndarray, np.ndarray]:
    """The gap at which each umbilic cancels, and with which other one.

    Parameters
    ----------
    surface:
        The mesh; separate components never cancel each other's umbilics.
    gap:
        (n,) k1 - k2 at the vertices, >= 0. What is not finite counts as the largest finite gap.
    triangle:
        (k,) rows of `surface.triangles` that hold the umbilics.
    index:
        (k,) their indices, multiples of one half.
    regions:
        For each spherical or flat region the rows of its triangles. The gap is zero all over a
        region, so that umbilics at its border meet through it; its own index is not offered
        for cancelling, because a region is never removed.

    Returns
    -------
    persistence:
        (k,) float64 gap, in the unit of `gap`; infinite where nothing is left to cancel with.
        Umbilics of a larger index may cancel with several others: these then share the
        persistence at which the last of them goes.
    partner:
        (k,) int64 row of the umbilic that it cancels with, -1 where the persistence is infinite.
    """
    count = len(index)
    persistence = np.full(count, np.inf)
    partner = np.full(count, -1, dtype=np.int64)
    units = np.rint(2.0 * np.asarray(index, dtype=float)).astype(np.int64)
    if not (units > 0).any() or not (units < 0).any():
        return persistence, partner

    gap = _finite(gap)
    low, high, saddle = _tree(surface, gap, np.asarray(triangle), units != 0, regions)
    centres = surface.vertices[surface.triangles[triangle]].mean(axis=1)
    first, second, level = _cancel(units.copy(), centres, low, high, saddle)
    if len(first) == 0:
        return persistence, partner
    if np.abs(units).max() == 1:
        persistence[first] = persistence[second] = level
        partner[first], partner[second] = second, first
        return persistence, partner
    return _group(units, first, second, level)


def survivors(persistence: np.ndarray, level: float) -> np.ndarray:
    """(k,) bool, True where an umbilic is kept at a persistence level; 0 keeps all."""
    return persistence >= level


def made_by_noise(
    persistence: np.ndarray, partner: np.ndarray, noise: np.ndarray
) -> np.ndarray:
    """(k,) bool, True for the umbilics that come in pairs made by noise: the automatic choice.

    A pair is noise where it cancels below `noise_multiple` times the gap's standard error, the
    lesser one of its places: a pair of one clear umbilic and one at a ragged border is the
    clear one's. Noise differs over a mesh, so that each pair is judged by itself.

    Parameters
    ----------
    persistence, partner:
        (k,) as `measure_persistence` gives them. Umbilics that cancel together go together;
        those with a persistence of NaN or infinity stay.
    noise:
        (k,) standard error of the gap at each umbilic, in the unit of `persistence`; NaN where
        it is not known.
    """
    count = len(persistence)
    paired = np.flatnonzero(partner >= 0)
    links = sparse.coo_matrix((np.ones(len(paired)), (paired, partner[paired])), (count, count))
    groups, group = csgraph.connected_components(links, directed=False)
    lesser = np.full(groups, np.inf)
    np.fmin.at(lesser, group, noise)
    # Nothing known of any of them: keep them.
    lesser[~np.isfinite(lesser)] = -np.inf
    with np.errstate(invalid="ignore"):
        below = persistence <= noise_multiple(count) * lesser[group]
    return np.isfinite(persistence) & below


def noise_multiple(count: int) -> float:
    """How many standard errors a pair must rise above to be told from noise, among `count`
    umbilics: the more there are, the higher the highest that noise makes.

    The largest of n normal deviates grows as sqrt(log n) (Donoho & Johnstone 1994).
    """
    crowd = np.log(max(count, PAIR_CROWD)) / np.log(PAIR_CROWD)
    return PAIR_NOISE * float(np.sqrt(crowd))


def trust_ratio(noise: np.ndarray, gap: np.ndarray) -> float:
    """How strong the noise is: the gap at which it makes pairs cancel over the median gap.

    Up to about 0.5 the umbilics left sit where the surface has them; above 0.7 the noise that
    was cancelled is as large as the signal and they may not. The medians keep a few damaged
    places from speaking for the whole mesh.

    Parameters
    ----------
    noise, gap:
        (n,) standard error of the gap k1 - k2 at the vertices, and the gap. 0 is returned where
        the noise is not known.
    """
    known = np.isfinite(noise) & np.isfinite(gap)
    if not known.any():
        return 0.0
    cancels, median = PAIR_NOISE * float(np.median(noise[known])), float(np.median(gap[known]))
    return cancels / median if cancels < 1e6 * median else 0.0


def _finite(gap: np.ndarray) -> np.ndarray:
    gap = np.asarray(gap, dtype=float)
    finite = np.isfinite(gap)
    if finite.all():
        return gap
    return np.where(finite, gap, gap[finite].max() if finite.any() else 0.0)


def _tree(
    surface: Surface,
    gap: np.ndarray,
    triangle: np.ndarray,
    charged: np.ndarray,
    regions: Sequence[np.ndarray],
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The merge tree of the umbilics: rows of both and gap at the pass, lowest pass first."""
    count, vertices = len(triangle), len(gap)
    # Ranks instead of gaps: a strict order, in which equal gaps make no cycles.
    order = np.argsort(gap, kind="stable").astype(np.int32)
    rank = np.empty(vertices, dtype=np.int32)
    rank[order] = np.arange(vertices, dtype=np.int32)

    # Seeds have value 0, below everything: umbilics first, then regions.
    corners = [surface.triangles[triangle].ravel()]
    seeds = [np.repeat(np.arange(count), 3)]
    for number, rows in enumerate(regions):
        inside = np.unique(surface.triangles[rows])
        corners.append(inside)
        seeds.append(np.full(len(inside), count + number))
    corner, seed = np.concatenate(corners), np.concatenate(seeds)
    seed_node = (seed + vertices).astype(np.int32)

    around = rank[surface.neighbours]
    lowest = np.minimum.reduceat(around, surface.neighbour_start[:-1])
    below = np.arange(vertices + count + len(regions), dtype=np.int32)
    below[:vertices] = np.where(lowest < rank, order[lowest], below[:vertices])
    below[corner] = seed_node
    basin, basins = _label(below)

    mine = np.repeat(basin[:vertices], np.diff(surface.neighbour_start))
    other = basin[surface.neighbours]
    crossing = np.flatnonzero(mine < other)
    owner = np.repeat(np.arange(vertices, dtype=np.int32), np.diff(surface.neighbour_start))
    first = np.concatenate([mine[crossing], basin[corner]])
    second = np.concatenate([other[crossing], basin[seed_node]])
    weight = np.concatenate([np.maximum(rank[owner[crossing]], around[crossing]), rank[corner]])
    different = first != second
    first, second, weight = first[different], second[different], weight[different]
    # Sorting keys is several times faster than sorting places, and as strict.
    key = np.sort(weight.astype(np.int64) << 32 | np.arange(len(weight)))
    ascending = key & 0xFFFFFFFF
    first, second, weight = first[ascending], second[ascending], weight[ascending]

    umbilic = basin[vertices : vertices + count]
    neutral = np.ones(basins, dtype=bool)
    neutral[umbilic[charged]] = False
    row = np.full(basins, -1)
    row[umbilic] = np.arange(count)
    while True:
        hook, _ = _lowest_pass(first, second, neutral)
        if hook is None:
            break
        basin, basins = _label(hook)
        first, second = basin[first], basin[second]
        kept = first != second
        first, second, weight = first[kept], second[kept], weight[kept]
        # A basin that takes neutral ones up keeps its umbilic.
        held, was = np.flatnonzero(~neutral), row
        neutral, row = np.ones(basins, dtype=bool), np.full(basins, -1)
        neutral[basin[held]] = False
        row[basin[held]] = was[held]

    # Only umbilics are left. The same steps, all of them hooking, give the spanning tree.
    low, high = row[first], row[second]
    edge = np.arange(len(first))
    tree = []
    while len(first):
        hook, used = _lowest_pass(first, second, np.ones(basins, dtype=bool))
        tree.append(edge[used])
        basin, basins = _label(hook)
        first, second = basin[first], basin[second]
        kept = first != second
        first, second, edge = first[kept], second[kept], edge[kept]
    chosen = np.unique(np.concatenate(tree)) if tree else np.empty(0, dtype=np.int64)
    return low[chosen], high[chosen], gap[order[weight[chosen]]]


def _label(below: np.ndarray) -> tuple[np.ndarray, int]:
    """Number the roots of a forest of pointers; each node's root number, and how many."""
    while True:
        further = below[below]
        if np.array_equal(further, below):
            break
        below = further
    root = below == np.arange(len(below), dtype=below.dtype)
    number = np.cumsum(root, dtype=np.int32) - 1
    return number[below], int(number[-1]) + 1


def _lowest_pass(
    first: np.ndarray, second: np.ndarray, hooking: np.ndarray
) -> tuple[np.ndarray | None, np.ndarray]:
    """Where the hooking nodes go over their lowest edge (Borůvka 1926); edges lowest first.

    Returns the pointers, None where no hooking node has an edge, and the edges used.
    """
    none = len(first)
    edge = np.full(len(hooking), none)
    # Of several values written to one place the last one stays.
    backwards = np.arange(none)[::-1]
    edge[second[::-1]] = backwards
    other = np.full(len(hooking), none)
    other[first[::-1]] = backwards
    edge = np.minimum(edge, other)
    moving = np.flatnonzero(hooking & (edge < none))
    hook = np.arange(len(hooking), dtype=np.int32)
    if len(moving) == 0:
        return None, moving
    used = edge[moving]
    hook[moving] = first[used] + second[used] - moving
    # Two nodes may choose each other: one of them stays.
    mutual = moving[(hook[hook[moving]] == moving) & (moving < hook[moving])]
    hook[mutual] = mutual
    return hook, used


def _cancel(
    units: np.ndarray,
    centres: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    saddle: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Walk up the tree; the pairs that cancel and the gap at which they do."""
    charge = units.tolist()
    place = centres.tolist()
    root = list(range(len(charge)))
    left = [[row] for row in range(len(charge))]
    # Places of those in a long list, in the same order: made once, then kept up to date.
    crowd: dict[int, np.ndarray] = {}
    first: list[int] = []
    second: list[int] = []
    level: list[float] = []
    for one, two, gap in zip(low.tolist(), high.tolist(), saddle.tolist(), strict=True):
        while root[one] != one:
            root[one] = one = root[root[one]]
        while root[two] != two:
            root[two] = two = root[root[two]]
        mine, yours = left[one], left[two]
        if len(mine) < len(yours):
            one, two, mine, yours = two, one, yours, mine
        root[two] = one
        left[two] = []
        crowd.pop(two, None)
        ours = crowd.get(one)
        if yours and (charge[mine[0]] > 0) != (charge[yours[0]] > 0):
            while mine and yours:
                if ours is None and len(mine) > _FEW:
                    ours = crowd[one] = centres[mine]
                i, j = _closest(mine, yours, place, ours)
                first.append(mine[i])
                second.append(yours[j])
                level.append(gap)
                if _spend(charge, mine, i, yours, j) and ours is not None:
                    ours[i] = ours[len(mine)]
        if ours is not None and yours:
            count = len(mine) + len(yours)
            if count > len(ours):
                ours = crowd[one] = np.concatenate([ours[: len(mine)], np.empty((count, 3))])
            ours[len(mine) : count] = centres[yours]
        mine.extend(yours)
    return np.array(first, dtype=np.int64), np.array(second, dtype=np.int64), np.array(level)


def _closest(
    mine: list[int], yours: list[int], place: list[list[float]], ours: np.ndarray | None
) -> tuple[int, int]:
    """Places in both lists of the two umbilics closest to each other.

    `ours` begins with the places of the first list where that is a long one.
    """
    if len(mine) == 1 and len(yours) == 1:
        return 0, 0
    nearest, first, second = np.inf, 0, 0
    if ours is None:
        for j, two in enumerate(yours):
            u, v, w = place[two]
            for i, one in enumerate(mine):
                x, y, z = place[one]
                distance = (x - u) * (x - u) + (y - v) * (y - v) + (z - w) * (z - w)
                if distance < nearest:
                    nearest, first, second = distance, i, j
        return first, second
    # The longer list at once, the shorter one in turn: the memory stays small.
    for j, two in enumerate(yours):
        away = ours[: len(mine)] - place[two]
        distance = np.einsum("ij,ij->i", away, away)
        i = int(distance.argmin())
        if distance[i] < nearest:
            nearest, first, second = float(distance[i]), i, j
    return first, second


def _spend(charge: list[int], mine: list[int], i: int, yours: list[int], j: int) -> bool:
    """Cancel as much of two opposite charges as both have; what is used up leaves its list, in
    which the last takes its place. True if one left the first list.
    """
    one, two = mine[i], yours[j]
    spent = min(abs(charge[one]), abs(charge[two]))
    charge[one] -= spent if charge[one] > 0 else -spent
    charge[two] -= spent if charge[two] > 0 else -spent
    used_up = charge[one] == 0
    if used_up:
        mine[i] = mine[-1]
        mine.pop()
    if charge[two] == 0:
        yours[j] = yours[-1]
        yours.pop()
    return used_up


def _group(
    units: np.ndarray, first: np.ndarray, second: np.ndarray, level: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Persistence where larger indices cancel with several others.

    Those that are linked go together, at their highest level, or stay together if their sum
    is not zero; anything else would change the sum of what is left.
    """
    count = len(units)
    links = sparse.coo_matrix((np.ones(len(first)), (first, second)), shape=(count, count))
    groups, group = csgraph.connected_components(links, directed=False)
    highest = np.zeros(groups)
    np.maximum.at(highest, group[first], level)
    total = np.bincount(group, weights=units, minlength=groups)
    # An umbilic without a link is a group of its own, with a sum of its own index.
    linked = np.bincount(group[first], minlength=groups) > 0
    highest[(total != 0) | ~linked] = np.inf
    persistence = highest[group]
    partner = np.full(count, -1, dtype=np.int64)
    # Each link uses one of its ends up, whose last link it is: kept there, it holds the group
    # together.
    partner[np.stack([first, second], axis=1)] = np.stack([second, first], axis=1)
    partner[~np.isfinite(persistence)] = -1
    return persistence, partner
