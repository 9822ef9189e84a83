"""Moving, parting and cancelling poles in a field of crosses, without a trace elsewhere.

A quarter turn put on the matchings along a path of edges takes a quarter turn from the vertex at
its end and gives it to the one at its start. The crosses then settle to the new matchings by
least squares, held where they were farther away (after Crane, Desbrun & Schroeder 2010,
10.1111/j.1467-8659.2010.01761.x).
"""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from ....base.factors import definite_factors
from ....base.plane import doubled_areas
from .crosses import QUARTER, Crosses, distances, fans
from .sectors import fitting_turns, least_turns, sector_angles, sector_turns

# Opposite poles cancel when they are nearer than this, in lengths of quads; those that part go
# so far, and partners are looked for this far away.
CANCELLED, PARTED, LOOKED = 1.0, 1.0, 3.0
# Crosses are smoothed within this many lengths of quads of a move and give way over this many
# beyond; those along features stay.
SMOOTHED, SETTLED, HELD = 1.5, 3.0, 100.0
# Rounds of moves: one may make another necessary.
ROUNDS = 4


def with_better_poles(
    crosses: Crosses,
    avoided: np.ndarray,
    mirror: np.ndarray | None = None,
    reach: float = 1.0,
    plain: np.ndarray | None = None,
) -> Crosses:
    """The crosses with close opposite poles cancelled, multiple ones parted, corners between
    features opened to a right angle, and poles moved off the vertices `avoided` (n,) bool.

    Borders on vertices `mirror` (n,) bool are a plane of symmetry. Opposite poles cancel at up to
    `reach` times the distance at which they always do, and so do poles and the corners that lack
    what they have too much of. Corners at vertices `plain` (n,) bool get the number of quads that
    their angle is nearest to in any way.
    """
    none = np.zeros(len(crosses.vertices), bool)
    mirror, plain = (none if one is None else one for one in (mirror, plain))
    for _ in range(ROUNDS):
        moves = _Moves(crosses, avoided, least_turns(crosses, mirror))
        moves.open_corners(plain)
        moves.straighten(reach * CANCELLED)
        moves.part()
        moves.cancel(reach * CANCELLED)
        moves.leave()
        if not moves.made:
            break
        crosses = _settled(crosses, moves.matching)
    return crosses


class _Moves:
    """Matchings while poles are moved."""

    def __init__(self, crosses: Crosses, avoided: np.ndarray, least: np.ndarray) -> None:
        self.crosses = crosses
        self.avoided = avoided
        self.least = least
        self.matching = crosses.matching.copy()
        self.turns = crosses.quarter_turns.copy()
        self.free = ~crosses.border & ~crosses.on_feature
        self.made = 0
        length = np.linalg.norm(
            crosses.vertices[crosses.head] - crosses.vertices[crosses.tail], axis=1
        )
        self._length = length / crosses.size[np.arange(len(length)) // 3]
        # Paths run off features and borders; they may start there.
        edge = np.flatnonzero(self.free[crosses.head] & (crosses.twin >= 0))
        n = len(crosses.vertices)
        self._graph = sparse.coo_array(
            (self._length[edge] + 1e-9, (crosses.tail[edge], crosses.head[edge])), shape=(n, n)
        ).tocsr()
        self._name = sparse.coo_array(
            (edge + 1, (crosses.tail[edge], crosses.head[edge])), shape=(n, n)
        ).tocsr()

    def open_corners(self, plain: np.ndarray) -> None:
        edge, turns = sector_turns(self.crosses)
        angle = sector_angles(self.crosses, edge)
        wanted = fitting_turns(angle, turns, self.least[edge], plain[self.crosses.tail[edge]])
        for item in np.flatnonzero(wanted != turns).tolist():
            out = self._inwards(int(edge[item]))
            if out is None:
                continue
            gain = int(np.sign(wanted[item] - turns[item]))
            first = int(self.crosses.head[out])
            for _ in range(abs(int(wanted[item] - turns[item]))):
                found = self._partner(first, gain)
                if found is None:
                    break
                self._turn(out, gain)
                self._along(first, *found, gain)

    def straighten(self, farthest: float) -> None:
        """Give corners with other than the number of quads that their angle is nearest to the
        quarter turn of an opposite pole nearby. Along a torn border they come in pairs, and left
        there many a pair has a piece of the border between them that no map lays forwards."""
        edge, turns = sector_turns(self.crosses.matched(self.matching))
        angle = sector_angles(self.crosses, edge)
        nearest = np.maximum(np.rint(angle / QUARTER).astype(np.int64), self.least[edge])
        for item in np.flatnonzero(nearest != turns).tolist():
            gain = int(np.sign(nearest[item] - turns[item]))
            poles = self.free & ((self.turns - 4) * gain > 0) & ~self.avoided
            out = self._inwards(int(edge[item]))
            if out is None or not poles.any():
                continue
            first = int(self.crosses.head[out])
            distance, before = csgraph.dijkstra(
                self._graph, indices=first, limit=farthest, return_predecessors=True
            )
            distance = np.where(poles, distance, np.inf)
            if np.isfinite(distance).any():
                self._turn(out, gain)
                self._along(first, before, int(distance.argmin()), gain)

    def _inwards(self, edge: int) -> int | None:
        """The half-edge in the middle of the sector that starts at one, of those that lead away
        from features; None where there is none."""
        corner, _ = fans(self.crosses.twin, self.crosses.feature, np.array([edge]))
        # Where all corners but the first begin.
        inside = corner[1:]
        inside = inside[self.free[self.crosses.head[inside]]]
        return int(inside[len(inside) // 2]) if len(inside) else None

    def part(self) -> None:
        for vertex in np.flatnonzero(self.free & ((self.turns < 3) | (self.turns > 5))).tolist():
            gain = 1 if self.turns[vertex] < 3 else -1
            found = self._partner(vertex, gain)
            if found is not None:
                self._along(vertex, *found, gain)

    def cancel(self, farthest: float) -> None:
        threes = np.flatnonzero(self.free & (self.turns == 3))
        fives = np.flatnonzero(self.free & (self.turns == 5))
        if not len(threes) or not len(fives):
            return
        distance, before = csgraph.dijkstra(
            self._graph, indices=threes, limit=farthest, return_predecessors=True
        )
        near = distance[:, fives]
        for item in np.argsort(near, axis=None):
            row, column = divmod(int(item), len(fives))
            if not np.isfinite(near[row, column]):
                break
            three, five = int(threes[row]), int(fives[column])
            if self.turns[three] == 3 and self.turns[five] == 5:
                self._along(three, before[row], five, 1)

    def leave(self) -> None:
        if not self.avoided.any():
            return
        inside = self.free & self.avoided & (self.turns != 4)
        for vertex in np.flatnonzero(inside).tolist():
            distance, before = csgraph.dijkstra(
                self._graph, indices=vertex, return_predecessors=True
            )
            open_ = self.free & ~self.avoided & (self.turns == 4) & np.isfinite(distance)
            if open_.any():
                goal = int(np.where(open_, distance, np.inf).argmin())
                self._along(vertex, before, goal, 4 - int(self.turns[vertex]))

    def _partner(self, vertex: int, gain: int) -> tuple[np.ndarray, int] | None:
        """Where a quarter turn for a vertex comes from: a near pole of the other kind, or a
        regular vertex some way off; with the paths that lead there."""
        distance, before = csgraph.dijkstra(
            self._graph, indices=vertex, limit=LOOKED, return_predecessors=True
        )
        reached = self.free & np.isfinite(distance)
        reached[vertex] = False
        poles = reached & ((self.turns - 4) * gain > 0) & ~self.avoided
        if poles.any():
            return before, int(np.where(poles, distance, np.inf).argmin())
        regular = reached & (self.turns == 4)
        if not regular.any():
            return None
        near = regular & (distance <= PARTED)
        if near.any():
            return before, int(np.where(near, distance, -1.0).argmax())
        return before, int(np.where(regular, distance, np.inf).argmin())

    def _along(self, start: int, before: np.ndarray, goal: int, gain: int = 1) -> None:
        """Give `gain` quarter turns from the vertex `goal` to `start`."""
        at = goal
        while at != start:
            up = int(before[at])
            self._turn(int(self._name[up, at]) - 1, gain)
            at = up

    def _turn(self, edge: int, gain: int) -> None:
        crosses = self.crosses
        self.matching[edge] += gain
        self.matching[crosses.twin[edge]] -= gain
        self.turns[crosses.tail[edge]] += gain
        self.turns[crosses.head[edge]] -= gain
        self.made += 1


def _settled(crosses: Crosses, matching: np.ndarray) -> Crosses:
    """The crosses with new matchings, turned to suit them."""
    m = len(crosses.triangles)
    half = crosses.inner[crosses.inner < crosses.twin[crosses.inner]]
    one, two = half // 3, crosses.twin[half] // 3
    changed = half[matching[half] != crosses.matching[half]]
    # Near the moves crosses become as smooth as they can; elsewhere they only give way.
    distance = distances(crosses, np.unique(crosses.tail[changed]), SMOOTHED)
    near = np.isfinite(distance)[crosses.triangles].any(axis=1)
    moved = crosses.matched(matching)
    jump = QUARTER * (crosses.matching - matching)[half]
    rest = np.where(near[one] & near[two], moved.rest[half], jump)
    # |rest + phi_one - phi_two|^2 over the edges, and weight phi^2 over the triangles.
    row = np.arange(len(half))
    difference = sparse.coo_array(
        (np.repeat([1.0, -1.0], len(half)), (np.tile(row, 2), np.concatenate([one, two]))),
        shape=(len(half), m),
    ).tocsr()
    area = 0.5 * doubled_areas(crosses.corner)
    weight = np.maximum(area, 1e-9) / SETTLED**2
    aligned = crosses.feature.reshape(-1, 3).any(axis=1)
    weight = np.where(aligned, HELD, weight)
    system = (difference.T @ difference + sparse.diags_array(weight)).tocsr()
    phi = definite_factors(system).solve(-(difference.T @ rest))
    # Aligned triangles turn by less than makes another axis the nearest.
    phi = np.where(aligned, np.clip(phi, -0.25 * QUARTER, 0.25 * QUARTER), phi)
    return moved.turned(phi)
