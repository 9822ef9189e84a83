"""Right angles between features: corners that leave no room for a quad."""

from __future__ import annotations

import heapq

import numpy as np

from ....base.unit import unit
from ....mesh.half_edges import previous
from .crosses import QUARTER, Crosses, fans

# Least sine of the angle that quads have in a corner between features: so much a good quad has.
FLAT = 0.6
# How far a corner may be off its whole number of right angles, in right angles, before the nearest
# is taken: the field decides between two that are nearly as good.
OFF = 0.75
# How far along features their corners are looked at, in lengths of quads, and steps for it.
LOOKED, MOST_STEPS = 0.5, 200
# Opposite bends of a feature nearer than this, in lengths of quads, are jags: no quad lies between.
# As near opposite poles cancel. Found on the torn borders of a bunny, confirmed on a torso.
JAG = 1.0


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
    """(f,) angles on the surface of the sectors that start at feature half-edges (f,).

    Where one feature only passes, and is straight seen from half a quad away to both sides, that
    is the angle: the jags of a torn border or of a crease on a rough surface are no corners. Where
    it bends as a whole, jags are what bends it to one side and back within a quad.
    """
    if not len(first):
        return np.zeros(0)
    corner, start = fans(crosses.twin, crosses.feature, first)
    total: np.ndarray = np.add.reduceat(crosses.corner_angle[corner], start[:-1])
    vertex = crosses.tail[first]
    last = previous(corner[start[1:] - 1])
    far = _Chains(crosses)
    passing = np.flatnonzero(far.passed[vertex])
    vertex, ahead, behind = (
        vertex[passing],
        crosses.head[first[passing]],
        crosses.tail[last[passing]],
    )
    size = LOOKED * crosses.size[first[passing] // 3]
    at = crosses.vertices[vertex]
    out, back = far.point(vertex, ahead, size) - at, far.point(vertex, behind, size) - at
    normal = _normals(crosses)[vertex]
    out -= normal * np.einsum("fc,fc->f", out, normal)[:, None]
    back -= normal * np.einsum("fc,fc->f", back, normal)[:, None]
    sine = np.einsum("fc,fc->f", np.cross(out, back), normal)
    angle = np.arctan2(sine, np.einsum("fc,fc->f", out, back)) % (2.0 * np.pi)
    # From there a tiny hole looks like a corner everywhere: what is straight is all that tells.
    straight = np.abs(angle - np.pi) < 0.5 * QUARTER
    bent = np.abs(total[passing] - np.pi) >= 0.5 * QUARTER
    if (bent & ~straight).any():
        # A corner of one triangle stays one, whatever is beside it.
        open_ = passing[np.diff(start)[passing] > 1]
        total[open_] = np.pi - _without_jags(crosses, first[open_], np.pi - total[open_])
    total[passing[straight]] = angle[straight]
    return total


def _without_jags(crosses: Crosses, first: np.ndarray, turning: np.ndarray) -> np.ndarray:
    """(f,) what features turn by at the tails of half-edges (f,), at each of which one feature
    passes on one side, without what they turn back within a quad: the nearest opposite ones first.
    """
    leaving: dict[int, list[int]] = {}
    for item, vertex in enumerate(crosses.tail[first].tolist()):
        leaving.setdefault(vertex, []).append(item)
    tail, head = crosses.tail[first], crosses.head[first]
    step = np.linalg.norm(crosses.vertices[head] - crosses.vertices[tail], axis=1)
    step = (step / crosses.size[first // 3]).tolist()
    after, before = [-1] * len(first), [-1] * len(first)
    for item, vertex in enumerate(head.tolist()):
        for other in leaving.get(vertex, []):
            if head[other] != tail[item]:
                after[item], before[other] = other, item
    left = turning.tolist()
    near = [
        (step[item], item, other)
        for item, other in enumerate(after)
        if other >= 0 and left[item] * left[other] <= 0.0 and step[item] < JAG
    ]
    heapq.heapify(near)
    while near:
        _, one, other = heapq.heappop(near)
        if after[one] != other or before[other] != one:
            continue
        both = left[one] + left[other]
        gone = one if abs(left[one]) <= abs(left[other]) else other
        kept = other if gone == one else one
        left[gone], left[kept] = 0.0, both
        # What is straight now is left out of the chain.
        back, on = before[gone], after[gone]
        if back >= 0:
            after[back] = on
            step[back] += step[gone]
        if on >= 0:
            before[on] = back
        after[gone] = before[gone] = -1
        joined = back >= 0 and on >= 0 and back != on
        if joined and left[back] * left[on] <= 0.0 and step[back] < JAG:
            heapq.heappush(near, (step[back], back, on))
    return np.array(left)


class _Chains:
    """Features as ways from vertex to vertex."""

    def __init__(self, crosses: Crosses) -> None:
        self._vertices = crosses.vertices
        edge = np.flatnonzero(crosses.feature)
        pair = np.sort(np.column_stack([crosses.tail[edge], crosses.head[edge]]), axis=1)
        pair = np.unique(pair, axis=0)
        end = np.concatenate([pair[:, 0], pair[:, 1]])
        other = np.concatenate([pair[:, 1], pair[:, 0]])
        count = np.bincount(end, minlength=len(crosses.vertices))
        # (n,) bool: one feature, and nothing else, goes on through the vertex.
        self.passed = count == 2
        order = np.argsort(end, kind="stable")
        order = order[self.passed[end[order]]]
        self._beside = np.full((len(count), 2), -1)
        self._beside[end[order][::2]] = other[order].reshape(-1, 2)

    def point(self, vertex: np.ndarray, towards: np.ndarray, length: np.ndarray) -> np.ndarray:
        """(f, 3) points so far along the feature from vertices towards those beside them, or
        where it ends before."""
        before, here = vertex.copy(), towards.copy()
        place = self._vertices[here].copy()
        step = np.linalg.norm(place - self._vertices[before], axis=1)
        left = length - step
        going = np.arange(len(vertex))
        for _ in range(MOST_STEPS):
            on = (left[going] > 0.0) & self.passed[here[going]] & (here[going] != vertex[going])
            going = going[on]
            if not len(going):
                break
            beside = self._beside[here[going]]
            onward = np.where(beside[:, 0] == before[going], beside[:, 1], beside[:, 0])
            before[going], here[going] = here[going], onward
            there = self._vertices[onward]
            left[going] -= np.linalg.norm(there - place[going], axis=1)
            place[going] = there
        return place


def _normals(crosses: Crosses) -> np.ndarray:
    """(n, 3) unit normals at vertices."""
    angle = crosses.corner_angle
    total = np.stack(
        [
            np.bincount(
                crosses.tail,
                angle * np.repeat(crosses.normal[:, k], 3),
                minlength=len(crosses.vertices),
            )
            for k in range(3)
        ],
        axis=1,
    )
    return unit(total)


def fitting_turns(
    angle: np.ndarray, turns: np.ndarray, least: np.ndarray, plain: np.ndarray
) -> np.ndarray:
    """(f,) int64 the quarter turns that sectors of such angles should have: those that they have
    unless their quads would be flat or pointed there, the nearest where `plain` (f,) bool."""
    share = angle / np.maximum(turns, 1)
    unfit = (share >= np.pi) | (np.sin(np.minimum(share, np.pi)) < FLAT) | (turns < least)
    unfit |= np.abs(angle / QUARTER - turns) > np.where(plain, 0.5, OFF)
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
