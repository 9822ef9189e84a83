"""Quads that fold wherever they are put on their surface: unfolded in space, beside it.

Parts thinner than a quad, and corners sharper than quads can turn, leave no room on the surface.
Each quad is seen there in the plane that the quads around have as a mean, whatever lies below, and
its vertices move in all three directions; after that they go back to the surface as far as nothing
folds by it.
"""

from __future__ import annotations

import numpy as np

from .....base.progress import Progress
from .....base.subsets import places_in
from .....base.unit import unit
from .....mesh.rings import with_rings
from ...conformity import conformity, scaled_jacobian, signed
from ..guides import Guides, beside, on_curve, vertex_normals
from ..opening import Opening
from .mending import against

# Rings around folded quads that move, how much a move costs beside a corner that misses all, and
# how often the normals of the quads around are averaged, in one attempt after the other; from the
# given one on creases do not hold their vertices.
RINGS, AVERAGED = (1, 2, 3, 5, 8, 12), (0, 1, 1, 2, 3, 5)
STAY = (0.1, 0.03, 0.01, 0.003, 0.001, 0.0003)
CREASES_GIVE = 3
# Rounds of each attempt, and the sine up to which corners are opened.
ROUNDS, WANTED = 6, 0.7
# Scaled Jacobian below which quads are unfolded, and that going back to the surface leaves them.
FOLDED, KEPT = 0.03, 0.15
# Parts of the way back to the surface that are tried, one after the other.
BACK = (1.0, 0.5, 0.5, 0.25)
# Rounds in which vertices whose quads would fold stay.
STAYING = 8


def unfolded(
    position: np.ndarray, quads: np.ndarray, guides: Guides, progress: Progress
) -> np.ndarray:
    """Positions (n, 3) of which no quad is folded, where that was found; off the surface where
    it cannot be on it."""
    found = _attempts(position, quads, guides, progress, len(RINGS), False)
    if against(found, quads, guides.surface).any():
        trial = _attempts(found, quads, guides, progress, CREASES_GIVE, True)
        if _worth(trial, quads, guides) < _worth(found, quads, guides):
            found = trial
    return found


def locally_unfolded(
    position: np.ndarray, quads: np.ndarray, guides: Guides, progress: Progress
) -> np.ndarray:
    """As `unfolded`, by the attempts that hold what guides hold."""
    return _attempts(position, quads, guides, progress, CREASES_GIVE, True)


def _attempts(
    start: np.ndarray,
    quads: np.ndarray,
    guides: Guides,
    progress: Progress,
    attempts: int,
    facing: bool,
) -> np.ndarray:
    """Positions after so many attempts at most; `facing` says whether quads are unfolded as well
    that face against the surface. These are seen as the quads beside them are: with their own
    normals among those they would stay as they are."""
    position = start.copy()
    borders = conformity(quads, len(position)).border
    for number in range(attempts):
        held = guides.fixed | (guides.curve >= 0) if number < CREASES_GIVE else borders
        for _ in range(ROUNDS):
            progress.step(number / len(RINGS))
            up = _around(position, quads, AVERAGED[number])
            bad = own_quality(position, quads) < FOLDED
            if facing:
                turned = against(position, quads, guides.surface)
                up[turned] = unit(beside(position, quads)[turned])
                bad |= turned
            if not bad.any():
                return _on_surface(position, start, quads, guides)
            near = np.zeros(len(position), bool)
            near[quads[bad]] = True
            near = with_rings(quads, near, RINGS[number])
            rows = np.flatnonzero(near & ~held)
            if not len(rows):
                break
            mine = np.flatnonzero(near[quads].any(axis=1))
            local = places_in(rows, len(position))[quads[mine]]
            axes = np.broadcast_to(np.eye(3), (len(rows), 3, 3))
            stay = STAY[number]
            step = Opening(position[quads[mine]], up[mine], local, axes, stay, WANTED).step()
            position[rows] += step
    if (own_quality(position, quads) <= 0.0).any() and not fewer(position, start, quads):
        return start
    return _on_surface(position, start, quads, guides)


def _worth(position: np.ndarray, quads: np.ndarray, guides: Guides) -> tuple[int, int]:
    """How many quads are folded, and how many face against the surface: less is better."""
    folded = int(np.count_nonzero(own_quality(position, quads) <= 0.0))
    return folded, int(np.count_nonzero(against(position, quads, guides.surface)))


def fewer(position: np.ndarray, before: np.ndarray, quads: np.ndarray) -> bool:
    """Whether fewer quads are folded than before."""
    now, then = (np.count_nonzero(own_quality(at, quads) <= 0.0) for at in (position, before))
    return bool(now < then)


def own_quality(position: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """(q,) scaled Jacobians, negative where a quad faces against those around."""
    up = _around(position, quads, 0)
    at = position[quads]
    normal = np.cross(at[:, 2] - at[:, 0], at[:, 3] - at[:, 1])
    turned = np.einsum("qc,qc->q", normal, up) < 0.0
    quality = scaled_jacobian(position, quads)
    return signed(quality, turned)


def _around(position: np.ndarray, quads: np.ndarray, averaged: int) -> np.ndarray:
    """(q, 3) unit mean of the normals of the quads around each."""
    flat = quads.ravel()
    normal = vertex_normals(position, quads)
    for _ in range(averaged):
        mean = unit(normal)[quads].sum(axis=1)
        total = [
            np.bincount(flat, np.repeat(mean[:, k], 4), minlength=len(position)) for k in range(3)
        ]
        normal = np.stack(total, axis=1)
    return unit(unit(normal)[quads].sum(axis=1))


def _on_surface(
    position: np.ndarray, start: np.ndarray, quads: np.ndarray, guides: Guides
) -> np.ndarray:
    """Positions as near to the surface, and to their creases, as no quad folds by it."""
    moved = (position != start).any(axis=1)
    if not moved.any():
        return position
    back = moved & guides.fixed
    return laid_on(position, moved, quads, guides, np.where(back[:, None], start, np.nan))


def laid_on(
    position: np.ndarray,
    moving: np.ndarray,
    quads: np.ndarray,
    guides: Guides,
    places: np.ndarray | None = None,
) -> np.ndarray:
    """Positions of which those `moving` (n,) bool are as near to the surface as no quad folds by
    it, those on curves to these, those with one of the `places` (n, 3) to that."""
    rows = np.flatnonzero(moving)
    for part in BACK:
        goal = position.copy()
        normals = vertex_normals(position, quads)[rows]
        goal[rows] = guides.surface(position[rows], normals)[1]
        on = rows[guides.curve[rows] >= 0]
        for curve in np.unique(guides.curve[on]).tolist():
            mine = on[guides.curve[on] == curve]
            goal[mine] = on_curve(position[mine], *guides.curves[curve])
        if places is not None:
            goal = np.where(np.isnan(places), goal, places)
        before = np.minimum(own_quality(position, quads), KEPT)
        facing = ~against(position, quads, guides.surface)
        going = moving.copy()
        for _ in range(STAYING):
            trial = np.where(going[:, None], position + part * (goal - position), position)
            worse = own_quality(trial, quads) < before
            worse |= facing & against(trial, quads, guides.surface)
            stopped = to_stop(worse, going, quads)
            if not stopped.any():
                position = trial
                break
            going &= ~stopped
    return position


def to_stop(worse: np.ndarray, going: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """(n,) bool the vertices that are `going` (n,) bool and make quads `worse` (q,) bool: corners
    of these or, where those stay, of the quads around, which tell whether a quad is folded."""
    stopped = np.zeros(len(going), bool)
    stopped[quads[worse]] = True
    others = np.zeros(len(going), bool)
    others[quads[worse & ~going[quads].any(axis=1)]] = True
    return (stopped | with_rings(quads, others, 1)) & going
