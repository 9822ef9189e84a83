"""Cells of vertices around some of them, and windows made of whole cells.

Wide windows around vertices that lie beside each other hold nearly the same vertices. Grown ring by
ring each takes all of its vertices in turn; put together of cells it takes a handful of these.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy import sparse

from ..base.progress import Progress
from .rings import by_size, grow
from .surface import Surface

# Vertices of the cells that are looked at, over those that a window holds where triangles are as
# long as wide.
AMPLE = 1.2
# Vertices that are listed at once.
LISTED = 1 << 20


class Cells:
    """The vertices of a surface dealt out to the nearest of some of them.

    Parameters
    ----------
    surface:
        The surface; n vertices.
    middles:
        (c,) ascending vertices that cells lie around.
    near:
        (n, c) which of them each vertex may belong to, one at least.
    """

    def __init__(self, surface: Surface, middles: np.ndarray, near: sparse.csr_array) -> None:
        self.middles, self.places = middles, surface.vertices[middles]
        count, first = np.diff(near.indptr), near.indptr[:-1]
        square = np.zeros(near.nnz)
        for here in surface.coordinates:
            square += np.square(np.repeat(here, count) - here[middles].take(near.indices))
        nearest = square == np.repeat(np.minimum.reduceat(square, first), count)
        # Of several that are as near the one numbered highest.
        cell = np.maximum.reduceat(np.where(nearest, near.indices, -1), first)
        c = len(middles)
        self.order = np.argsort(cell, kind="stable").astype(np.int32)
        self.size = np.bincount(cell, minlength=c)
        self.start = np.cumsum(self.size) - self.size
        one, other = np.repeat(cell, np.diff(surface.neighbour_start)), cell[surface.neighbours]
        across = one != other
        pairs = one[across].astype(np.int32), other[across].astype(np.int32)
        own = np.arange(c, dtype=np.int32)
        rows, columns = (np.concatenate([end, own]) for end in pairs)
        graph = sparse.coo_array((np.ones(len(rows), bool), (rows, columns)), shape=(c, c))
        # Which cells a cell is beside, itself among them.
        self.graph = graph.tocsr()

    def nearest(
        self,
        middles: np.ndarray,
        count: int,
        stretch: float,
        most: int,
        progress: Progress | None = None,
    ) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Of each of the `middles` (r,) the first `count` vertices of the cells nearest to it, in
        blocks as those of `Neighbourhood.blocks`; triangles are `stretch` times as long as wide."""
        rows = np.searchsorted(self.middles, middles)
        rings = self._rings(AMPLE * stretch * count)
        step = max(LISTED // count, 1)
        for low in range(0, len(rows), step):
            for some, reach in grow(
                self.graph[rows[low : low + step]], self.graph, rings - 1, progress
            ):
                asked = low + some
                window = self._listed(rows[asked], reach, count)
                for part, members in by_size(window, most):
                    yield asked[part], members

    def _rings(self, count: float) -> int:
        """Rings of cells that hold so many vertices where six cells meet each."""
        cells, rings = count * len(self.middles) / len(self.order), 1
        while 1 + 3 * rings * (rings + 1) < cells:
            rings += 1
        return rings

    def _listed(self, rows: np.ndarray, reach: sparse.csr_array, count: int) -> sparse.csr_array:
        """(r, n) of the cells (r, c) the first `count` vertices, the nearest cells first."""
        lengths = np.diff(reach.indptr)
        row = np.repeat(np.arange(len(rows)), lengths)
        offset = self.places.take(reach.indices, axis=0) - self.places.take(rows[row], axis=0)
        distance = np.sqrt(np.einsum("pc,pc->p", offset, offset))
        # One key for row and distance: several times faster to sort than two.
        largest = max(float(distance.max()), float(np.finfo(float).tiny))
        order = np.argsort(row + distance / (1.001 * largest))
        cells = reach.indices[order]
        size = self.size[cells]
        before = np.cumsum(size) - size
        before -= np.repeat(before[reach.indptr[:-1]], lengths)
        taken = np.clip(count - before, 0, size)
        ends = np.append(0, np.cumsum(np.add.reduceat(taken, reach.indptr[:-1])))
        begin = self.start[cells] - (np.cumsum(taken) - taken)
        places = np.repeat(begin.astype(np.int32), taken)
        places += np.arange(len(places), dtype=np.int32)
        members = self.order.take(places, mode="clip")
        ones = np.ones(len(members), bool)
        return sparse.csr_array((ones, members, ends), shape=(len(rows), len(self.order)))
