"""Pins and deletions: what the user says of single umbilics, and how a new detection keeps it."""

from __future__ import annotations

import bpy
import numpy as np

from . import summary
from .record import Record

# The properties of `summary.UMBILICS_PG_summary` that hold rows of candidates.
LISTS = ("pinned", "deleted")
# An umbilic is the one from before if it is no further away than this many edges.
_REACH = 4.0


def rows(obj: bpy.types.Object) -> tuple[list[int], list[int]]:
    """Rows of the candidates that are pinned and that are deleted."""
    pinned, deleted = (summary.rows_of(getattr(obj.umbilics, name)) for name in LISTS)
    return pinned, deleted


def carry_over(
    obj: bpy.types.Object,
    chosen: tuple[list[int], list[int]],
    before: Record | None,
    after: Record,
) -> int:
    """Pin and delete in a new detection what was pinned and deleted in the one before.

    `chosen` is what `rows` gave before, and `before` is None where it cannot be read any more.
    The answer is how many of them have no umbilic of their index near their old place now.
    """
    if before is None:
        return len({row for part in chosen for row in part})
    carried, lost = counterparts(chosen, before, after)
    for name, part in zip(LISTS, carried, strict=True):
        setattr(obj.umbilics, name, summary.text_of(part))
    return lost


def counterparts(
    chosen: tuple[list[int], list[int]], before: Record, after: Record
) -> tuple[tuple[list[int], list[int]], int]:
    """Rows pinned and rows deleted in another detection of the object, and how many are lost."""
    old = np.array(sorted({row for part in chosen for row in part}), dtype=int)
    old = old[old < len(before.detection.candidates)]
    new = dict(zip(old.tolist(), _counterparts(before, after, old).tolist(), strict=True))
    pinned, deleted = ([new[row] for row in part if new.get(row, -1) >= 0] for part in chosen)
    return (pinned, deleted), sum(row < 0 for row in new.values())


def _counterparts(before: Record, after: Record, old: np.ndarray) -> np.ndarray:
    """(p,) for each candidate `old` (p,) the nearest new one of its index, else -1.

    Places are compared on the object, which may have been moved or scaled in between. No new
    candidate stands for two old ones: the closest pairs are matched first.
    """
    then, now = before.detection.candidates, after.detection.candidates
    moved = after.matrix @ np.linalg.inv(before.matrix)
    places = then.position[old] @ moved[:3, :3].T + moved[:3, 3]
    grown = abs(np.linalg.det(moved[:3, :3])) ** (1.0 / 3.0)
    match = np.full(len(old), -1)
    pairs = []
    for place, row in enumerate(old.tolist()):
        distance = np.linalg.norm(now.position - places[place], axis=1)
        reach = _REACH * np.maximum(after.edge, grown * before.edge[row])
        for near in np.flatnonzero((now.index == then.index[row]) & (distance <= reach)).tolist():
            pairs.append((distance[near], place, near))
    taken = set()
    for _, place, near in sorted(pairs):
        if match[place] < 0 and near not in taken:
            match[place] = near
            taken.add(near)
    return match
