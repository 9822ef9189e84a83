"""Straight walks through a seamless map, many at once."""

from __future__ import annotations

import numpy as np

from ....mesh.half_edges import following
from ..field.crosses import TURNS
from .seamless_map import SeamlessMap

# A place counts as inside a triangle down to this barycentric weight.
INSIDE = 1e-9


def barycentric(map_: SeamlessMap, triangle: np.ndarray, place: np.ndarray) -> np.ndarray:
    """(p, 3) barycentric weights of places (p,) complex in triangles (p,)."""
    corner = map_.place[triangle]
    side = np.roll(corner, 1, axis=1) - np.roll(corner, -1, axis=1)
    from_place = place[:, None] - np.roll(corner, -1, axis=1)
    double = (side.conj() * from_place).imag
    return double / double.sum(axis=1, keepdims=True)


def walk(
    map_: SeamlessMap, triangle: np.ndarray, start: np.ndarray, step: np.ndarray, most: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Where straight steps (p,) complex end that start at places (p,) in triangles (p,).

    Returns
    -------
    triangle, place, turn, arrived:
        (p,) the last triangles, the places in their coordinates, the quarter turns from the
        coordinates of the first triangle to those, and whether the walk got there within `most`
        triangles and without meeting a border.
    """
    triangle, place = triangle.copy(), start.copy()
    goal, turn = start + step, np.zeros(len(start), np.int64)
    entry = np.full(len(start), -1)
    arrived = np.zeros(len(start), bool)
    active = np.arange(len(start))
    for _ in range(most):
        if not len(active):
            break
        weight = barycentric(map_, triangle[active], goal[active])
        inside = weight.min(axis=1) >= -INSIDE
        arrived[active[inside]] = True
        active, weight = active[~inside], weight[~inside]
        if not len(active):
            break
        here = barycentric(map_, triangle[active], place[active])
        # Side k lies across from corner k + 2.
        there, here = np.roll(weight, 1, axis=1), np.roll(here, 1, axis=1)
        fall = here - there
        share = np.where(fall > 0, np.maximum(here, 0.0) / np.where(fall > 0, fall, 1.0), 0.0)
        open_ = (there < 0) & (np.arange(3) != entry[active][:, None])
        share = np.where(open_, share, np.inf)
        side = share.argmin(axis=1)
        least = share[np.arange(len(active)), side]
        edge = 3 * triangle[active] + side
        other = map_.crosses.twin[edge]
        going = np.isfinite(least) & (other >= 0)
        active, side, least = active[going], side[going], np.minimum(least[going], 1.0)
        edge, other = edge[going], other[going]
        meeting = place[active] + least * (goal[active] - place[active])
        by = map_.seams.matching[edge]
        origin = map_.place[triangle[active], side]
        end = following(other)
        image = map_.place[end // 3, end % 3]
        place[active] = TURNS[by] * (meeting - origin) + image
        goal[active] = TURNS[by] * (goal[active] - origin) + image
        turn[active] = (turn[active] + by) % 4
        triangle[active] = other // 3
        entry[active] = other % 3
    return triangle, goal, turn, arrived
