"""Closed pieces that are the walls of a cavity: there normals rightly point into the hollow."""

from __future__ import annotations

import numpy as np

from ...base.subsets import spans
from ..surface import Surface

# Where in a triangle it is asked whether it lies within others: at no place of a regular mesh.
_WHERE = np.array([0.4472, 0.3189, 0.2339])
# Pairs of a point and a triangle that are looked at in one go.
_BLOCK = 1 << 20


def cavities(surface: Surface) -> np.ndarray:
    """(components,) bool, True where a closed piece that points inwards lies within others.

    A piece does if the others wind around a point of it once or more: counted where the line from
    there straight up crosses them, outwards for and inwards against.
    """
    found = np.zeros(surface.component_count, bool)
    inward = surface.closed & (surface.volume < 0)
    if not inward.any() or not (surface.closed & (surface.volume > 0)).any():
        return found
    owner = surface.component[surface.triangles[:, 0]]
    normal, area = surface.face_normal_area
    level = normal[:, 2] * area
    # Of each piece the triangle that is largest as seen from above.
    order = np.lexsort((-np.abs(level), owner))
    first = order[np.searchsorted(owner[order], np.flatnonzero(inward))]
    points = _WHERE @ surface.vertices[surface.triangles[first]]
    rows = np.flatnonzero(surface.closed[owner] & (level != 0.0))
    winding = np.zeros(len(points))
    by_x = np.argsort(points[:, 0])
    points, piece = points[by_x], owner[first][by_x]
    across = surface.vertices[surface.triangles[rows], 0]
    low = np.searchsorted(points[:, 0], across.min(axis=1))
    count = np.searchsorted(points[:, 0], across.max(axis=1)) - low
    rows, low, count = (one[count > 0] for one in (rows, low, count))
    start = 0
    while start < len(rows):
        # One triangle at least, and no more pairs than a block but for what it brings.
        total = np.cumsum(count[start : start + _BLOCK])
        stop = start + max(1, int(np.searchsorted(total, _BLOCK)))
        some, many = rows[start:stop], count[start:stop]
        triangle = np.repeat(some, many)
        place = spans(low[start:stop], many)
        apart = owner[triangle] != piece[place]
        triangle, place = triangle[apart], place[apart]
        above = _is_above(surface, triangle, points[place])
        winding += np.bincount(
            place, weights=np.where(above, np.sign(level[triangle]), 0.0), minlength=len(points)
        )
        start = stop
    found[piece] = winding > 0.5
    return found


def _is_above(surface: Surface, triangles: np.ndarray, points: np.ndarray) -> np.ndarray:
    """(k,) bool, whether each of `triangles` (k,) crosses the line up from its point (k, 3)."""
    a, b, c = (
        corner - points for corner in surface.vertices[surface.triangles[triangles]].swapaxes(0, 1)
    )
    weights = np.array([_cross(b, c), _cross(c, a), _cross(a, b)])
    inside = (weights > 0).all(axis=0) | (weights < 0).all(axis=0)
    height = np.einsum("ck,ck->k", weights, np.array([a[:, 2], b[:, 2], c[:, 2]]))
    return inside & (height * weights.sum(axis=0) > 0)


def _cross(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    return one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]
