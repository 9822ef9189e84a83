"""The last few bad quads: their vertices are tried in other places on the surface, one by one.

Where a quad bends over an edge of the surface, what it looks like in one plane says little about
its corners; there each vertex takes the best of places around it (after Freitag & Ollivier-Gooch
1997, 10.1002/(SICI)1097-0207(19971115)40:21<3979::AID-NME251>3.0.CO;2-9).
"""

from __future__ import annotations

import numpy as np

from .....base.progress import Progress
from .....base.subsets import places_in
from .....base.unit import unit
from .....mesh.rings import with_rings
from ..guides import Guides, moved_along, vertex_normals
from .mending import oriented_quality, quality_to_mend

# Quads below the first scaled Jacobian are tried; what lacks to the second counts by this power.
# Chosen on a skull (least 0.39 to 0.54); on a sword and a scan of the bunny, where corners that are
# held leave less, 0.24 and 0.30 become 0.40.
BAD, WANTED, POWER = 0.5, 0.7, 4
# Rings around them that move, rounds, directions, and the steps in mean sides, in turn.
RINGS, ROUNDS, DIRECTIONS, STEPS = 1, 48, 8, (0.4, 0.2, 0.1, 0.05)


def worst_opened(
    position: np.ndarray, quads: np.ndarray, guides: Guides, progress: Progress
) -> np.ndarray:
    """Move vertices of bad quads, in place, where that makes the worst around them better. Quads
    that fill a held corner of features are not among them.

    Returns
    -------
    rows:
        (r,) int64 vertices that may have moved.
    """
    none = np.zeros(0, np.int64)
    bad = quality_to_mend(position, quads, guides) < BAD
    if not bad.any():
        return none
    near = np.zeros(len(position), bool)
    near[quads[bad]] = True
    near = with_rings(quads, near, RINGS)
    movable = ~guides.fixed & ((guides.curve < 0) | (guides.beside >= 0).all(axis=1))
    rows = np.flatnonzero(near & movable)
    some = quads[near[quads].any(axis=1)]
    if not len(rows):
        return none
    random = np.random.default_rng(0)
    start = kept = position[rows]
    best = _worth(position, some, guides)
    for number in range(ROUNDS):
        progress.step(number / ROUNDS)
        step = STEPS[number % len(STEPS)]
        apart = _apart(rows, some, len(position), random)
        _tried(position, some, guides, apart, step, random)
        if step == STEPS[-1]:
            # A vertex is judged by its own quads, which can turn what those beside them count as.
            found = _worth(position, some, guides)
            if found > best:
                best, kept = found, position[rows]
            if best[0] >= BAD:
                break
    position[rows] = kept
    return rows[(kept != start).any(axis=1)]


def _worth(position: np.ndarray, quads: np.ndarray, guides: Guides) -> tuple[float, float]:
    """The worst quality, and what all lack together: more is better."""
    quality = quality_to_mend(position, quads, guides)
    lack = float((np.maximum(WANTED - quality, 0.0) ** POWER).sum())
    return float(quality.min()), -lack


def _apart(
    rows: np.ndarray, quads: np.ndarray, count: int, random: np.random.Generator
) -> np.ndarray:
    """Those of the vertices `rows` that come before all others in the same quads, by lot."""
    lot = np.full(count, np.inf)
    lot[rows] = random.random(len(rows))
    first = np.full(count, np.inf)
    np.minimum.at(first, quads.ravel(), np.repeat(lot[quads].min(axis=1), 4))
    return rows[lot[rows] <= first[rows]]


def _tried(
    position: np.ndarray,
    quads: np.ndarray,
    guides: Guides,
    rows: np.ndarray,
    step: float,
    random: np.random.Generator,
) -> None:
    """Each of the vertices `rows`, no two of one quad, to the best of the places around it."""
    of = places_in(rows, len(position))[quads].max(axis=1)
    mine = of >= 0
    around, of = quads[mine], of[mine]
    at = position[around]
    side = np.linalg.norm(np.roll(at, -1, axis=1) - at, axis=2).mean(axis=1)
    length = step * np.bincount(of, side, len(rows)) / np.bincount(of, minlength=len(rows))
    normal = unit(vertex_normals(position, quads)[rows])
    way = random.normal(size=(DIRECTIONS, len(rows), 3))
    way = unit(way - np.einsum("drc,rc->dr", way, normal)[:, :, None] * normal)
    start, every = position[rows], np.tile(rows, DIRECTIONS)
    step_by = (length[:, None] * way).reshape(-1, 3)
    trial = moved_along(np.tile(start, (DIRECTIONS, 1)), step_by, every, position, quads, guides)
    places = np.concatenate([start[None], trial.reshape(DIRECTIONS, -1, 3)])
    best = _lacks(position, around, guides, of, rows, places).argmin(axis=0)
    position[rows] = places[best, np.arange(len(rows))]


def _lacks(
    position: np.ndarray,
    around: np.ndarray,
    guides: Guides,
    of: np.ndarray,
    rows: np.ndarray,
    places: np.ndarray,
) -> np.ndarray:
    """(k, r) what the quads `around` each of the vertices lack with it in the `places` (k, r, 3),
    each by itself: the same quads once for each place, on vertices of their own."""
    used, corner = np.unique(around, return_inverse=True)
    count, n = len(places), len(used)
    at = np.tile(position[used], (count, 1, 1))
    at[:, np.searchsorted(used, rows)] = places
    copies = (corner.reshape(-1, 4) + n * np.arange(count)[:, None, None]).reshape(-1, 4)
    quality = oriented_quality(at.reshape(-1, 3), copies, guides)
    lack = np.maximum(WANTED - quality, 0.0) ** POWER
    mine = (of + len(rows) * np.arange(count)[:, None]).ravel()
    return np.bincount(mine, lack, count * len(rows)).reshape(count, -1)
