"""Many lines traced through the triangles of a surface at once.

A line crosses one triangle at a step, along the direction in the middle of its chord (the
midpoint rule), and its points lie on the edges in between: it never leaves the surface. The
direction is the root of the deviator nearest to the one before, never a signed vector.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .progress import Progress
from .surface import Surface
from .triangle_planes import TrianglePlanes

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
    planes: TrianglePlanes,
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
    records = [(ids, triangle, z, length)]
    steps = 0
    while len(ids):
        steps += 1
        if steps % 64 == 0:
            progress.step(1.0 - len(ids) / count)
        corner = planes.corner[triangle]
        field = planes.value[triangle], planes.along[triangle], planes.across[triangle]
        kept = straight > 0
        first = np.where(kept, direction, _root(field, z, sign, direction))
        half, _, _ = _exit(corner, z, first, entry)
        middle = np.where(kept, direction, _root(field, z + 0.5 * half * first, sign, first))
        distance, side, middle = _exit(corner, z, middle, entry)
        turned = (middle * direction.conj()).real < LEAST_COSINE
        step = np.minimum(distance, limit - length)
        step = np.where(kept, np.minimum(step, straight), step)
        step = np.maximum(np.where(turned, 0.0, step), 0.0)
        inside = step < distance
        length = length + step
        straight = straight - step
        straight[straight < 1e-12] = 0.0
        z = z + step * middle
        rows = np.arange(len(ids))
        here, there = corner[rows, side], corner[rows, (side + 1) % 3]
        edge = there - here
        share = ((z - here) * edge.conj()).real / np.maximum(np.abs(edge) ** 2, 1e-300)
        share = np.clip(share, MARGIN, 1.0 - MARGIN)
        z = np.where(inside, z, here + share * edge)
        records.append((ids, triangle, z, length))

        half_edge = 3 * triangle + side
        twin = np.where(inside, half_edge, surface.twin[half_edge]).astype(np.int64)
        code = np.full(len(ids), -1)
        code[~inside & (twin < 0)] = BORDER
        code[length >= limit * (1.0 - 1e-12)] = LIMIT
        code[turned] = TURN
        crossing = ~inside & (code < 0)
        beyond = np.where(crossing, twin // 3, triangle)
        block = np.where(crossing, obstacle[beyond], -1)
        hit = (block >= 0) & ((block != own) | (length > grace))
        code[hit] = OBSTACLE
        ended_at[ids[hit]] = block[hit]

        direction = np.where(crossing, middle * planes.turn[half_edge], middle)
        entry = np.where(crossing, twin % 3, -1)
        following = planes.corner[beyond]
        into = following[rows, entry] + (1.0 - share) * (
            following[rows, (entry + 1) % 3] - following[rows, entry]
        )
        if stop is not None and steps % every == 0:
            told = stop(ids, triangle, z, length)
            code = np.where((code < 0) & (told >= 0), told, code)
        z = np.where(crossing, into, z)
        done = code >= 0
        if done.any():
            end[ids[done]], last[ids[done]] = code[done], middle[done]
            going = ~done
            ids, triangle, z, direction = ids[going], beyond[going], z[going], direction[going]
            entry, sign, straight, own = entry[going], sign[going], straight[going], own[going]
            limit, length, grace = limit[going], length[going], grace[going]
        else:
            triangle = beyond
    return _collected(records, count, end, ended_at, last)


def _root(field: tuple, z: np.ndarray, sign: np.ndarray, near: np.ndarray) -> np.ndarray:
    """The direction of the line field at z that is nearer to `near`; `near` at its zeros."""
    value, along, across = field
    root = np.sqrt(sign * (value + along * z + across * z.conj()))
    size = np.abs(root)
    known = size > 0
    root = np.where(known, root / np.where(known, size, 1.0), near)
    return np.where((root * near.conj()).real < 0, -root, root)


def _exit(
    corner: np.ndarray, z: np.ndarray, direction: np.ndarray, entry: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Distance (r,) to the edge by which a ray leaves its triangle, that edge, and the ray."""
    edge = np.roll(corner, -1, axis=1) - corner
    rows = np.arange(len(z))
    came = entry >= 0
    inner = edge[rows, entry]
    inner = inner / np.maximum(np.abs(inner), 1e-300)
    along = direction * inner.conj()
    backward = came & (along.imag < INWARD)
    slid = np.where(along.real >= 0, np.exp(1j * INWARD), -np.exp(-1j * INWARD)) * inner
    direction = np.where(backward, slid, direction)
    height = (edge.conj() * (z[:, None] - corner)).imag
    rate = (edge.conj() * direction[:, None]).imag
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = np.where(rate < 0, np.maximum(height, 0.0) / -rate, np.inf)
    distance[rows[came], entry[came]] = np.inf
    side = distance.argmin(axis=1)
    distance = distance[rows, side]
    return np.where(np.isfinite(distance), distance, 0.0), side, direction


def _collected(
    records: list, count: int, end: np.ndarray, obstacle: np.ndarray, last: np.ndarray
) -> Traces:
    ids, triangle, z, length = (np.concatenate(part) for part in zip(*records, strict=True))
    order = np.argsort(ids, kind="stable")
    start = np.concatenate([[0], np.cumsum(np.bincount(ids, minlength=count))])
    return Traces(
        start.astype(np.int64), triangle[order], z[order], length[order], end, obstacle, last
    )


def places(planes: TrianglePlanes, triangle: np.ndarray, barycentric: np.ndarray) -> np.ndarray:
    """(r,) complex128 places of points given by barycentric coordinates (r, 3)."""
    return np.einsum("rk,rk->r", planes.corner[triangle], barycentric)


def barycentric_of(planes: TrianglePlanes, triangle: np.ndarray, z: np.ndarray) -> np.ndarray:
    """(r, 3) barycentric coordinates of places z in the planes of triangles, inside them."""
    corner = planes.corner[triangle]
    height = np.where(corner[:, 2].imag > 0, corner[:, 2].imag, 1.0)
    third = z.imag / height
    width = np.where(corner[:, 1].real > 0, corner[:, 1].real, 1.0)
    second = (z.real - third * corner[:, 2].real) / width
    weights = np.clip(np.stack([1.0 - second - third, second, third], axis=1), 0.0, 1.0)
    return weights / weights.sum(axis=1, keepdims=True)


def in_plane(surface: Surface, triangle: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """(r,) complex128 of modulus 1: vectors (r, 3) laid into the planes of their triangles."""
    a, b, _ = (surface.vertices[surface.triangles[triangle, k]] for k in range(3))
    x = b - a
    x /= np.maximum(np.linalg.norm(x, axis=1), 1e-300)[:, None]
    y = np.cross(surface.face_normal_area[0][triangle], x)
    value = np.einsum("rc,rc->r", vectors, x) + 1j * np.einsum("rc,rc->r", vectors, y)
    size = np.abs(value)
    return np.divide(value, size, out=np.ones_like(value), where=size > 0)
