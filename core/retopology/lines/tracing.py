"""Many lines traced through the triangles of a surface at once.

A line crosses one triangle at a step, along the direction in the middle of its chord (the
midpoint rule), and its points lie on the edges in between: it never leaves the surface. The
direction is the root of the deviator nearest to the one before, never a signed vector.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...base.progress import Progress
from ...fields.planes import FaceFrames
from ...mesh.surface import Surface

# Why a line ends.
LIMIT, BORDER, OBSTACLE, TURN, MET, CLOSED = range(6)
ENDS = ("limit", "border", "obstacle", "turn", "met", "closed")

# Cosine of the largest turn from one triangle to the next; a line of curvature that turns more
# has lost its way at a place where the mesh does not resolve the directions.
LEAST_COSINE = 0.5
# Lines keep this share of an edge away from its ends, where there would be no triangle beyond.
MARGIN = 1e-6
# A direction that leaves by the edge it came in by runs along that edge, this steeply inwards.
INWARD = 1e-3


@dataclass(frozen=True)
class Starts:
    """Where r lines begin.

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
    straight:
        (r,) float64 length over which `direction` is kept, as a geodesic, before the field is
        followed; infinite for a geodesic.
    own:
        (r,) int obstacle that the line begins at, -1 for none; it does not count before the
        line has gone the length `grace` (r,).
    """

    triangle: np.ndarray
    z: np.ndarray
    direction: np.ndarray
    family: np.ndarray
    straight: np.ndarray
    own: np.ndarray
    grace: np.ndarray

    @classmethod
    def plain(
        cls,
        triangle: np.ndarray,
        z: np.ndarray,
        direction: np.ndarray,
        family: np.ndarray,
        straight: float = 0.0,
    ) -> Starts:
        """Starts away from obstacles."""
        count = len(triangle)
        return cls(
            triangle,
            z,
            direction,
            family,
            np.full(count, straight),
            np.full(count, -1),
            np.zeros(count),
        )

    def __len__(self) -> int:
        return len(self.triangle)


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


Stop = Callable[[np.ndarray, np.ndarray, np.ndarray, np.ndarray], np.ndarray]


def trace(
    surface: Surface,
    planes: FaceFrames,
    starts: Starts,
    limit: np.ndarray,
    obstacle: np.ndarray,
    progress: Progress,
    stop: Stop | None = None,
    every: int = 1,
) -> Traces:
    """Trace lines until they meet their limit, a border, an obstacle or a sudden turn.

    Parameters
    ----------
    limit:
        (r,) float64 length at which each line ends.
    obstacle:
        (m,) int number of the obstacle that each triangle belongs to, -1 if none. A line ends
        on the edge of the first such triangle that it comes to.
    stop:
        Asked every `every` steps with the rows of the running lines, their triangles, places
        and lengths; answers with the codes of those that must end, -1 for the others.
    """
    count = len(starts)
    ids = np.arange(count)
    triangle, z = starts.triangle.astype(np.int64), starts.z.astype(complex)
    direction, entry = starts.direction.astype(complex), np.full(count, -1)
    sign = np.where(starts.family == 0, 1.0, -1.0)
    straight, own = starts.straight.astype(float), starts.own.astype(np.int64)
    grace = starts.grace.astype(float)
    limit, length = limit.astype(float), np.zeros(count)
    end, ended_at = np.full(count, LIMIT, np.int8), np.full(count, -1)
    last = np.ones(count, complex)
    corner = planes.corner[triangle]
    records = [(ids, triangle, z, length)]
    steps = 0
    # Each call of NumPy costs more than the work on some hundred lines, so that what is needed
    # by few of them is looked at only where there are any.
    with np.errstate(divide="ignore", invalid="ignore"):
        while len(ids):
            steps += 1
            if steps % 64 == 0:
                progress.step(1.0 - len(ids) / count)
            rows = np.arange(len(ids))
            edge, height = _edges(corner, z, entry, rows)
            field = planes.value[triangle], planes.along[triangle], planes.across[triangle]
            geodesic = straight > 0
            some_geodesic = geodesic.any()
            first = _root(field, z, sign, direction)
            if some_geodesic:
                first = np.where(geodesic, direction, first)
            half, _ = _exit(edge, height, first, rows)
            middle = _root(field, z + 0.5 * half * first, sign, first)
            if some_geodesic:
                middle = np.where(geodesic, direction, middle)
            middle = _inwards(edge, entry, middle, rows)
            distance, side = _exit(edge, height, middle, rows)
            turned = (middle * direction.conj()).real < LEAST_COSINE
            step = np.minimum(distance, limit - length)
            if some_geodesic:
                step = np.where(geodesic, np.minimum(step, straight), step)
            step[turned] = 0.0
            step = np.maximum(step, 0.0)
            inside = step < distance
            length = length + step
            if some_geodesic:
                straight = straight - step
                straight[straight < 1e-12] = 0.0
            moved = z + step * middle
            out = edge[rows, side]
            here = corner[rows, side]
            share = ((moved - here) * out).real / np.maximum(np.abs(out) ** 2, 1e-300)
            share = np.minimum(np.maximum(share, MARGIN), 1.0 - MARGIN)
            z = np.where(inside, moved, here + share * out.conj())
            records.append((ids, triangle, z, length))

            half_edge = 3 * triangle + side
            twin = surface.twin[half_edge].astype(np.int64)
            border = (twin < 0) & ~inside
            reached = length >= limit * (1.0 - 1e-12)
            stay = inside | border | reached | turned
            direction = middle * planes.turn[half_edge]
            beyond = twin // 3
            entry = twin - 3 * beyond
            staying = np.flatnonzero(stay)
            beyond[staying], entry[staying] = triangle[staying], -1
            direction[staying] = middle[staying]
            block = obstacle[beyond]
            hit = block >= 0
            if hit.any():
                hit &= ~stay & ((block != own) | (length > grace))
            told = -1
            if stop is not None and steps % every == 0:
                told = stop(ids, triangle, z, length)
            corner = planes.corner[beyond]
            tail = corner[rows, entry]
            into = tail + (1.0 - share) * (corner[rows, (entry + 1) % 3] - tail)
            z = np.where(stay, z, into)
            done = border | reached | turned | hit | (told >= 0)
            if not done.any():
                triangle = beyond
                continue
            code = np.where(border, BORDER, told)
            for why, number in ((reached, LIMIT), (turned, TURN), (hit, OBSTACLE)):
                code[why] = number
            ended_at[ids[hit]] = block[hit]
            end[ids[done]], last[ids[done]] = code[done], middle[done]
            going = ~done
            ids, triangle, z, direction = ids[going], beyond[going], z[going], direction[going]
            entry, sign, straight, own = entry[going], sign[going], straight[going], own[going]
            limit, length, grace = limit[going], length[going], grace[going]
            corner = corner[going]
    return _collected(records, count, end, ended_at, last)


def _edges(
    corner: np.ndarray, z: np.ndarray, entry: np.ndarray, rows: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Conjugates (r, 3) of the edges of triangles, and twice the areas (r, 3) from them to z;
    infinite for the edge that a line came in by."""
    edge = (corner[:, (1, 2, 0)] - corner).conj()
    height = np.maximum((edge * (z[:, None] - corner)).imag, 0.0)
    came = entry >= 0
    height[rows[came], entry[came]] = np.inf
    return edge, height


def _root(field: tuple, z: np.ndarray, sign: np.ndarray, near: np.ndarray) -> np.ndarray:
    """The direction of the line field at z that is nearer to `near`; `near` at its zeros."""
    value, along, across = field
    root = np.sqrt(sign * (value + along * z + across * z.conj()))
    size = np.abs(root)
    root /= np.copysign(size, (root * near.conj()).real)
    if not size.all():
        root = np.where(size > 0, root, near)
    return root


def _inwards(
    edge: np.ndarray, entry: np.ndarray, direction: np.ndarray, rows: np.ndarray
) -> np.ndarray:
    """The directions, but along the edge that a line came in by where it would leave by it."""
    inner = edge[rows, entry]
    along = direction * (inner / np.maximum(np.abs(inner), 1e-300))
    back = np.flatnonzero((along.imag < INWARD) & (entry >= 0))
    if len(back):
        inner = inner[back].conj() / np.maximum(np.abs(inner[back]), 1e-300)
        steep = np.where(along[back].real >= 0, np.exp(1j * INWARD), -np.exp(-1j * INWARD))
        direction[back] = steep * inner
    return direction


def _exit(
    edge: np.ndarray, height: np.ndarray, direction: np.ndarray, rows: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Distance (r,) to the edge by which a ray leaves its triangle, and that edge."""
    rate = (edge * direction[:, None]).imag
    distance = np.where(rate < 0, height / -rate, np.inf)
    side = distance.argmin(axis=1)
    distance = distance[rows, side]
    return np.where(distance < np.inf, distance, 0.0), side


def _collected(
    records: list, count: int, end: np.ndarray, obstacle: np.ndarray, last: np.ndarray
) -> Traces:
    ids, triangle, z, length = (np.concatenate(part) for part in zip(*records, strict=True))
    order = np.argsort(ids, kind="stable")
    start = np.concatenate([[0], np.cumsum(np.bincount(ids, minlength=count))])
    return Traces(
        start.astype(np.int64), triangle[order], z[order], length[order], end, obstacle, last
    )
