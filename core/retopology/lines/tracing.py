"""Many lines traced through the triangles of a surface at once.

A line crosses one triangle at a step, along the direction in the middle of its chord (the
midpoint rule), and its points lie on the edges in between: it never leaves the surface. The
direction is the root of the deviator nearest to the one before, never a signed vector.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ...base.progress import Progress
from ...fields.planes import FaceFrames
from ...mesh.surface import Surface
from .chords import Chords, Walk, next_chords
from .headway import Headway

# Cosine of the angle up to which a line goes towards what it comes near to; beyond, its last chord
# would turn as far as no other does. Chosen of 0, 0.5 and 0.7 on a torso, a goblet and Spot (0.7
# leads lines by that have nothing else to end at), confirmed on a face, a hand and a human.
LEAST_AIM = 0.5
# Why a line ends.
LIMIT, BORDER, OBSTACLE, TURN, MET, CLOSED, LOST, FEATURE = range(8)


@dataclass(frozen=True)
class Starts:
    """Where r lines begin, and how they go on from there.

    Attributes
    ----------
    triangle:
        (r,) int64 triangles.
    z:
        (r,) complex128 places in their planes.
    direction:
        (r,) complex128 of modulus 1: the way to go at first; of the two directions of the line
        field the nearer is taken.
    family:
        (r,) int: 0 for lines of the larger curvature, 1 for those of the smaller.
    limit:
        (r,) float64 length at which each line ends.
    straight:
        (r,) float64 length over which `direction` is kept, as a geodesic, before the field is
        followed; infinite for a geodesic.
    own:
        (r,) int obstacle that the line begins at, -1 for none; it does not count before the
        line has gone the length `grace` (r,), nor does a sharp turn.
    steady:
        (r,) bool lines that go straight on where the field is weak, and end rather than turn
        within a few edges; the others follow it whatever it does.
    """

    triangle: np.ndarray
    z: np.ndarray
    direction: np.ndarray
    family: np.ndarray
    limit: np.ndarray
    straight: np.ndarray
    own: np.ndarray
    grace: np.ndarray
    steady: np.ndarray

    @classmethod
    def plain(
        cls,
        triangle: np.ndarray,
        z: np.ndarray,
        direction: np.ndarray,
        family: np.ndarray,
        limit: np.ndarray,
        straight: float = 0.0,
    ) -> Starts:
        """Starts away from obstacles."""
        count = len(triangle)
        return cls(
            triangle,
            z,
            direction,
            family,
            limit,
            np.full(count, straight),
            np.full(count, -1),
            np.zeros(count),
            np.ones(count, bool),
        )

    def __len__(self) -> int:
        return len(self.triangle)

    def select(self, rows: np.ndarray) -> Starts:
        """The given rows (a mask or indices)."""
        return Starts(**{name: value[rows] for name, value in vars(self).items()})


@dataclass(frozen=True)
class Obstacles:
    """What lines end at: on the edge of the first triangle of one that they come to.

    Attributes
    ----------
    number:
        (m,) int the obstacle that each triangle belongs to, -1 if none.
    place:
        (m,) complex128 where the obstacle of each triangle lies, in its plane: a line that goes by
        rather than towards it goes on, and ends there only where it would turn sharply. NaN where
        all end; None where all do everywhere.
    """

    number: np.ndarray
    place: np.ndarray | None = None

    @classmethod
    def none(cls, surface: Surface) -> Obstacles:
        """Nothing to end at."""
        return cls(np.full(len(surface.triangles), -1))


@dataclass(frozen=True)
class Traces:
    """Traced lines, one after the other.

    Attributes
    ----------
    start:
        (r + 1,) int64: the points of line i are rows start[i]:start[i + 1].
    triangle, z:
        (p,) int64 and complex128 places; each chord lies in the triangle of its second point.
    travelled:
        (p,) float64 length from the line's first point.
    end:
        (r,) int8 why it ended.
    obstacle:
        (r,) int64 the obstacle it ended at, -1 for none.
    direction:
        (r,) complex128 its direction at the end, in the plane of its last triangle.
    """

    start: np.ndarray
    triangle: np.ndarray
    z: np.ndarray
    travelled: np.ndarray
    end: np.ndarray
    obstacle: np.ndarray
    direction: np.ndarray


class Stop(Protocol):
    """Ends lines for reasons of its own; asked every so many steps."""

    every: int

    def __call__(
        self, ids: np.ndarray, triangle: np.ndarray, z: np.ndarray, length: np.ndarray
    ) -> np.ndarray:
        """(r,) why each of the running lines `ids` (r,) must end, -1 for those that go on; their
        triangles, places in them and lengths are (r,)."""


def trace(
    surface: Surface,
    planes: FaceFrames,
    starts: Starts,
    obstacles: Obstacles,
    progress: Progress,
    stop: Stop | None = None,
) -> Traces:
    """Trace lines until they meet their limit, a border, an obstacle or a sudden turn.

    Whatever the mesh and the field, every line ends, see `Headway`.
    """
    count = len(starts)
    running = _Running.begun(starts, planes)
    end, ended_at = np.full(count, LIMIT, np.int8), np.full(count, -1)
    last = np.ones(count, complex)
    headway = Headway(surface, count)
    records = [(running.ids, running.triangle, running.z, running.length)]
    steps = 0
    # Each call of NumPy costs more than the work on some hundred lines, so that what is needed
    # by few of them is looked at only where there are any.
    with np.errstate(divide="ignore", invalid="ignore"):
        while len(running.ids):
            steps += 1
            if steps % 64 == 0:
                progress.step(1.0 - len(running.ids) / count)
            chords = running.chords(planes)
            border, reached = running.moved(chords, surface, planes)
            ids = running.ids
            made = ~chords.turned if chords.turned.any() else slice(None)
            records.append(
                (ids[made], chords.triangle[made], chords.z[made], running.length[made])
            )
            block = obstacles.number[running.triangle]
            hit = running.arrived(block)
            if obstacles.place is not None and (block >= 0).any():
                hit &= ~running.passing(obstacles.place[running.triangle])
                hit |= chords.turned & running.beyond(block)
            told: np.ndarray | int = -1
            if stop is not None and steps % stop.every == 0:
                told = stop(ids, chords.triangle, chords.z, running.length)
            lost = headway.lost(ids, chords.triangle, chords.length)
            done = border | reached | chords.turned | hit | lost | (told >= 0)
            if not done.any():
                continue
            code = np.where(lost, LOST, told)
            for why, number in (
                (border, BORDER),
                (reached, LIMIT),
                (chords.turned, TURN),
                (hit, OBSTACLE),
            ):
                code[why] = number
            ended_at[ids[hit]] = block[hit]
            end[ids[done]], last[ids[done]] = code[done], chords.direction[done]
            running = running.select(~done)
    return _collected(records, count, end, ended_at, last)


@dataclass
class _Running(Walk):
    """The lines that are still being traced, (r,) each; see `Starts` and `Walk`."""

    ids: np.ndarray
    own: np.ndarray
    grace: np.ndarray
    limit: np.ndarray
    length: np.ndarray

    @classmethod
    def begun(cls, starts: Starts, planes: FaceFrames) -> _Running:
        count = len(starts)
        triangle = starts.triangle.astype(np.int64)
        return cls(
            ids=np.arange(count),
            triangle=triangle,
            z=starts.z.astype(complex),
            direction=starts.direction.astype(complex),
            heading=starts.direction.astype(complex),
            entry=np.full(count, -1),
            sign=np.where(starts.family == 0, 1.0, -1.0),
            straight=starts.straight.astype(float),
            own=starts.own.astype(np.int64),
            grace=starts.grace.astype(float),
            steady=starts.steady.astype(bool),
            limit=starts.limit.astype(float),
            length=np.zeros(count),
            corner=planes.corner[triangle],
        )

    def select(self, rows: np.ndarray) -> _Running:
        return _Running(**{name: value[rows] for name, value in vars(self).items()})

    def chords(self, planes: FaceFrames) -> Chords:
        return next_chords(planes, self, self.limit - self.length, self.length >= self.grace)

    def moved(
        self, chords: Chords, surface: Surface, planes: FaceFrames
    ) -> tuple[np.ndarray, np.ndarray]:
        """Go along the chords and into the triangles beyond; whether a border, or the limit of
        the length, was met."""
        rows = np.arange(len(self.ids))
        self.length = self.length + chords.length
        if self.straight.any():
            straight = self.straight - chords.length
            self.straight = np.where(straight < 1e-12, 0.0, straight)
        half_edge = 3 * chords.triangle + chords.side
        twin = surface.twin[half_edge].astype(np.int64)
        border = (twin < 0) & ~chords.inside
        reached = self.length >= self.limit * (1.0 - 1e-12)
        stay = chords.inside | border | reached | chords.turned
        staying = np.flatnonzero(stay)
        beyond = twin // 3
        entry = twin - 3 * beyond
        turn = planes.turn[half_edge]
        turn[staying] = 1.0
        beyond[staying], entry[staying] = chords.triangle[staying], -1
        self.corner = planes.corner[beyond]
        tail = self.corner[rows, entry]
        into = tail + (1.0 - chords.share) * (self.corner[rows, (entry + 1) % 3] - tail)
        self.z = np.where(stay, chords.z, into)
        self.triangle, self.entry = beyond, entry
        self.direction, self.heading = chords.direction * turn, chords.heading * turn
        return border, reached

    def passing(self, place: np.ndarray) -> np.ndarray:
        """(r,) bool, True where a line goes by what lies at `place` (r,), NaN for nothing."""
        away = place - self.z
        ahead: np.ndarray = (away * self.direction.conj()).real < LEAST_AIM * np.abs(away)
        return ahead

    def arrived(self, block: np.ndarray) -> np.ndarray:
        """(r,) bool, True where the obstacle `block` (r,) of the triangle entered ends a line."""
        hit = block >= 0
        if hit.any():
            # A line that stayed in its triangle has entered none.
            hit &= (self.entry >= 0) & self.beyond(block)
        return hit

    def beyond(self, block: np.ndarray) -> np.ndarray:
        """(r,) bool, True where the obstacle `block` (r,) is one for the line, and no longer the
        one that it leaves."""
        return (block >= 0) & ((block != self.own) | (self.length > self.grace))


def _collected(
    records: Sequence[tuple[np.ndarray, ...]],
    count: int,
    end: np.ndarray,
    obstacle: np.ndarray,
    last: np.ndarray,
) -> Traces:
    ids, triangle, z, length = (np.concatenate(part) for part in zip(*records, strict=True))
    order = np.argsort(ids, kind="stable")
    start = np.concatenate([[0], np.cumsum(np.bincount(ids, minlength=count))])
    return Traces(
        start.astype(np.int64), triangle[order], z[order], length[order], end, obstacle, last
    )
