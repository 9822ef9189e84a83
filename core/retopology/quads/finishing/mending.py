"""Opening folded quads: each of their vertices goes where its worst quad is best.

A search by trial in the plane of the surface, for the few quads that evening out leaves bad
(optimization-based smoothing: Freitag & Ollivier-Gooch 1997,
10.1002/(SICI)1097-0207(19971115)40:21<3979::AID-NME251>3.0.CO;2-9).
"""

from __future__ import annotations

import numpy as np

from ....base.progress import Progress
from ..conformity import scaled_jacobian
from .guides import Guides, on_curve, vertex_normals

# A quad is well enough above this least sine at its corners.
SOUND = 0.5
# What a quad misses of this counts in a move, and what a move must gain.
WANTED, GAIN = 0.7, 1e-4
# A side shorter than this part of the longest counts as none.
LEAST_SIDE = 0.03
# Rounds, and tries in each: so many directions at each of these parts of an edge.
ROUNDS, DIRECTIONS = 60, 8
REACHES = (0.6, 0.3, 0.12, 0.05, 0.015)


def mend(position: np.ndarray, quads: np.ndarray, guides: Guides, progress: Progress) -> None:
    """Move vertices of bad quads, in place, while that makes their worst quads better."""
    movable = ~guides.fixed
    corner = np.argsort(quads.ravel(), kind="stable")
    start = np.concatenate([[0], np.cumsum(np.bincount(quads.ravel(), minlength=len(position)))])
    tired = np.zeros(len(position), np.int64)
    for turn in range(ROUNDS):
        progress.step(1.0)
        quality = oriented_quality(position, quads, guides)
        bad = quality < SOUND
        if not bad.any():
            return
        at = np.unique(quads[bad])
        at = at[movable[at] & (tired[at] <= turn)]
        worst = np.array([quality[corner[start[v] : start[v + 1]] // 4].min() for v in at])
        chosen = _apart(at[np.argsort(worst, kind="stable")], quads, corner, start)
        if not len(chosen):
            return
        moved = _search(chosen, position, quads, guides, corner, start)
        # Who has found nothing better rests, until others have moved.
        tired[chosen[~moved]] = turn + 3
        if not moved.any() and (tired[at] > turn).all():
            return


def oriented_quality(position: np.ndarray, quads: np.ndarray, guides: Guides) -> np.ndarray:
    """(q,) scaled Jacobians, negative where a quad faces against the surface."""
    at = position[quads]
    normal = np.cross(at[:, 2] - at[:, 0], at[:, 3] - at[:, 1])
    around = vertex_normals(position, quads)[quads].sum(axis=1)
    triangle, _ = guides.surface(at.mean(axis=1), around)
    against = np.einsum("qc,qc->q", guides.surface.normal[triangle], normal) < 0.0
    quality = scaled_jacobian(position, quads)
    return np.where(against, -np.abs(quality) - 1e-6, quality)


def _apart(
    order: np.ndarray, quads: np.ndarray, corner: np.ndarray, start: np.ndarray
) -> np.ndarray:
    """Of vertices in this order, those that share no quad with an earlier one."""
    taken: set[int] = set()
    chosen = []
    for vertex in order.tolist():
        mine = set((corner[start[vertex] : start[vertex + 1]] // 4).tolist())
        if not mine & taken:
            taken |= mine
            chosen.append(vertex)
    return np.array(chosen, np.int64)


def _search(
    chosen: np.ndarray,
    position: np.ndarray,
    quads: np.ndarray,
    guides: Guides,
    corner: np.ndarray,
    start: np.ndarray,
) -> np.ndarray:
    """Move each of the vertices to its best try, in place; which of them (c,) bool have moved."""
    normal = vertex_normals(position, quads)[chosen]
    normal /= np.maximum(np.linalg.norm(normal, axis=1), np.finfo(float).tiny)[:, None]
    moved = np.zeros(len(chosen), bool)
    tries, owner = [], []
    for row, vertex in enumerate(chosen.tolist()):
        around = quads[corner[start[vertex] : start[vertex + 1]] // 4]
        reach = np.linalg.norm(position[around] - position[vertex], axis=2).max()
        x = np.cross(normal[row], np.eye(3)[np.abs(normal[row]).argmin()])
        x /= max(np.linalg.norm(x), np.finfo(float).tiny)
        y = np.cross(normal[row], x)
        angle = np.arange(DIRECTIONS) * (2.0 * np.pi / DIRECTIONS)
        ring = np.cos(angle)[:, None] * x + np.sin(angle)[:, None] * y
        # Also the middle of what is around.
        middle = position[around].reshape(-1, 3).mean(axis=0)
        points = position[vertex] + reach * np.concatenate([part * ring for part in REACHES])
        points = np.concatenate([points, middle[None]])
        if guides.curve[vertex] >= 0:
            points = on_curve(points, *guides.curves[int(guides.curve[vertex])])
        tries.append(points)
        owner.append(np.full(len(points), row))
    points, owner = np.concatenate(tries), np.concatenate(owner)
    loose = guides.curve[chosen[owner]] < 0
    points[loose] = guides.surface(points[loose], normal[owner[loose]])[1]
    for row, vertex in enumerate(chosen.tolist()):
        mine = points[owner == row]
        around = quads[corner[start[vertex] : start[vertex + 1]] // 4]
        before = _wanting(
            position[around][None], around == vertex, position[vertex][None], normal[row]
        )
        after = _wanting(
            np.broadcast_to(position[around], (len(mine), *around.shape, 3)),
            around == vertex,
            mine,
            normal[row],
        )
        best = int(after.argmin())
        if after[best] < before[0] - GAIN:
            position[vertex] = mine[best]
            moved[row] = True
    return moved


def _wanting(
    around: np.ndarray, here: np.ndarray, points: np.ndarray, normal: np.ndarray
) -> np.ndarray:
    """(t,) what is wanting in the quality of the quads (t, k, 4, 3), squared and summed, with a
    vertex, where `here` (k, 4) says, put at points (t, 3)."""
    at = np.where(here[None, :, :, None], points[:, None, None, :], around)
    count, quads = at.shape[:2]
    flat = at.reshape(-1, 3)
    quality = scaled_jacobian(flat, np.arange(len(flat)).reshape(-1, 4))
    area = np.cross(at[:, :, 2] - at[:, :, 0], at[:, :, 3] - at[:, :, 1]) @ normal
    quality = quality.reshape(count, quads)
    quality = np.where(area < 0.0, -np.abs(quality) - 1e-6, quality)
    # Corners that fall together are no way out.
    side = np.linalg.norm(np.roll(at, -1, axis=2) - at, axis=3)
    flat_side = side.min(axis=2) < LEAST_SIDE * side.max(axis=2)
    quality = np.where(flat_side, np.minimum(quality, -1.0), quality)
    return (np.maximum(WANTED - quality, 0.0) ** 2).sum(axis=1)
