"""Triangles on the way to be mapped: splitting marked edges, taking pieces apart."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from ....mesh.half_edges import edge_keys, ends_of
from ....mesh.mending.repair import clean

# What a half-edge may be, as bits: along a crease that was found, along an edge that a user marked.
CREASE_BIT, MARK_BIT = 1, 2


@dataclass(frozen=True)
class Triangles:
    """Triangles with what belongs to their vertices and edges.

    Attributes
    ----------
    vertices, triangles:
        (n, 3) float64 and (m, 3) int64.
    values:
        (n, k) float64 carried along with the vertices; the mean of the ends at a middle.
    source:
        (m,) int64 where each triangle came from.
    feature:
        (3 m,) int8 what each half-edge is part of, `CREASE_BIT` and `MARK_BIT`, alike for both of
        an edge; 0 off features.
    """

    vertices: np.ndarray
    triangles: np.ndarray
    values: np.ndarray
    source: np.ndarray
    feature: np.ndarray

    @property
    def ends(self) -> tuple[np.ndarray, np.ndarray]:
        """(3 m,) vertices that the half-edges start and end at."""
        return ends_of(self.triangles)

    @property
    def area(self) -> float:
        """Of all triangles together."""
        a, b, c = (self.vertices[self.triangles[:, k]] for k in range(3))
        return 0.5 * float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())

    @property
    def lengths(self) -> np.ndarray:
        """(3 m,) float64 of the half-edges."""
        tail, head = self.ends
        return np.linalg.norm(self.vertices[head] - self.vertices[tail], axis=1)


def split_edges(mesh: Triangles, marked: np.ndarray, share: np.ndarray | None = None) -> Triangles:
    """The mesh with the marked edges (3 m,) split, both half-edges of each being marked.

    They are split in their middles, or at `share` (3 m,) of the way from tail to head.
    """
    if not marked.any():
        return mesh
    n = len(mesh.vertices)
    tail, head = mesh.ends
    half = np.flatnonzero(marked)
    key = edge_keys(tail[half], head[half], n)
    edge, first, number = np.unique(key, return_index=True, return_inverse=True)
    one, two = edge // n, edge % n
    part = np.full((len(edge), 1), 0.5)
    if share is not None:
        from_tail = share[half[first]]
        part[:, 0] = np.where(tail[half[first]] == one, from_tail, 1.0 - from_tail)
    middle = np.full(len(marked), -1)
    middle[half] = n + number
    vertices, values = (
        np.concatenate([of, (1.0 - part) * of[one] + part * of[two]])
        for of in (mesh.vertices, mesh.values)
    )
    marks, middles = marked.reshape(-1, 3), middle.reshape(-1, 3)
    feature = mesh.feature.reshape(-1, 3)
    number_marked = marks.sum(axis=1)
    whole = number_marked == 0
    pieces, origin, edges = [mesh.triangles[whole]], [mesh.source[whole]], [feature[whole]]
    for count in (1, 2, 3):
        rows = np.flatnonzero(number_marked == count)
        if not len(rows):
            continue
        # Turned so that the first side is marked and, of two, the last is not.
        if count == 1:
            first = marks[rows].argmax(axis=1)
        elif count == 2:
            first = (marks[rows].argmin(axis=1) + 1) % 3
        else:
            first = np.zeros(len(rows), np.int64)
        turned = (first[:, None] + np.arange(3)) % 3
        corner, split, kind = (
            of[rows[:, None], turned] for of in (mesh.triangles, middles, feature)
        )
        for corners, sides in _parts(vertices, corner, split, kind, count):
            pieces.append(np.column_stack(corners))
            edges.append(np.column_stack(sides))
            origin.append(mesh.source[rows])
    return Triangles(
        vertices,
        np.concatenate(pieces).astype(np.int64),
        values,
        np.concatenate(origin),
        np.concatenate(edges).ravel(),
    )


def _parts(
    vertices: np.ndarray, corner: np.ndarray, middle: np.ndarray, feature: np.ndarray, count: int
) -> list[tuple[tuple[np.ndarray, ...], tuple[np.ndarray, ...]]]:
    """The parts of triangles abc whose first `count` sides are split: corners of each, and the
    features along its sides.

    Parameters
    ----------
    corner, middle, feature:
        (r, 3) vertices at the corners, in the middles of the sides ab, bc and ca (where they are
        split), and what runs along these.
    """
    (a, b, c), (p, q, r), (f, g, h) = corner.T, middle.T, feature.T
    no = np.zeros(len(corner), np.int8)
    if count == 1:
        return [((a, p, c), (f, no, h)), ((p, b, c), (f, g, no))]
    if count == 2:
        # The shorter diagonal of what is left beside the corner.
        across = ((vertices[a] - vertices[q]) ** 2).sum(axis=1)
        other = ((vertices[p] - vertices[c]) ** 2).sum(axis=1)
        short = across < other
        last = np.where(short, q, c), np.where(short, a, p)
        return [
            ((p, b, q), (f, g, no)),
            ((a, p, last[0]), (f, no, np.where(short, no, h))),
            ((last[1], q, c), (no, g, np.where(short, h, no))),
        ]
    return [
        ((a, p, r), (f, no, h)),
        ((p, b, q), (f, g, no)),
        ((r, q, c), (no, g, h)),
        ((p, q, r), (no, no, no)),
    ]


def refined(mesh: Triangles, longest: float, rounds: int, most: int) -> Triangles:
    """Edges longer than `longest` split, in so many rounds at most and until there are more than
    `most` triangles."""
    for _ in range(rounds):
        marked = mesh.lengths > longest
        if not marked.any() or len(mesh.triangles) > most:
            break
        mesh = split_edges(mesh, marked)
    return mesh


def freed(mesh: Triangles, border: np.ndarray, rounds: int = 8) -> Triangles:
    """Every edge off the features that joins two vertices on them split.

    A triangle whose corners all lie on features could not be laid out freely.

    Parameters
    ----------
    border:
        (n,) bool vertices on the border, which counts as a feature.
    """
    for _ in range(rounds):
        tail, head = mesh.ends
        on = np.zeros(len(mesh.vertices), bool)
        on[: len(border)] = border
        along = mesh.feature > 0
        on[tail[along]] = on[head[along]] = True
        marked = on[tail] & on[head] & ~along
        if not marked.any():
            break
        mesh = split_edges(mesh, marked)
    return mesh


def chosen(mesh: Triangles, rows: np.ndarray) -> Triangles:
    """The triangles `rows` (r,) int64 with the vertices that they use."""
    used, corners = np.unique(mesh.triangles[rows], return_inverse=True)
    return Triangles(
        mesh.vertices[used],
        corners.reshape(-1, 3).astype(np.int64),
        mesh.values[used],
        mesh.source[rows],
        mesh.feature.reshape(-1, 3)[rows].ravel(),
    )


def taken_apart(mesh: Triangles) -> Triangles:
    """The mesh with vertices that several fans of triangles meet in, and nothing else, parted."""
    surface, _ = clean(mesh.vertices, mesh.triangles, join_borders=False)
    return Triangles(
        mesh.vertices[surface.source_vertex],
        surface.triangles.astype(np.int64),
        mesh.values[surface.source_vertex],
        mesh.source[surface.source_triangle],
        mesh.feature.reshape(-1, 3)[surface.source_triangle].ravel(),
    )


def pieces(mesh: Triangles) -> list[Triangles]:
    """The connected pieces, in the order of their first triangles."""
    n = len(mesh.vertices)
    tail, head = mesh.ends
    graph = sparse.coo_array((np.ones(len(tail)), (tail, head)), shape=(n, n))
    count, label = csgraph.connected_components(graph, directed=False)
    if count == 1:
        return [mesh]
    owner = label[mesh.triangles[:, 0]]
    order = np.argsort(owner, kind="stable")
    cuts = np.flatnonzero(np.diff(owner[order])) + 1
    return [chosen(mesh, rows) for rows in np.split(order, cuts)]
