"""The samples that curvature is fitted to at each vertex: rings of neighbours, in blocks."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from ..base.progress import Progress
from .patches import Patches
from .rings import (
    BY_FRONTS,
    Begun,
    by_similar_size,
    by_size,
    even_count,
    grow,
    grow_side_by_side,
    grown_rows,
    selection,
)
from .surface import Surface
from .thinning import Thinned

# A cubic has ten coefficients; half as many samples again keep the fit from chasing noise.
FEWEST_SAMPLES = 15
# Rings from which on means of a few vertices tell a fit as much as the vertices do, and fits at a
# twelfth of the vertices suffice instead of at a quarter: on noisy ellipsoids both leave less error
# than fits at all vertices do.
WIDE = 6
# A length that spans more rings than this is beyond what a cubic describes.
MOST_RINGS = 24
# Rings from which on nearest samples are taken from rings that vertices within so many edges of
# each other share; and samples that are listed at once so.
SHARED, NEAR, MOST_LISTED = 12, 3, 1 << 22

# Rows (b,), their samples (s, b), the shorter filled up, and how many each has (b,).
Block = tuple[np.ndarray, np.ndarray, np.ndarray]


@dataclass(frozen=True)
class Neighbourhood:
    """What the height function at a vertex is fitted to.

    Attributes
    ----------
    surface:
        The surface; n vertices.
    graph:
        (n, n) bool, its one-ring graph.
    crease_vertices:
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
    thinned:
        Cells whose rings stand for those of vertices in strips of long thin triangles; None
        where there are none.
    cells:
        The cells that graph and crease vertices are of; None where they are of the vertices.
    begun:
        Keeps the rings around few vertices or triangles for the next scale; None for none.
    patching:
        What stands for the vertices in wide windows, made when asked for; None for the vertices.
    """

    surface: Surface
    graph: sparse.csr_array
    crease_vertices: np.ndarray | None = None
    rings: int = 2
    reach: float | None = None
    focused: bool = True
    stretch: float = 1.0
    thinned: Thinned | None = None
    cells: Thinned | None = None
    begun: Begun | None = None
    patching: Callable[[], Patches] | None = None

    @property
    def patches(self) -> Patches | None:
        """What stands for the vertices in windows of so many rings; None for the vertices."""
        wide = self.rings >= WIDE and self.reach is None and not self.focused
        return self.patching() if wide and self.patching is not None else None

    def around_triangles(
        self, corners: np.ndarray, rings: int, most: int, progress: Progress | None = None
    ) -> Iterator[Block]:
        """The samples around triangles (r, 3) of vertices, in blocks as those of `blocks`, filled
        up with their first corners."""
        if self.thinned is not None:
            crowded = self.thinned.crowded[corners].any(axis=1)
            yield from self._in_cells(
                self.thinned,
                crowded,
                lambda of, rows: of.around_triangles(corners[rows], rings, most, progress),
            )
            return
        start = selection(self._nodes(corners), self.graph.shape[0])
        for some, reach in self._around(start, self._grown(rings), progress):
            first, places = corners[some, 0], self.surface.vertices[corners[some]].mean(axis=1)
            for rows, members, held in self._in_blocks(
                self._named(reach), most, first, places, rings
            ):
                yield some[rows], members, held

    def _in_blocks(
        self,
        reach: sparse.csr_array,
        most: int,
        filling: np.ndarray,
        points: np.ndarray,
        rings: int,
    ) -> Iterator[Block]:
        """The samples of rows (r, n) around points (r, 3), in blocks as from `by_similar_size`."""
        if self.stretch <= 1.0:
            yield from by_similar_size(reach, most, filling)
            return
        for rows, members in by_size(reach, most):
            members = self._nearest(members, points[rows], rings)
            yield rows, members, np.full(len(rows), len(members))

    def _in_cells(
        self,
        cells: Thinned,
        crowded: np.ndarray,
        samples: Callable[[Neighbourhood, np.ndarray], Iterator[Block]],
    ) -> Iterator[Block]:
        """Samples by rings of vertices and, where the rows are `crowded` (r,), by rings of
        cells."""
        rows = np.flatnonzero(~crowded)
        if len(rows):
            for some, members, held in samples(dataclasses.replace(self, thinned=None), rows):
                yield rows[some], members, held
        rows = np.flatnonzero(crowded)
        if len(rows):
            net = dataclasses.replace(
                self,
                graph=cells.graph,
                crease_vertices=(
                    None if self.crease_vertices is None else self.crease_vertices[cells.seed]
                ),
                stretch=1.0,
                thinned=None,
                cells=cells,
                begun=None,
            )
            for some, members, held in samples(net, rows):
                yield rows[some], members, held

    def _nodes(self, vertices: np.ndarray) -> np.ndarray:
        """Vertices as nodes of the graph."""
        return vertices if self.cells is None else self.cells.cell[vertices]

    def _named(self, reach: sparse.csr_array) -> sparse.csr_array:
        """Rows of nodes of the graph as rows of vertices."""
        if self.cells is None:
            return reach
        shape = (reach.shape[0], len(self.surface.vertices))
        return sparse.csr_array(
            (reach.data, self.cells.seed[reach.indices], reach.indptr), shape=shape
        )

    def _grown(self, rings: int) -> int:
        """Rings that hold the nearest samples of as many rings of an even mesh."""
        if self.stretch <= 1.0:
            return rings
        # A tenth of a ring more would not be worth the whole of one.
        return int(np.ceil(rings * np.sqrt(self.stretch) - 0.1))

    def _around(
        self, start: sparse.csr_array, rings: int, progress: Progress | None
    ) -> Iterator[tuple[np.ndarray, sparse.csr_array]]:
        """Rows of `start` grown by rings, stopping at creases; as from `grow`."""
        if self.crease_vertices is None:
            growing = grow if self.begun is None else self.begun.around
            return growing(start, self.graph, rings, progress)
        passable = sparse.diags_array(~self.crease_vertices, dtype=bool)
        through = (passable @ self.graph).tocsr()
        # A crease vertex still sees its own ring, on both of its sides.
        reach = (start + start @ self.graph).tocsr()
        degree = np.diff(self.graph.indptr)
        return grown_rows(
            reach, lambda rows: (rows + rows @ through).tocsr(), degree, rings - 1, progress
        )

    def blocks(
        self, centres: np.ndarray, most: int, progress: Progress | None = None
    ) -> Iterator[Block]:
        """The samples of each of the vertices `centres`, in blocks of about equal size.

        Yields
        ------
        rows:
            (b,) rows of `centres`, with b * s <= `most` (at least one row).
        members:
            (s, b) intp samples of each: vertices, filled up with their centre, or `patches`.
        held:
            (b,) how many of them, the first ones, are samples.
        """
        if self.thinned is not None:
            crowded = self.thinned.crowded[centres]
            yield from self._in_cells(
                self.thinned, crowded, lambda of, rows: of.blocks(centres[rows], most, progress)
            )
            return
        patches = self.patches
        if patches is not None:
            for rows, members in patches.windows(
                centres, even_count(self.rings), self.stretch, most, progress, self.begun
            ):
                yield rows, members, np.full(len(rows), len(members))
            return
        pending = np.arange(len(centres))
        count = self.rings
        sizes = np.zeros(len(centres), int)
        # Small neighbourhoods grow ring by ring until they suffice or hold a whole component.
        while len(pending):
            short = []
            for some, reach in self._ring_rows(centres[pending], self._grown(count), progress):
                asked = pending[some]
                reach = self._named(reach)
                grown = np.diff(reach.indptr)
                if self.stretch > 1.0:
                    grown = np.minimum(grown, even_count(count))
                ready = (grown >= FEWEST_SAMPLES) | (grown == sizes[asked])
                if self.reach is not None:
                    reach, covered = self._within_reach(reach, centres[asked])
                    ready &= covered | (grown == sizes[asked]) | (count >= MOST_RINGS)
                if ready.all():
                    enough, chosen = reach, asked
                else:
                    enough, chosen = reach[ready], asked[ready]
                    short.append(asked[~ready])
                    sizes[short[-1]] = grown[~ready]
                middle = centres[chosen]
                places = self.surface.vertices[middle]
                for rows, members, held in self._in_blocks(
                    enough, most, middle, places, count
                ):
                    yield chosen[rows], members, held
            pending = np.concatenate(short) if short else pending[:0]
            count += 1

    def _ring_rows(
        self, centres: np.ndarray, count: int, progress: Progress | None
    ) -> Iterator[tuple[np.ndarray, sparse.csr_array]]:
        nodes = self._nodes(centres)
        if self.crease_vertices is None:
            if self.begun is not None:
                return self.begun.grow(nodes, self.graph, count, progress)
            if self._many(len(nodes)) and self.stretch > 1.0 and count >= SHARED:
                middles, of = np.unique(self._middle[nodes], return_inverse=True)
                return self._shared(middles, of, count, progress)
            if self.side_by_side(len(nodes)):
                points = self.surface.vertices[centres]
                return grow_side_by_side(nodes, points, self.graph, count, progress)
            return grow(self.graph[nodes], self.graph, count - 1, progress)
        return self._around(selection(nodes[:, None], self.graph.shape[0]), count, progress)

    def _many(self, count: int) -> bool:
        """Whether so many vertices are many of all."""
        return count > self.graph.shape[0] // 8

    def side_by_side(self, count: int) -> bool:
        """Whether the samples of so many vertices are found the faster if all lie side by side."""
        alone = self.begun is not None or self.crease_vertices is not None
        alone |= self.thinned is not None or self.cells is not None
        wide = self.rings >= BY_FRONTS and self.patches is None
        return wide and not alone and self._many(count)

    @cached_property
    def _middle(self) -> np.ndarray:
        """(n,) for each node one within `NEAR` edges that many others have as well: the highest of
        random ranks beside it, and the highest beside that, and so on."""
        n = self.graph.shape[0]
        rank = np.random.default_rng(0).permutation(n)
        node, highest = np.argsort(rank), rank
        for _ in range(NEAR):
            beside = np.maximum.reduceat(highest[self.graph.indices], self.graph.indptr[:-1])
            highest = np.maximum(highest, beside)
        return node[highest]

    def _shared(
        self, middles: np.ndarray, of: np.ndarray, count: int, progress: Progress | None
    ) -> Iterator[tuple[np.ndarray, sparse.csr_array]]:
        """Rings of nodes that lie beside each other hold nearly the same: so many around the nodes
        whose middles are `middles[of]` (r,), and what is as far from the middles."""
        for rows, reach in grow(self.graph[middles], self.graph, count + NEAR - 1, progress):
            asked = np.flatnonzero((of >= rows[0]) & (of <= rows[-1]))
            step = max(MOST_LISTED // int(np.diff(reach.indptr).max()), 1)
            for low in range(0, len(asked), step):
                some = asked[low : low + step]
                yield some, reach[of[some] - rows[0]]

    def _within_reach(
        self, reach: sparse.csr_array, centres: np.ndarray
    ) -> tuple[sparse.csr_array, np.ndarray]:
        """Samples within the length `reach` (but not fewer than needed), and whether the rings
        went as far as that."""
        row = np.repeat(np.arange(len(centres)), np.diff(reach.indptr))
        middle = self.surface.vertices[centres[row]]
        distance = np.sqrt(_squares(self.surface, reach.indices, middle))
        # One key for row and distance: several times faster to sort than two.
        largest = distance.max(initial=np.finfo(float).tiny)
        order = np.argsort(row + distance / (1.001 * largest))
        rank = np.arange(len(row)) - reach.indptr[row]
        distance, members = distance[order], reach.indices[order]
        covered = distance[reach.indptr[1:] - 1] >= self.reach
        keep = (distance <= self.reach) | (rank < FEWEST_SAMPLES)
        start = np.append(0, np.cumsum(keep))[reach.indptr]
        ones = np.ones(int(start[-1]), bool)
        return sparse.csr_array((ones, members[keep], start), shape=reach.shape), covered

    def _nearest(self, members: np.ndarray, points: np.ndarray, rings: int) -> np.ndarray:
        """Of the samples (s, b) as many as so many rings of an even mesh hold, those nearest to
        the points (b, 3)."""
        count = even_count(rings)
        if len(members) <= count:
            return members
        square = _squares(self.surface, members, points)
        nearest = np.argpartition(square.T, count - 1, axis=1)[:, :count]
        return np.ascontiguousarray(np.take_along_axis(members, nearest.T, axis=0))


def _squares(surface: Surface, members: np.ndarray, points: np.ndarray) -> np.ndarray:
    """(..., b) squared distances of vertices (..., b) from points (b, 3)."""
    squares = np.zeros(members.shape)
    for here, middle in zip(surface.coordinates, points.T, strict=True):
        offset = here.take(members, mode="clip")
        offset -= middle
        squares += np.square(offset, out=offset)
    return squares
