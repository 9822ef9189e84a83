"""Patches of a few vertices, whose means stand for them in wide windows.

Wide windows hold hundreds of vertices. Means of some three or four that lie side by side tell a
height function over many of them as much, at a third of the work, and the windows around vertices
that lie beside each other are put together of cells of such patches instead of ring by ring.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy import sparse

from ..base.parallel import at_once
from ..base.progress import Progress
from ..base.subsets import spans
from ..base.unit import unit
from .rings import Begun, by_size, grow, rings_of, spread
from .surface import Surface

# Vertices in a window over those whose patches make it up: within a patch they tell nothing. On
# noisy ellipsoids of 40,000 and 160,000 vertices errors are so what they are with the vertices.
LOST = 1.05
# Windows that are listed at once; edges from the middle of a cell to its farthest vertices.
LISTED, REACH = 1 << 12, 3
# Vertices that are listed where wider windows will be asked for, over those that are: fifteen rings
# hold 3.3 times as many as eight.
MORE = 3.4


class Patches:
    """The vertices of a surface dealt out to the nearest of some of them, and these to cells.

    Parameters
    ----------
    surface:
        The surface; n vertices.
    normals:
        (n, 3) unit vertex normals.
    graph:
        (n, n) bool, its one-ring graph.

    Attributes
    ----------
    over:
        Vertices spread over the surface in two rounds, which cells and patches lie around.
    normals:
        (n, 3) unit normals without the errors of single ones.
    patch:
        (n,) that of each vertex.
    coordinates:
        (3, p) mean places of the patches.
    size:
        (p,) float64 numbers of their vertices.
    scatter:
        (p,) summed squares of how far these lie from their plane.
    """

    def __init__(
        self, surface: Surface, normals: np.ndarray, graph: sparse.csr_array, progress: Progress
    ) -> None:
        self.over = spread(graph, 2, REACH, progress)
        assert self.over.finer is not None
        self._points = surface.coordinates
        finer, near = self.over.finer.nodes, self.over.finer.near
        p, c = len(finer), len(self.over.nodes)
        self.normals, self.patch = at_once(
            lambda: smoothed(surface, normals, self.over.near),
            lambda: _nearest(self._points, self._points[:, finer], near),
        )
        patch = self.patch
        size = np.bincount(patch, minlength=p)
        sums = [np.bincount(patch, along, minlength=p) for along in self._points]
        self.size, self.coordinates = size.astype(float), np.stack(sums) / size
        height = np.zeros(len(patch))
        upwards = self.normals[finer].T
        for here, middle, up in zip(self._points, self.coordinates, upwards, strict=True):
            height += (here - middle.take(patch)) * up.take(patch)
        self.scatter = np.bincount(patch, np.square(height), minlength=p)
        self._places = self._points[:, self.over.nodes]
        cell = _nearest(self.coordinates, self._places, self.over.near[finer])
        self._cell = cell[patch].astype(np.int32)
        self._order = np.argsort(cell, kind="stable")
        self._held = np.bincount(cell, minlength=c)
        self._start = np.cumsum(self._held) - self._held
        one = np.repeat(self._cell, np.diff(surface.neighbour_start))
        other = self._cell.take(surface.neighbours)
        # Every edge once: each is listed from both of its ends.
        across = np.flatnonzero(one < other)
        ends = one.take(across), other.take(across)
        upper = sparse.coo_array((np.ones(len(across), bool), ends), shape=(c, c)).tocsr()
        # Which cells a cell is beside, itself among them.
        self._graph = (upper + upper.T + sparse.eye_array(c, dtype=bool)).tocsr()

    def windows(
        self,
        centres: np.ndarray,
        held: int,
        stretch: float,
        most: int,
        progress: Progress | None = None,
        begun: Begun | None = None,
    ) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """The patches nearest to each of the vertices `centres` (r,) that hold so many vertices
        where they are as large everywhere, in blocks as those of `Neighbourhood.blocks`; triangles
        are `stretch` times as long as wide. `begun` keeps more for the next scale."""
        if begun is None:
            found = self._near(centres, held, stretch, progress)
        else:
            found = self._ordered(centres, held, stretch, progress, begun)
        for rows, window in found:
            for some, members in by_size(window, most):
                yield rows[some], members

    def _count(self, held: float) -> int:
        return max(round(LOST * held / float(self.size.mean())), 1)

    def _near(
        self, centres: np.ndarray, held: float, stretch: float, progress: Progress | None
    ) -> Iterator[tuple[np.ndarray, sparse.csr_array]]:
        """Rows of centres (r,), and (r, p) the patches in the windows of `windows`."""
        # As many as touch a disc of that many vertices: the disc, and a cell farther all around.
        cells = (np.sqrt(held / (self.size.mean() * self._held.mean())) + 1.0) ** 2
        rings = rings_of(stretch * cells)
        for low in range(0, len(centres), LISTED):
            some = centres[low : low + LISTED]
            around = self._graph[self._cell[some]]
            for part, reach in grow(around, self._graph, rings - 1, progress):
                middles = self._points[:, some[part]]
                listed = self._listed(middles, reach, int(np.ceil(cells)))
                yield low + part, _nearest_of(self.coordinates, middles, listed, self._count(held))

    def _ordered(
        self,
        centres: np.ndarray,
        held: int,
        stretch: float,
        progress: Progress | None,
        begun: Begun,
    ) -> Iterator[tuple[np.ndarray, sparse.csr_array]]:
        """As `_near`, from lists of more with the nearest first."""
        key = centres.tobytes()
        most, lists = begun.nearest.get(key, (0, []))
        if most < held:
            most, lists = MORE * held, []
            for rows, window in self._near(centres, most, stretch, progress):
                square = _squares(self.coordinates, self._points[:, centres[rows]], window)
                place, there = _padded(window)
                away = np.where(there, square.take(place, mode="clip"), np.inf)
                place = window.indptr[:-1, None] + np.argsort(away, axis=1, kind="stable")
                lists.append((rows, window.indices[place[there]], np.diff(window.indptr)))
            begun.nearest[key] = most, lists
        for rows, members, length in lists:
            taken = np.minimum(length, self._count(held))
            some = members[spans(np.cumsum(length) - length, taken)]
            start = np.append(0, np.cumsum(taken))
            shape = len(rows), len(self.size)
            yield rows, sparse.csr_array((np.ones(len(some), bool), some, start), shape=shape)

    def _listed(
        self, middles: np.ndarray, reach: sparse.csr_array, asked: int
    ) -> sparse.csr_array:
        """(r, p) the patches of so many of the cells (r, c), those nearest to places (3, r)."""
        near = _nearest_of(self._places, middles, reach, asked)
        held = self._held[near.indices]
        members = self._order.take(spans(self._start[near.indices], held))
        start = np.append(0, np.cumsum(held))[near.indptr]
        shape = len(start) - 1, len(self.size)
        return sparse.csr_array((np.ones(len(members), bool), members, start), shape=shape)


def smoothed(surface: Surface, normals: np.ndarray, near: sparse.csr_array) -> np.ndarray:
    """(n, 3) unit normals without the errors of single ones: at each vertex the mean of the mean
    normals, by area, of what is `near` (n, c) to some of them."""
    around = unit(near.T @ (surface.vertex_area[:, None] * normals))
    mean = near @ around
    length = np.sqrt(np.einsum("nc,nc->n", mean, mean))
    alone = length == 0.0
    mean /= np.where(alone, 1.0, length)[:, None]
    mean[alone] = normals[alone]
    return mean


def _nearest(points: np.ndarray, places: np.ndarray, near: sparse.csr_array) -> np.ndarray:
    """(n,) the nearest of the places (3, c) `near` (n, c) to each of the points (3, n)."""
    count, first = np.diff(near.indptr), near.indptr[:-1]
    square = np.zeros(near.nnz)
    for here, there in zip(points, places, strict=True):
        square += np.square(np.repeat(here, count) - there.take(near.indices))
    nearest = square == np.repeat(np.minimum.reduceat(square, first), count)
    # Of several that are as near the one numbered highest.
    return np.maximum.reduceat(np.where(nearest, near.indices, -1), first)


def _nearest_of(
    points: np.ndarray, middles: np.ndarray, rows: sparse.csr_array, count: int
) -> sparse.csr_array:
    """(r, p) of the points (3, p) in each of the rows (r, p) the nearest to the middles (3, r), so
    many or all; what is as far as the last of them as well."""
    length = np.diff(rows.indptr)
    if length.max(initial=0) <= count:
        return rows
    square = _squares(points, middles, rows)
    there = np.arange(length.max()) < length[:, None]
    away = np.full(there.shape, np.inf)
    away[there] = square
    # To part numbers takes less than to part their places.
    away.partition(count - 1, axis=1)
    near = square <= np.repeat(away[:, count - 1], length)
    members = rows.indices[near]
    start = np.append(0, np.cumsum(near))[rows.indptr]
    return sparse.csr_array((np.ones(len(members), bool), members, start), shape=rows.shape)


def _squares(points: np.ndarray, middles: np.ndarray, rows: sparse.csr_array) -> np.ndarray:
    """(e,) squared distances of the points (3, p) in the rows (r, p) from the middles (3, r)."""
    length = np.diff(rows.indptr)
    square = np.zeros(rows.nnz)
    for here, middle in zip(points, middles, strict=True):
        square += np.square(here.take(rows.indices) - np.repeat(middle, length))
    return square


def _padded(rows: sparse.csr_array) -> tuple[np.ndarray, np.ndarray]:
    """(r, s) the entries of each row side by side, and which of them are of the row: the shorter
    are filled up."""
    place = rows.indptr[:-1, None] + np.arange(np.diff(rows.indptr).max(initial=0))
    return place, place < rows.indptr[1:, None]
