"""Opening the corners of quads by moving the vertices around them, all at once.

What the sines of the corners miss, squared, is summed over the quads and minimized over the moves
of the vertices (optimization-based smoothing: Freitag & Ollivier-Gooch 1997, 10.1002/(SICI)
1097-0207(19971115)40:21<3979::AID-NME251>3.0.CO;2-9) by quasi-Newton steps of limited memory
(Nocedal 1980, 10.1090/S0025-5718-1980-0572855-7) that are held within a box.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ....base.unit import cross

# Sides are not left shorter than this part of the mean, and that counts so much.
LEAST_SIDE, SIDE_WEIGHT = 0.2, 4.0
# Lengths count as if this part of the mean lay across them: beside sides of no length sines would
# jump, and steps end there. From 0.02 to 0.1 means of the bunny, the beetle and the skull change by
# 0.001.
SOFT = 0.05
# A vertex moves by this part of the mean side at most in each of its axes.
FARTHEST = 0.7
# Steps at most, pairs of steps and slopes that are remembered, halvings of a step, and the part of
# what its slope promises that a step must win. With 40 or 160 steps the same three are as good.
STEPS, MEMORY, HALVINGS, ARMIJO = 80, 12, 20, 1e-4
# A step that wins less than this part is the last.
LITTLE = 1e-6
TINY = 1e-30
# What corners lack to the sine that is wanted counts so much beside what they lack to a right one.
LOW_WEIGHT = 8.0
# A quad is as good as its worst corner: the root of the mean fourth power of what its corners lack
# is nearly what the worst does, and smooth; a lack so small is none. With squares a third less is
# won, with eighth powers it is the same. Chosen on Suzanne, the skull and wave 1 of the benchmark;
# confirmed on wave 3, Spot and the bunny.
NOTHING = 1e-3
# The corners after and before each of a quad.
NEXT, LAST = (1, 2, 3, 0), (3, 0, 1, 2)
# Middle lines of a quad as sums of its corners, and the sine below which a pull on them fades.
LINES = 0.5 * np.array([[-1.0, 1.0, 1.0, -1.0], [-1.0, -1.0, 1.0, 1.0]])
NEARLY = 0.1


class Opening:
    """The problem of one round: unknowns are moves in the axes, in mean sides.

    Parameters
    ----------
    base:
        (q, 4, 3) corners of the quads.
    up:
        (q, 3) unit normals of the planes that they are seen in.
    local:
        (q, 4) row of each corner among the r vertices that move, -1 for those that stay.
    axes:
        (r, k, 3) directions in which these move, 0 for fewer.
    stay:
        How much a move by the mean side costs beside a corner that misses all.
    wanted:
        Corners are opened up to this sine.
    """

    def __init__(
        self,
        base: np.ndarray,
        up: np.ndarray,
        local: np.ndarray,
        axes: np.ndarray,
        stay: float,
        wanted: float,
    ) -> None:
        self._base, self._up, self._axes, self._stay = base, up[:, None], axes, stay
        self._wanted = wanted
        side = np.linalg.norm(np.roll(base, -1, axis=1) - base, axis=2)
        self._side = max(float(side.mean()), TINY)
        # The corners that move, among all of them, and the rows of these.
        self._moves = np.flatnonzero(local >= 0)
        self._local = local.ravel()[self._moves]

    def step(self) -> np.ndarray:
        """(r, 3) the move of each vertex."""
        count, axes, _ = self._axes.shape
        return self._moved(least_in_box(self._value, count * axes, FARTHEST))

    def _moved(self, unknown: np.ndarray) -> np.ndarray:
        count, axes, _ = self._axes.shape
        by = self._side * unknown.reshape(count, axes)
        return np.einsum("rk,rkc->rc", by, self._axes)

    def _value(self, unknown: np.ndarray) -> tuple[float, np.ndarray]:
        """The sum that is minimized, and its gradient."""
        at = self._base.copy()
        at.reshape(-1, 3)[self._moves] += self._moved(unknown)[self._local]
        value, force = self._corners(at)
        pull = force.reshape(-1, 3)[self._moves]
        count = len(self._axes)
        total = np.stack([np.bincount(self._local, pull[:, k], count) for k in range(3)], axis=1)
        slope = self._side * np.einsum("rc,rkc->rk", total, self._axes)
        value += self._stay * float((unknown**2).sum())
        return value, slope.ravel() + 2.0 * self._stay * unknown

    def _corners(self, at: np.ndarray) -> tuple[float, np.ndarray]:
        """What the corners (q, 4, 3) of the quads lack, and its slopes."""
        up, side = self._up, self._side
        out = at.take(NEXT, axis=1) - at
        back = at.take(LAST, axis=1) - at
        length = np.sqrt((out**2).sum(axis=2) + (SOFT * side) ** 2)
        before = length.take(LAST, axis=1)
        sine = np.einsum("qkc,qkc->qk", cross(out, back), np.broadcast_to(up, out.shape))
        sine /= length * before
        value, steep = self._lack(sine)
        short = np.maximum(LEAST_SIDE - length / side, 0.0)
        value += SIDE_WEIGHT * float((short**2).sum())
        # By the two sides at each corner, the one that leaves and the one back.
        by_sine = (-steep / (length * before))[:, :, None]
        turn = (steep * sine)[:, :, None]
        by_out = by_sine * cross(back, up) + turn * out / (length**2)[:, :, None]
        by_back = by_sine * cross(up, out) + turn * back / (before**2)[:, :, None]
        by_out -= (2.0 * SIDE_WEIGHT / side * short / length)[:, :, None] * out
        return value, by_out.take(LAST, axis=1) + by_back.take(NEXT, axis=1) - by_out - by_back

    def _lack(self, sine: np.ndarray) -> tuple[float, np.ndarray]:
        """What sines (q, 4) lack together, and by how much less it is for more of each."""
        open_ = np.maximum(self._wanted - sine, 0.0)
        return float((open_**2).sum()), 2.0 * open_


class Squaring(Opening):
    """The problem of making all corners square and turning the quads to directions at once.

    What a quad lacks to right angles, at its worst corner above all, counts as it is and not
    squared, so that the mean of the scaled Jacobians becomes best; what corners lack to `wanted`
    counts besides, squared. Both middle lines of a quad are pulled to the nearer of two axes by a
    pull that hardly grows with the angle.

    Parameters
    ----------
    x, y:
        (q, 3) unit axes in the planes that the quads are seen in.
    pull:
        (q,) how much a middle line halfway between the axes counts, beside a fourth of a quad that
        misses all.
    """

    def __init__(
        self,
        base: np.ndarray,
        x: np.ndarray,
        y: np.ndarray,
        pull: np.ndarray,
        local: np.ndarray,
        axes: np.ndarray,
        stay: float,
        wanted: float,
    ) -> None:
        super().__init__(base, np.cross(x, y), local, axes, stay, wanted)
        self._x, self._y, self._pull = x, y, pull

    def _corners(self, at: np.ndarray) -> tuple[float, np.ndarray]:
        value, force = super()._corners(at)
        for line in LINES:
            middle = np.einsum("k,qkc->qc", line, at)
            along = np.einsum("qc,qc->q", middle, self._x)
            across = np.einsum("qc,qc->q", middle, self._y)
            square = along**2 + across**2 + (SOFT * self._side) ** 2
            # Half the sine of twice the angle.
            off = along * across / square
            size = np.sqrt(off**2 + NEARLY**2)
            value += float((self._pull * (size - NEARLY)).sum())
            steep = self._pull * off / size / square
            by_x = steep * (across - 2.0 * off * along)
            by_y = steep * (along - 2.0 * off * across)
            slope = by_x[:, None] * self._x + by_y[:, None] * self._y
            force += line[:, None] * slope[:, None]
        return value, force

    def _lack(self, sine: np.ndarray) -> tuple[float, np.ndarray]:
        low = np.maximum(self._wanted - sine, 0.0)
        lack = 1.0 - sine + NOTHING
        whole = np.sqrt(np.sqrt(np.square(lack**2).mean(axis=1, keepdims=True)))
        lacks = 4.0 * whole.sum() + LOW_WEIGHT * (low**2).sum()
        share = lack / whole
        return float(lacks), share * share * share + 2.0 * LOW_WEIGHT * low


def least_in_box(
    function: Callable[[np.ndarray], tuple[float, np.ndarray]], count: int, bound: float
) -> np.ndarray:
    """(count,) where a function is small, from 0 on, with no unknown beyond the bound.

    `function` gives its value and its gradient. Steps are laid back into the box; what lies on its
    wall and would go on through it is left out of them.
    """
    x = np.zeros(count)
    value, slope = function(x)
    # Steps, changes of the slope by them, and what one is along the other.
    past: list[tuple[np.ndarray, np.ndarray, float]] = []
    for _ in range(STEPS):
        free = (np.abs(x) < bound) | (slope * x > 0.0)
        way = np.where(free, -_curved(slope * free, past), 0.0)
        promised = _dot(slope, way)
        if promised >= 0.0:
            way, promised = -slope * free, -_dot(slope * free, slope)
        if promised >= 0.0:
            break
        # Without any memory a step is by a tenth of the box at most.
        length = 1.0 if past else min(1.0, 0.1 * bound / max(float(np.abs(way).max()), TINY))
        for _ in range(HALVINGS):
            trial = np.clip(x + length * way, -bound, bound)
            found, steeper = function(trial)
            if found <= value + ARMIJO * length * promised:
                break
            length *= 0.5
        else:
            break
        step, change = trial - x, steeper - slope
        along = _dot(step, change)
        if along > 1e-12 * _dot(change, change):
            past = [*past, (step, change, along)][-MEMORY:]
        won, x, value, slope = value - found, trial, found, steeper
        if won <= LITTLE * max(abs(value), TINY):
            break
    return x


def _curved(
    slope: np.ndarray, past: list[tuple[np.ndarray, np.ndarray, float]]
) -> np.ndarray:
    """The slope times the inverse of the Hessian that steps and changes of slopes let expect."""
    way = slope.copy()
    shares = []
    for step, change, along in reversed(past):
        share = _dot(step, way) / along
        shares.append(share)
        way -= share * change
    if past:
        _, change, along = past[-1]
        way *= along / _dot(change, change)
    for (step, change, along), share in zip(past, reversed(shares), strict=True):
        way += step * (share - _dot(change, way) / along)
    return way


def _dot(one: np.ndarray, two: np.ndarray) -> float:
    """Without the threads of linear algebra, which wait for each other on a machine at work."""
    return float(np.einsum("i,i->", one, two))
