"""Which vertices lie around each vertex: rings grown by sparse products, in blocks."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from .surface import Surface

# A cubic has ten coefficients; half as many samples again keep the fit from chasing noise.
FEWEST_SAMPLES = 15
# A length that spans more rings than this is beyond what a cubic describes.
MOST_RINGS = 24


def adjacency(surface: Surface) -> sparse.csr_array:
    """The (n, n) one-ring graph of the surface, ones where two vertices share an edge."""
    n = len(surface.vertices)
    ones = np.ones(len(surface.neighbours), np.int32)
    return sparse.csr_array((ones, surface.neighbours, surface.neighbour_start), shape=(n, n))


def grow(reach: sparse.csr_array, graph: sparse.csr_array, rings: int) -> sparse.csr_array:
    """Each row of `reach` lists vertices; add those within `rings` edges of them, all once.

    On a surface every edge has a triangle, so a walk of exactly that many edges (two or more)
    reaches the nearer vertices too.
    """
    for _ in range(rings):
        reach = reach @ graph
        reach.data[:] = 1
    return reach


@dataclass(frozen=True)
class Neighbourhood:
    """What the height function at a vertex is fitted to.

    Attributes
    ----------
    surface:
        The surface; n vertices.
    graph:
        (n, n) its one-ring graph.
    walls:
        (n,) bool, vertices on creases: they are samples, but no ring grows past them; None
        where there are no creases.
    rings:
        Rings of neighbours, at least 2; more where these hold too few vertices.
    reach:
        Length that the rings must cover and samples beyond it are left out; None for none.
    focused:
        Weigh near samples more: least bias, for clean meshes. Equal weights hold noise best.
    stretch:
        Length over width of the triangles. Above 1 as many samples as the rings of an even mesh
        hold, the nearest of more rings, stand for the rings, which would be as stretched.
    """

    surface: Surface
    graph: sparse.csr_array
    walls: np.ndarray | None = None
    rings: int = 2
    reach: float | None = None
    focused: bool = True
    stretch: float = 1.0

    def around_triangles(
        self, corners: np.ndarray, rings: int, most: int
    ) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """The samples around triangles (r, 3) of vertices, in blocks as those of `blocks`."""
        reach = self._around(selection(corners, self.graph.shape[0]), self._grown(rings))
        for rows, members in by_size(reach, most):
            if self.stretch > 1.0:
                points = self.surface.vertices[corners[rows]].mean(axis=1)
                members = self._nearest(members, points, rings)
            yield rows, members

    def _grown(self, rings: int) -> int:
        """Rings that hold the nearest samples of as many rings of an even mesh."""
        if self.stretch <= 1.0:
            return rings
        # A tenth of a ring more would not be worth the whole of one.
        return int(np.ceil(rings * np.sqrt(self.stretch) - 0.1))

    def _around(self, start: sparse.csr_array, rings: int) -> sparse.csr_array:
        """Rows of `start` grown by rings, stopping at walls."""
        if self.walls is None:
            return grow(start, self.graph, rings)
        passable = sparse.diags_array((~self.walls).astype(np.int32), dtype=np.int32)
        through = (passable @ self.graph).tocsr()
        # A wall vertex still sees its own ring, on both of its sides.
        reach = start + start @ self.graph
        for _ in range(rings - 1):
            reach = (reach + reach @ through).tocsr()
            reach.data[:] = 1
        return reach

    def blocks(self, centres: np.ndarray, most: int) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """The samples of each of the vertices `centres`, in blocks of equal size.

        Yields
        ------
        rows:
            (b,) rows of `centres`, with b * s <= `most` (at least one row).
        members:
            (s, b) intp samples of each.
        """
        pending = np.arange(len(centres))
        count = self.rings
        sizes = np.zeros(len(centres), int)
        # Small neighbourhoods grow ring by ring until they suffice or hold a whole component.
        while len(pending):
            reach = self._ring_rows(centres[pending], self._grown(count))
            grown = np.diff(reach.indptr)
            if self.stretch > 1.0:
                grown = np.minimum(grown, _even_count(count))
            ready = (grown >= FEWEST_SAMPLES) | (grown == sizes)
            if self.reach is not None:
                reach, covered = self._within_reach(reach, centres[pending])
                ready &= covered | (grown == sizes) | (count >= MOST_RINGS)
            if ready.all():
                enough, chosen = reach, pending
            else:
                enough, chosen = reach[ready], pending[ready]
            for rows, members in by_size(enough, most):
                rows = chosen[rows]
                if self.stretch > 1.0:
                    points = self.surface.vertices[centres[rows]]
                    members = self._nearest(members, points, count)
                yield rows, members
            pending, sizes = pending[~ready], grown[~ready]
            count += 1

    def _ring_rows(self, centres: np.ndarray, count: int) -> sparse.csr_array:
        if self.walls is None:
            return grow(self.graph[centres], self.graph, count - 1)
        return self._around(selection(centres[:, None], self.graph.shape[0]), count)

    def _within_reach(
        self, reach: sparse.csr_array, centres: np.ndarray
    ) -> tuple[sparse.csr_array, np.ndarray]:
        """Samples within the length `reach` (but not fewer than needed), and whether the rings
        went as far as that."""
        points = self.surface.vertices
        row = np.repeat(np.arange(len(centres)), np.diff(reach.indptr))
        distance = np.sqrt(_squares(points, reach.indices, points[centres[row]]))
        # One key for row and distance: several times faster to sort than two.
        largest = distance.max(initial=np.finfo(float).tiny)
        order = np.argsort(row + distance / (1.001 * largest))
        rank = np.arange(len(row)) - reach.indptr[row]
        distance, members = distance[order], reach.indices[order]
        covered = distance[reach.indptr[1:] - 1] >= self.reach
        keep = (distance <= self.reach) | (rank < FEWEST_SAMPLES)
        start = np.append(0, np.cumsum(keep))[reach.indptr]
        ones = np.ones(int(start[-1]), np.int32)
        return sparse.csr_array((ones, members[keep], start), shape=reach.shape), covered

    def _nearest(self, members: np.ndarray, points: np.ndarray, rings: int) -> np.ndarray:
        """Of the samples (s, b) as many as so many rings of an even mesh hold, those nearest to
        the points (b, 3)."""
        count = _even_count(rings)
        if len(members) <= count:
            return members
        square = _squares(self.surface.vertices, members.T, points[:, None])
        nearest = np.argpartition(square, count - 1, axis=1)[:, :count]
        return np.ascontiguousarray(np.take_along_axis(members, nearest.T, axis=0))


def _even_count(rings: int) -> int:
    """Vertices of so many rings where six edges meet, the middle one among them."""
    return 1 + 3 * rings * (rings + 1)


def _squares(vertices: np.ndarray, members: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Squared distances of vertices from points, shape (..., 3)."""
    square = np.zeros(members.shape)
    for vertex, point in zip(vertices.T, np.moveaxis(points, -1, 0), strict=True):
        square += (vertex[members] - point) ** 2
    return square


def selection(vertices: np.ndarray, count: int) -> sparse.csr_array:
    """(r, count) matrix whose rows hold ones at the vertices (r, s) named in each row."""
    rows, size = vertices.shape
    return sparse.csr_array(
        (np.ones(vertices.size, np.int32), vertices.ravel(), size * np.arange(rows + 1)),
        shape=(rows, count),
    )


def by_size(reach: sparse.csr_array, most: int) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """The rows of `reach`, gathered into blocks of equal size.

    Yields
    ------
    rows:
        (b,) rows of `reach`, with b * size <= `most` (at least one row).
    members:
        (size, b) intp vertices of each row.
    """
    sizes = np.diff(reach.indptr)
    order = np.argsort(sizes, kind="stable")
    ends = np.cumsum(np.bincount(sizes)) if len(sizes) else np.zeros(0, int)
    begin = 0
    for size, end in enumerate(ends):
        step = max(most // max(size, 1), 1)
        for low in range(begin, end, step):
            rows = order[low : min(low + step, end)]
            if size:
                # NumPy gathers by its own integers several times faster than by others.
                slots = reach.indptr[rows] + np.arange(size, dtype=np.intp)[:, None]
                yield rows, reach.indices[slots].astype(np.intp)
        begin = end
