"""Evening out a quad mesh on its surface and turning it to the curvature.

Each step asks every quad for the rectangle nearest to it in the plane that touches the surface
there, turned to the directions of the surface where it nearly follows them; all vertices then go
where the quads come nearest to what they want together, by one linear system that is factored
once, and back to the surface (after Bouaziz et al. 2012, 10.1111/j.1467-8659.2012.03171.x). A
folded quad wants an unfolded one, so folds open.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse

from ....base.factors import definite_factors
from ....base.progress import Progress
from ....base.subsets import places_in
from ....base.unit import unit
from ....mesh.rings import with_rings
from ..field.crosses import QUARTER
from .faults.mending import STAGES, mend, move_axes, oriented_quality
from .guides import Guides, moved_along, own_planes, vertex_normals
from .opening import Squaring

# How much vertices stay where they are, beside what one quad wants: the angle of wave 1 of the
# benchmark is 4.1 degrees with 0.01, 4.4 with 0.03 and 5.7 with 0.1, its worst quad 0.68, 0.73 and
# 0.74; Suzanne, the bunny and the fandisk differ by 0.3 degrees and 0.001 of the mean at most.
STAY = 0.03
# A vertex on a curve goes this far towards what is wanted in a step. With 0.4 or 1 the same four
# come out as with 0.7, to 0.001 of the mean and 0.1 degrees.
RATE = 0.7
# Quads want to turn to the directions by so many degrees at most, beyond the first angle by less
# and beyond the second not at all. A pull that does not grow with the angle makes the sum of the
# angles least, and not that of their squares: where whole numbers of quads leave no other way a
# few are off rather than all sheared. Chosen on waves 1 and 3 of the benchmark, Spot and the bunny.
TURN, TURNED, LEFT = 3.5, 30.0, 40.0
# How far sides are evened to the median, and the least part of it that a side may want. Without the
# first the worst quads of wave 1 and the fandisk lose 0.02 and 0.03, with four times it their worst
# lose 0.04 and 0.09 and the wave's angle is 6.3 degrees for 4.4; with 0.05 or 0.35 for the second
# means and angles of the same four differ by 0.001 and 0.2 degrees at most.
EVEN, LEAST_SIDE = 0.02, 0.175
# Steps for which what is under the quads is looked up once.
BETWEEN = 2
# Where corners are made square: how much a pull to the directions counts, what a move by the mean
# side costs, the sine up to which corners are opened first, the scaled Jacobian below which no quad
# gets worse, and how often a step is halved, and then not made, where one would. Chosen on Suzanne,
# the skull and wave 1 of the benchmark, the pull as the least that costs no angle there; confirmed
# on its wave 3, on Spot and the bunny.
PULL, STAYING, LOW, SOUND, HALVINGS = 0.9, 0.02, 0.75, 0.6, 12
ROUNDING = 1e-9
# Rings around folded quads in which steps are undone, more each time.
UNDONE_RINGS = 2


def relaxed(
    position: np.ndarray, quads: np.ndarray, guides: Guides, steps: int, progress: Progress
) -> tuple[np.ndarray, np.ndarray]:
    """Positions (n, 3) after so many steps, and the triangles (n,) of the surface they lie on.

    Folded quads are mended after, whatever the number of steps.
    """
    start, position = position, position.copy()
    n = len(position)
    count = np.bincount(quads.ravel(), minlength=n)
    inner = np.ones(len(quads), bool)
    irregular = count != 4
    irregular &= guides.curve < 0
    inner[irregular[quads].any(axis=1)] = False
    together = _Together(quads, ~guides.fixed & (guides.curve < 0), count)
    for step in range(steps):
        progress.step(step / max(steps, 1))
        if step % BETWEEN == 0:
            x, y, triangle = _planes(position, quads, guides)
            plane = x, y, guides.size[triangle]
        wanted = _wanted(position, quads, plane, inner)
        target = _mean(wanted, quads, count)
        together.step(position, wanted)
        _slide(position, target, quads, guides)
        _back(position, quads, together.free, guides)
    mend(position, quads, guides, progress)
    position = _undone(position, start, quads, guides, progress)
    return position, guides.surface(position, vertex_normals(position, quads))[0]


def _undone(
    position: np.ndarray,
    start: np.ndarray,
    quads: np.ndarray,
    guides: Guides,
    progress: Progress,
) -> np.ndarray:
    """Positions (n, 3), those at the start around quads that were not folded there and now are."""
    quality = oriented_quality(position, quads, guides)
    folded = int(np.count_nonzero(quality <= 0.0))
    if not folded:
        return position
    before = oriented_quality(start, quads, guides) <= 0.0
    back = np.zeros(len(position), bool)
    trial, worse = position, (quality <= 0.0) & ~before
    while worse.any():
        grown = back.copy()
        grown[quads[worse]] = True
        grown = with_rings(quads, grown, UNDONE_RINGS)
        if grown.sum() == back.sum():
            break
        back = grown
        trial = np.where(back[:, None], start, position)
        worse = (oriented_quality(trial, quads, guides) <= 0.0) & ~before
    trial = trial.copy()
    mend(trial, quads, guides, progress, STAGES[1:])
    left = int(np.count_nonzero(oriented_quality(trial, quads, guides) <= 0.0))
    return trial if left < folded else position


class _Together:
    """The linear system of all free vertices: sum over the quads of what their corners, from
    their middles, lack to those that are wanted, squared."""

    def __init__(self, quads: np.ndarray, free: np.ndarray, count: np.ndarray) -> None:
        self.quads, self.free = quads, free
        n = len(free)
        one = quads[:, [0, 1, 2, 3] * 4].ravel()
        other = np.repeat(quads, 4, axis=1).ravel()
        value = np.tile((np.eye(4) - 0.25).ravel(), len(quads))
        whole = sparse.coo_array((value, (one, other)), shape=(n, n)).tocsr()
        self._rows = np.flatnonzero(free)
        part = whole[self._rows]
        self._held = part[:, np.flatnonzero(~free)]
        self._stay = STAY * np.maximum(count[self._rows], 1)
        system = part[:, self._rows] + sparse.diags_array(self._stay)
        self._solve = definite_factors(system).solve if len(self._rows) else None

    def step(self, position: np.ndarray, wanted: np.ndarray) -> None:
        """Move the free vertices, in place."""
        if self._solve is None:
            return
        off = wanted - wanted.mean(axis=1, keepdims=True)
        flat = self.quads.ravel()
        right = np.stack(
            [
                np.bincount(flat, off[:, :, axis].ravel(), minlength=len(position))
                for axis in range(3)
            ],
            axis=1,
        )[self._rows]
        right = right - self._held @ position[~self.free]
        position[self._rows] = self._solve(right + self._stay[:, None] * position[self._rows])


def squared(
    position: np.ndarray, quads: np.ndarray, guides: Guides, mapped: Guides, progress: Progress
) -> np.ndarray:
    """Make corners square and turn quads to the directions once more, all at once, in place.

    Rectangles that quads want pull at the squares of what is missing; here it counts as it is, so
    that the means of the worst corners and of angles become best where whole numbers leave no room
    for both. No quad gets worse that is bad, and nothing is done where the mean gets no better.

    Parameters
    ----------
    mapped:
        What has the directions, `guides` where it holds the vertices as well.

    Returns
    -------
    rows:
        (r,) int64 vertices that may have moved.
    """
    movable = ~guides.fixed & ((guides.curve < 0) | (guides.beside >= 0).all(axis=1))
    rows = np.flatnonzero(movable)
    if not len(rows):
        return rows
    progress.step(1.0)
    local = places_in(rows, len(position))[quads]
    x, y, triangle = _planes(position, quads, mapped)
    off = np.degrees(np.abs(_off_axis(_axis(position[quads], x, y)[0])))
    weight = 1.0 if mapped.weight is None else mapped.weight[triangle]
    pull = PULL * weight * np.clip((LEFT - off) / (LEFT - TURNED), 0.0, 1.0)
    axes = move_axes(position, quads, guides, rows)
    problem = Squaring(position[quads], x, y, pull, local, axes, STAYING, LOW)
    by = problem.step()
    before, start = position[rows], oriented_quality(position, quads, guides)
    part = np.ones(len(rows))
    for number in range(HALVINGS):
        moved = moved_along(before, part[:, None] * by, rows, position, quads, guides)
        position[rows] = np.where(part[:, None] > 0.0, moved, before)
        now = oriented_quality(position, quads, guides)
        worse = now < np.minimum(start, SOUND) - ROUNDING
        if not worse.any():
            # What is better in the planes of quads that bend far may not be so on the surface.
            if now.mean() >= start.mean():
                return rows
            part = 0.5 * part
            continue
        near = np.zeros(len(position), bool)
        near[quads[worse]] = True
        near = with_rings(quads, near, 1)[rows]
        part = np.where(near, 0.5 * part if number < HALVINGS // 2 else 0.0, part)
    position[rows] = before
    return rows


def _planes(position: np.ndarray, quads: np.ndarray, guides: Guides) -> tuple[np.ndarray, ...]:
    """(q, 3) two axes along the directions of the surface under each quad, (q,) its triangle
    there."""
    at = position[quads]
    normal = np.cross(at[:, 2] - at[:, 0], at[:, 3] - at[:, 1])
    triangle, _ = guides.surface(at.mean(axis=1), normal)
    around = vertex_normals(position, quads)[quads].sum(axis=1)
    up = own_planes(normal, around, triangle, guides)
    x = guides.direction[triangle]
    x = unit(x - up * np.einsum("qc,qc->q", x, up)[:, None])
    return x, np.cross(up, x), triangle


def _wanted(
    position: np.ndarray, quads: np.ndarray, plane: tuple[np.ndarray, ...], inner: np.ndarray
) -> np.ndarray:
    """(q, 4, 3) corners of the rectangle that each quad wants."""
    x, y, size = plane
    at = position[quads]
    centre = at.mean(axis=1, keepdims=True)
    # The angle of the nearest rectangle, then towards the nearest axis.
    axis, first, second = _axis(at, x, y)
    off_axis = _off_axis(axis)
    share = (np.radians(LEFT) - np.abs(off_axis)) / np.radians(LEFT - TURNED)
    share = np.where(inner, np.clip(share, 0.0, 1.0), 0.0)
    axis = axis * np.exp(-1j * np.clip(off_axis, -np.radians(TURN), np.radians(TURN)) * share)
    width = np.maximum((first * axis.conj()).real, 0.0)
    height = np.maximum((second * (1j * axis).conj()).real, 0.0)
    typical = size * np.median(np.concatenate([width / size, height / size]))
    width, height = (
        np.maximum(side + EVEN * (typical - side), LEAST_SIDE * typical) for side in (width, height)
    )
    a, b = 0.5 * axis * width, 0.5j * axis * height
    corner = np.stack([-a - b, a - b, a + b, b - a], axis=1)
    return centre + corner.real[:, :, None] * x[:, None] + corner.imag[:, :, None] * y[:, None]


def _axis(
    at: np.ndarray, x: np.ndarray, y: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(q,) complex in the axes x and y (q, 3): the first side of the rectangle nearest to each
    quad, of length 1, and the two middle lines of the quad (q, 4, 3)."""
    z = np.einsum("qkc,qc->qk", at, x) + 1j * np.einsum("qkc,qc->qk", at, y)
    first = 0.5 * (z[:, 1] - z[:, 0] + z[:, 2] - z[:, 3])
    second = 0.5 * (z[:, 3] - z[:, 0] + z[:, 2] - z[:, 1])
    axis = first - 1j * second
    return axis / np.maximum(np.abs(axis), np.finfo(float).tiny), first, second


def _off_axis(axis: np.ndarray) -> np.ndarray:
    """(q,) radians to the nearest of the axes."""
    angle = np.angle(axis)
    return angle - QUARTER * np.rint(angle / QUARTER)


def _mean(wanted: np.ndarray, quads: np.ndarray, count: np.ndarray) -> np.ndarray:
    """(n, 3) mean of what the quads at each vertex want."""
    flat = quads.ravel()
    total = [
        np.bincount(flat, wanted[:, :, axis].ravel(), minlength=len(count)) for axis in range(3)
    ]
    return np.stack(total, axis=1) / np.maximum(count, 1)[:, None]


def _slide(position: np.ndarray, target: np.ndarray, quads: np.ndarray, guides: Guides) -> None:
    """One step of the vertices on curves towards `target` (n, 3), in place."""
    sliding = np.flatnonzero((guides.curve >= 0) & ~guides.fixed & (guides.beside >= 0).all(axis=1))
    if not len(sliding):
        return
    between = position[guides.beside[sliding]].mean(axis=1)
    step = RATE * (0.5 * target[sliding] + 0.5 * between - position[sliding])
    position[sliding] = moved_along(position[sliding], step, sliding, position, quads, guides)


def _back(position: np.ndarray, quads: np.ndarray, free: np.ndarray, guides: Guides) -> None:
    """Put the free vertices on the surface, in place."""
    normals = vertex_normals(position, quads)[free]
    position[free] = guides.surface(position[free], normals)[1]
