"""Crosses in the triangles of a connected surface and the quarter turns between them.

Each triangle is laid into the complex plane with one direction of its cross along the real axis,
in units of the length that an edge of a quad shall have there. Across an edge the coordinates of
the neighbour follow by a quarter turn, the *matching* (Bommer et al. 2009,
10.1145/1531326.1531383), and a small rest. The matchings around a vertex say how many quarter
turns the quads make there: four at regular vertices, three or five at poles.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from ....base.plane import corner_angles
from ....base.unit import unit
from ....mesh.half_edges import previous

QUARTER = 0.5 * np.pi
# 1, i, -1, -i: multiplication turns by so many right angles, exactly.
TURNS = np.array([1.0, 1j, -1.0, -1j])


@dataclass(frozen=True)
class Crosses:
    """Crosses on one connected oriented manifold of n vertices and m triangles.

    Attributes
    ----------
    vertices, triangles, twin:
        (n, 3) float64, (m, 3) int64 and (3 m,) int64 as of a `Surface`.
    direction, normal:
        (m, 3) float64 one direction of each triangle's cross, and its unit normal.
    size:
        (m,) float64 length that an edge of a quad shall have.
    feature:
        (3 m,) bool half-edges that edges of quads run along, borders among them.
    matching:
        (3 m,) int64 quarter turns that take coordinates in the triangle to those in the one
        across each half-edge; 0 on borders.
    rest:
        (3 m,) float64 what a cross turns across each half-edge beyond its matching, counted
        through where it is more than a half turn.
    """

    vertices: np.ndarray
    triangles: np.ndarray
    twin: np.ndarray
    direction: np.ndarray
    normal: np.ndarray
    size: np.ndarray
    feature: np.ndarray
    matching: np.ndarray
    rest: np.ndarray

    @cached_property
    def corner(self) -> np.ndarray:
        """(m, 3) complex128 corners in the triangles' coordinates, the first at 0."""
        other = np.cross(self.normal, self.direction)
        at = self.vertices[self.triangles]
        at = at - at[:, :1]
        x = np.einsum("mkc,mc->mk", at, self.direction)
        y = np.einsum("mkc,mc->mk", at, other)
        return (x + 1j * y) / self.size[:, None]

    @cached_property
    def tail(self) -> np.ndarray:
        """(3 m,) int64 vertex that each half-edge starts at."""
        return self.triangles.ravel()

    @cached_property
    def head(self) -> np.ndarray:
        """(3 m,) int64 vertex that each half-edge ends at."""
        return self.triangles[:, [1, 2, 0]].ravel()

    @cached_property
    def inner(self) -> np.ndarray:
        """(h,) int64 half-edges with a neighbour."""
        return np.flatnonzero(self.twin >= 0)

    @cached_property
    def border(self) -> np.ndarray:
        """(n,) bool vertices on an open border."""
        found = np.zeros(len(self.vertices), bool)
        edges = self.twin < 0
        found[self.tail[edges]] = found[self.head[edges]] = True
        return found

    @cached_property
    def on_feature(self) -> np.ndarray:
        """(n,) bool vertices on a feature or border."""
        found = np.zeros(len(self.vertices), bool)
        found[self.tail[self.feature]] = found[self.head[self.feature]] = True
        return found

    @cached_property
    def corner_angle(self) -> np.ndarray:
        """(3 m,) float64 angle of the triangle at each corner."""
        return corner_angles(self.corner)

    @cached_property
    def quarter_turns(self) -> np.ndarray:
        """(n,) int64 quarter turns that the quads make about each inner vertex, 4 where regular.

        The angles of the triangles and the rests sum to a whole number of right angles.
        """
        count = len(self.vertices)
        total = np.bincount(self.tail, weights=self.corner_angle, minlength=count)
        # A half-edge that leaves a vertex is crossed clockwise around it.
        total -= np.bincount(self.tail, weights=self.rest, minlength=count)
        return np.where(self.border, 4, np.rint(total / QUARTER).astype(np.int64))

    @cached_property
    def singular(self) -> np.ndarray:
        """(n,) bool inner vertices, off features, whose quads make other than four turns."""
        return (self.quarter_turns != 4) & ~self.border & ~self.on_feature

    def matched(self, matching: np.ndarray) -> Crosses:
        """The same crosses with other matchings."""
        rest = self.rest + QUARTER * (self.matching - matching)
        return replace(self, matching=matching, rest=rest)

    def turned(self, angle: np.ndarray) -> Crosses:
        """The crosses turned by angles (m,), their matchings as they are."""
        other = np.cross(self.normal, self.direction)
        direction = np.cos(angle)[:, None] * self.direction + np.sin(angle)[:, None] * other
        rest = self.rest.copy()
        rest[self.inner] += angle[self.inner // 3] - angle[self.twin[self.inner] // 3]
        return replace(self, direction=direction, rest=rest)


def crosses(
    vertices: np.ndarray,
    triangles: np.ndarray,
    twin: np.ndarray,
    direction: np.ndarray,
    size: np.ndarray,
    feature: np.ndarray,
) -> Crosses:
    """Crosses with the matchings that turn them least; see `Crosses` for the arguments."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    normal = unit(np.cross(b - a, c - a))
    direction = unit(direction - normal * np.einsum("mc,mc->m", direction, normal)[:, None])
    twin = twin.astype(np.int64)
    none, zero = np.zeros(len(twin), np.int64), np.zeros(len(twin))
    feature = feature | (twin < 0)
    triangles = triangles.astype(np.int64)
    plain = Crosses(vertices, triangles, twin, direction, normal, size, feature, none, zero)
    lower = plain.inner[plain.inner < twin[plain.inner]]
    turn = _turn(plain.corner, twin)[lower]
    rest, matching = zero.copy(), none.copy()
    rest[lower], matching[lower] = turn, np.rint(turn / QUARTER).astype(np.int64)
    rest[twin[lower]], matching[twin[lower]] = -rest[lower], -matching[lower]
    return replace(plain, rest=rest).matched(matching)


def distances(crosses: Crosses, vertices: np.ndarray, limit: float = np.inf) -> np.ndarray:
    """(n,) how far it is along edges from the nearest of `vertices` (v,), in lengths of quads;
    infinite beyond a limit, and without any."""
    n = len(crosses.vertices)
    if not len(vertices):
        return np.full(n, np.inf)
    length = np.linalg.norm(crosses.vertices[crosses.head] - crosses.vertices[crosses.tail], axis=1)
    length = length / np.repeat(crosses.size, 3) + 1e-9
    graph = sparse.coo_array((length, (crosses.tail, crosses.head)), shape=(n, n)).tocsr()
    return np.asarray(csgraph.dijkstra(graph, indices=vertices, limit=limit, min_only=True))


def fans(twin: np.ndarray, stop: np.ndarray, first: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The corners met anticlockwise from each of `first`, up to a half-edge that stops or around.

    Parameters
    ----------
    stop:
        (3 m,) bool half-edges that a fan does not cross.
    first:
        (f,) int64 half-edges; a fan starts in the triangle of each, at its tail.

    Returns
    -------
    corner, start:
        (c,) int64 corners of all fans and (f + 1,) int64 where each of them starts.
    """
    steps = [first]
    rows = np.arange(len(first))
    owner = [rows]
    current, origin = first, first
    while len(current):
        back = previous(current)
        going = ~stop[back] & (twin[back] >= 0)
        rows, origin, current = rows[going], origin[going], twin[back[going]]
        going = current != origin
        rows, origin, current = rows[going], origin[going], current[going]
        steps.append(current)
        owner.append(rows)
    corner, owner_of = np.concatenate(steps), np.concatenate(owner)
    order = np.argsort(owner_of, kind="stable")
    start = np.concatenate([[0], np.cumsum(np.bincount(owner_of, minlength=len(first)))])
    return corner[order], start


def _turn(corner: np.ndarray, twin: np.ndarray) -> np.ndarray:
    """(3 m,) float64 angle from a triangle's coordinates to its neighbour's; 0 on borders."""
    edge = (np.roll(corner, -1, axis=1) - corner).ravel()
    turn = np.zeros(len(twin))
    inner = np.flatnonzero(twin >= 0)
    turn[inner] = np.angle(-edge[twin[inner]] * edge[inner].conj())
    return turn
