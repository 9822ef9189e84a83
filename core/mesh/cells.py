"""Patches of a few vertices, whose means stand for them in wide windows.

Wide windows hold hundreds of vertices. Means of some three or four that lie side by side tell a
height function over many of them as much, at a third of the work, and the windows around vertices
that lie beside each other are put together of cells of such patches instead of ring by ring.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy import sparse

from ..base.progress import Progress
from ..base.subsets import spans
from .rings import Spread, by_size, grow
from .surface import Surface

# Vertices of the cells that are looked at, over those that a window holds where triangles are as
# long as wide; of the nearest cells so many that they hold more than the window by the margin.
AMPLE, MARGIN = 1.5, 1.35
# Vertices in a window over those whose patches make it up: within a patch they tell nothing. On
# noisy ellipsoids of 40,000 and 160,000 vertices errors are so what they are with the vertices.
LOST = 1.06
# Windows that are listed at once.
LISTED = 1 << 12


class Patches:
    """The vertices of a surface dealt out to the nearest of some of them, and these to cells.

    Parameters
    ----------
    surface:
        The surface; n vertices.
    normals:
        (n, 3) unit normals, smooth from one vertex to the next.
    over:
        Vertices spread over it in two rounds, which cells and patches lie around.

    Attributes
    ----------
    coordinates:
        (3, p) mean places of the patches.
    size:
        (p,) float64 numbers of their vertices.
    scatter:
        (p,) summed squares of how far these lie from their plane.
    """

    def __init__(self, surface: Surface, normals: np.ndarray, over: Spread) -> None:
        assert over.finer is not None and over.beside is not None
        finer, near = over.finer.nodes, over.finer.near
        p, c = len(finer), len(over.nodes)
        patch = _nearest(surface.coordinates, surface.coordinates[:, finer], near)
        size = np.bincount(patch, minlength=p)
        sums = [np.bincount(patch, along, minlength=p) for along in surface.coordinates]
        self.size, self.coordinates = size.astype(float), np.stack(sums) / size
        height = np.zeros(len(patch))
        for here, middle, up in zip(
            surface.coordinates, self.coordinates, normals[finer].T, strict=True
        ):
            height += (here - middle.take(patch)) * up.take(patch)
        self.scatter = np.bincount(patch, np.square(height), minlength=p)
        self.middles, self.places = over.nodes, surface.coordinates[:, over.nodes]
        cell = _nearest(self.coordinates, self.places, over.near[finer])
        self.order = np.argsort(cell, kind="stable")
        self.held = np.bincount(cell, minlength=c)
        self.start = np.cumsum(self.held) - self.held
        one, other = (cell.take(end) for end in over.beside.tocoo().coords)
        own = np.arange(c, dtype=one.dtype)
        ends = np.concatenate([one, own]), np.concatenate([other, own])
        # Which cells a cell is beside, itself among them.
        self.graph = sparse.coo_array((np.ones(len(ends[0]), bool), ends), shape=(c, c)).tocsr()

    def windows(
        self,
        middles: np.ndarray,
        held: int,
        stretch: float,
        most: int,
        progress: Progress | None = None,
    ) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """The patches nearest to each of the `middles` (r,) that hold so many vertices where they
        are as large everywhere, in blocks as those of `Neighbourhood.blocks`; triangles are
        `stretch` times as long as wide."""
        rows = np.searchsorted(self.middles, middles)
        mean = float(self.size.mean())
        count = max(round(LOST * held / mean), 1)
        asked = int(np.ceil(MARGIN * held / (mean * self.held.mean())))
        rings = _rings(AMPLE * stretch * held / (mean * self.held.mean()))
        for low in range(0, len(rows), LISTED):
            some = rows[low : low + LISTED]
            for part, reach in grow(self.graph[some], self.graph, rings - 1, progress):
                listed = self._listed(some[part], reach, asked)
                yield from self._blocks(low + part, some[part], listed, count, most)

    def _listed(self, rows: np.ndarray, reach: sparse.csr_array, asked: int) -> sparse.csr_array:
        """(r, p) the patches of so many of the cells (r, c), those nearest to the cells `rows`."""
        of = np.repeat(rows, np.diff(reach.indptr))
        square = np.zeros(len(of))
        for here in self.places:
            square += np.square(here.take(reach.indices) - here.take(of))
        _, cells, count = _least(square, reach, asked)
        held = self.held[cells]
        start = np.append(0, np.cumsum(held))
        members = self.order.take(spans(self.start[cells], held))
        indptr = start[np.append(0, np.cumsum(count))]
        ones = np.ones(len(members), bool)
        return sparse.csr_array((ones, members, indptr), shape=(len(rows), len(self.size)))

    def _blocks(
        self, asked: np.ndarray, rows: np.ndarray, listed: sparse.csr_array, count: int, most: int
    ) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Of the patches `listed` (r, p) the nearest to the cells `rows`, so many or all."""
        of = np.repeat(rows, np.diff(listed.indptr))
        square = np.zeros(len(of))
        for here, middle in zip(self.coordinates, self.places, strict=True):
            square += np.square(here.take(listed.indices) - middle.take(of))
        start, members, held = _least(square, listed, count)
        ones = np.ones(len(members), bool)
        window = sparse.csr_array((ones, members, start), shape=listed.shape)
        for part, some in by_size(window, most):
            yield asked[part], some


def _nearest(points: np.ndarray, places: np.ndarray, near: sparse.csr_array) -> np.ndarray:
    """(n,) the nearest of the places (3, c) to each of the points (3, n), of those `near` (n, c)."""
    count, first = np.diff(near.indptr), near.indptr[:-1]
    square = np.zeros(near.nnz)
    for here, there in zip(points, places, strict=True):
        square += np.square(np.repeat(here, count) - there.take(near.indices))
    nearest = square == np.repeat(np.minimum.reduceat(square, first), count)
    # Of several that are as near the one numbered highest.
    return np.maximum.reduceat(np.where(nearest, near.indices, -1), first)


def _least(
    values: np.ndarray, rows: sparse.csr_array, count: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of the entries of each row those with the least `values`, so many or all: where each row
    begins, the columns, and how many each has."""
    length = np.diff(rows.indptr)
    taken = np.minimum(length, count)
    place = rows.indptr[:-1, None] + np.arange(length.max(initial=0))
    there = place < rows.indptr[1:, None]
    if place.shape[1] > count:
        row = np.where(there, values.take(place, mode="clip"), np.inf)
        least = np.argpartition(row, count - 1, axis=1)[:, :count]
        place = rows.indptr[:-1, None] + least
        there = place < rows.indptr[1:, None]
    return np.append(0, np.cumsum(taken)), rows.indices[place[there]], taken


def _rings(cells: float) -> int:
    """Rings of cells that hold so many where six cells meet each."""
    rings = 1
    while 1 + 3 * rings * (rings + 1) < cells:
        rings += 1
    return rings
