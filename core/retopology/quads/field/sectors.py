"""Right angles between features: corners that leave no room for a quad."""

from __future__ import annotations

import numpy as np

from ....mesh.half_edges import previous
from .crosses import QUARTER, Crosses, fans

# Least sine of the angle that quads have in a corner between features: so much a good quad has.
FLAT = 0.6


def sector_turns(crosses: Crosses) -> tuple[np.ndarray, np.ndarray]:
    """Feature half-edges, each the start of a sector anticlockwise around its tail up to the next
    feature, and the quarter turns that quads make in it."""
    first = np.flatnonzero(crosses.feature)
    if not len(first):
        return first, first
    corner, start = fans(crosses.twin, crosses.feature, first)
    total = np.add.reduceat(crosses.corner_angle[corner], start[:-1])
    last = previous(corner[start[1:] - 1])
    # Crossed anticlockwise: the sides by which the corners but the last are left.
    inside = np.ones(len(corner), bool)
    inside[start[1:] - 1] = False
    rest = crosses.rest[previous(corner)]
    rest = np.where(inside, rest, 0.0)
    total += np.add.reduceat(rest, start[:-1])
    # Both ends turn to the axes that they count as.
    total += _off_axis(crosses, first) - _off_axis(crosses, last)
    return first, np.rint(total / QUARTER).astype(np.int64)


def sector_angles(crosses: Crosses, first: np.ndarray) -> np.ndarray:
    """(f,) angles on the surface of the sectors that start at feature half-edges (f,)."""
    if not len(first):
        return np.zeros(0)
    corner, start = fans(crosses.twin, crosses.feature, first)
    total = np.add.reduceat(crosses.corner_angle[corner], start[:-1])
    return np.asarray(total)


def fitting_turns(angle: np.ndarray, turns: np.ndarray, least: np.ndarray) -> np.ndarray:
    """(f,) int64 the quarter turns that sectors of such angles should have: those that they have
    unless their quads would be flat or pointed there."""
    share = angle / np.maximum(turns, 1)
    unfit = (share >= np.pi) | (np.sin(np.minimum(share, np.pi)) < FLAT) | (turns < least)
    best = np.maximum(np.rint(angle / QUARTER).astype(np.int64), 1)
    return np.maximum(np.where(unfit, best, turns), least)


def _off_axis(crosses: Crosses, edge: np.ndarray) -> np.ndarray:
    """Angle of half-edges against the axis that they count as: the nearest, seen from the lower
    half-edge of the two."""
    twin = crosses.twin[edge]
    upper = (twin >= 0) & (twin < edge)
    lower = np.where(upper, twin, edge)
    face, side = lower // 3, lower % 3
    angle = np.angle(crosses.corner[face, (side + 1) % 3] - crosses.corner[face, side])
    off = angle - QUARTER * np.rint(angle / QUARTER)
    return off + np.where(upper, crosses.rest[lower], 0.0)


def least_turns(crosses: Crosses, mirror: np.ndarray) -> np.ndarray:
    """(3 m,) int64 quarter turns that a sector starting at a half-edge must have: two where both
    its ends are borders on the mirror plane, `mirror` (n,) bool, as the image doubles them."""
    least = np.ones(len(crosses.twin), np.int64)
    border = np.flatnonzero(crosses.twin < 0)
    on = mirror[crosses.tail[border]] & mirror[crosses.head[border]]
    arriving = np.zeros(len(crosses.vertices), bool)
    arriving[crosses.head[border[on]]] = True
    both = border[on][arriving[crosses.tail[border[on]]]]
    least[both] = 2
    return least


def shut_corners(crosses: Crosses) -> np.ndarray:
    """(n,) bool vertices with two features that run into each other along one direction, or with
    room for two quads only on both sides of a bend."""
    edge, turns = sector_turns(crosses)
    found = np.zeros(len(crosses.vertices), bool)
    found[crosses.tail[edge[turns < 1]]] = True
    total = np.bincount(crosses.tail[edge], weights=turns, minlength=len(found))
    return found | (crosses.on_feature & ~crosses.border & (total < 3))
