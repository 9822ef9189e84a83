"""Opening folded and flat quads: their vertices and those around move together until every corner
is well open.

What the sines of the corners miss, squared, is summed over the neighbourhoods of bad quads and
minimized over the tangent planes of their vertices, those on features along them
(optimization-based smoothing: Freitag & Ollivier-Gooch 1997, 10.1002/(SICI)1097-0207(19971115)
40:21<3979::AID-NME251>3.0.CO;2-9; all vertices at once, by limited-memory quasi-Newton steps).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from ....base.progress import Progress
from ....base.subsets import places_in
from ....base.unit import unit
from ....mesh.rings import with_rings
from ..conformity import scaled_jacobian
from .guides import Guides, moved_along, surface_axes, vertex_normals

# A quad is bad below the first scaled Jacobian; corners are opened up to the second.
SOUND, WANTED = 0.6, 0.7
# Sides are not left shorter than this part of the mean, and that counts so much.
LEAST_SIDE, SIDE_WEIGHT = 0.2, 4.0
# How much a move by the mean side costs beside a corner that misses all.
STAY = 0.02
# Rounds, rings around bad quads that move in the first and the most, and steps in each round.
ROUNDS, FIRST_RINGS, MOST_RINGS, STEPS = 10, 2, 5, 40
# A vertex moves by this part of the mean side at most in a round.
FARTHEST = 0.7
# A round's move is halved so often while it makes things worse.
HALVINGS = 3
TINY = 1e-30


def mend(position: np.ndarray, quads: np.ndarray, guides: Guides, progress: Progress) -> None:
    """Move the vertices around bad quads, in place, while that makes them better."""
    movable = ~guides.fixed & ((guides.curve < 0) | (guides.beside >= 0).all(axis=1))
    rings = FIRST_RINGS
    for _ in range(ROUNDS):
        progress.step(1.0)
        quality = oriented_quality(position, quads, guides)
        bad = quality < SOUND
        if not bad.any():
            return
        near = np.zeros(len(position), bool)
        near[quads[bad]] = True
        near = with_rings(quads, near, rings)
        rows = np.flatnonzero(near & movable)
        mine = np.flatnonzero(near[quads].any(axis=1))
        if not len(rows):
            return
        step = _Opening(position, quads[mine], guides, rows).step()
        if not _applied(position, quads[mine], guides, rows, step):
            if rings == MOST_RINGS:
                return
            rings = MOST_RINGS


def oriented_quality(position: np.ndarray, quads: np.ndarray, guides: Guides) -> np.ndarray:
    """(q,) scaled Jacobians, negative where a quad faces against the surface."""
    at = position[quads]
    normal = np.cross(at[:, 2] - at[:, 0], at[:, 3] - at[:, 1])
    around = vertex_normals(position, quads)[quads].sum(axis=1)
    triangle, _ = guides.surface(at.mean(axis=1), around)
    against = np.einsum("qc,qc->q", guides.surface.normal[triangle], normal) < 0.0
    quality = scaled_jacobian(position, quads)
    return np.where(against, -np.abs(quality) - 1e-6, quality)


def _applied(
    position: np.ndarray, quads: np.ndarray, guides: Guides, rows: np.ndarray, step: np.ndarray
) -> bool:
    """Move the vertices by the step or a part of it, in place, if that is better at all."""
    before = position[rows]
    missing = _missing(position, quads, guides)
    for halving in range(HALVINGS):
        position[rows] = moved_along(before, step * 0.5**halving, rows, position, quads, guides)
        if _missing(position, quads, guides) < missing:
            return True
        position[rows] = before
    return False


def _missing(position: np.ndarray, quads: np.ndarray, guides: Guides) -> float:
    quality = oriented_quality(position, quads, guides)
    return float((np.maximum(WANTED - quality, 0.0) ** 2).sum())


@dataclass
class _Axes:
    """(r, 3) directions in which vertices may move, the second 0 on features."""

    x: np.ndarray
    y: np.ndarray


class _Opening:
    """The problem of one round: unknowns are moves in the axes, in mean sides."""

    def __init__(
        self, position: np.ndarray, quads: np.ndarray, guides: Guides, rows: np.ndarray
    ) -> None:
        self.base = position[quads]
        self.up = surface_axes(self.base, vertex_normals(position, quads)[quads], guides)
        side = np.linalg.norm(np.roll(self.base, -1, axis=1) - self.base, axis=2)
        self.side = max(float(side.mean()), TINY)
        self.local = places_in(rows, len(position))[quads]
        self.moves = self.local >= 0
        self.axes, self.most = self._axes(position, quads, guides, rows)

    def _axes(
        self, position: np.ndarray, quads: np.ndarray, guides: Guides, rows: np.ndarray
    ) -> tuple[_Axes, np.ndarray]:
        normal = unit(vertex_normals(position, quads)[rows])
        least = np.eye(3)[np.abs(normal).argmin(axis=1)]
        x = unit(np.cross(normal, least))
        y = np.cross(normal, x)
        most = np.full(len(rows), FARTHEST)
        held = np.flatnonzero(guides.curve[rows] >= 0)
        ends = position[guides.beside[rows[held]]]
        x[held] = unit(ends[:, 1] - ends[:, 0])
        y[held] = 0.0
        return _Axes(x, y), most

    def step(self) -> np.ndarray:
        """(r, 3) the move of each vertex."""
        start = np.zeros(2 * len(self.most))
        bound = np.repeat(self.most, 2)
        found = minimize(
            self._value,
            start,
            jac=True,
            method="L-BFGS-B",
            bounds=np.column_stack([-bound, bound]),
            options={"maxiter": STEPS},
        )
        return self._moved(found.x)

    def _moved(self, unknown: np.ndarray) -> np.ndarray:
        by = self.side * unknown.reshape(-1, 2)
        return by[:, :1] * self.axes.x + by[:, 1:] * self.axes.y

    def _value(self, unknown: np.ndarray) -> tuple[float, np.ndarray]:
        """The sum that is minimized, and its gradient."""
        at = self.base.copy()
        at[self.moves] += self._moved(unknown)[self.local[self.moves]]
        out = np.roll(at, -1, axis=1) - at
        back = np.roll(at, 1, axis=1) - at
        length = np.sqrt((out**2).sum(axis=2) + (1e-4 * self.side) ** 2)
        before = np.roll(length, 1, axis=1)
        up = self.up[:, None]
        sine = np.einsum("qkc,qkc->qk", np.cross(out, back), np.broadcast_to(up, out.shape))
        sine /= length * before
        open_ = np.maximum(WANTED - sine, 0.0)
        short = np.maximum(LEAST_SIDE - length / self.side, 0.0)
        value = (open_**2).sum() + SIDE_WEIGHT * (short**2).sum() + STAY * (unknown**2).sum()
        # By the two sides at each corner, the one that leaves and the one back.
        by_sine = (-2.0 * open_ / (length * before))[:, :, None]
        turn = (2.0 * open_ * sine)[:, :, None]
        by_out = by_sine * np.cross(back, up) + turn * out / (length**2)[:, :, None]
        by_back = by_sine * np.cross(up, out) + turn * back / (before**2)[:, :, None]
        by_out -= (2.0 * SIDE_WEIGHT / self.side * short / length)[:, :, None] * out
        force = np.roll(by_out, 1, axis=1) + np.roll(by_back, -1, axis=1) - by_out - by_back
        local = self.local[self.moves]
        count = len(self.most)
        total = np.stack(
            [np.bincount(local, force[..., k][self.moves], minlength=count) for k in range(3)],
            axis=1,
        )
        slope = np.stack([(total * self.axes.x).sum(axis=1), (total * self.axes.y).sum(axis=1)], 1)
        return float(value), self.side * slope.ravel() + 2.0 * STAY * unknown
