"""Rings of vertices around vertices, grown by sparse products, and vertices spread so that the
rings of some hold all."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from ..base.parallel import run
from ..base.progress import Progress
from ..base.subsets import spans
from .half_edges import HalfEdges
from .surface import Surface

# Neighbours of neighbours that are gathered at once, each as often as it is met: 16,384 vertices
# with eight rings around them, 200 MB at most.
MOST_GATHERED = 1 << 25
# Rings from which on only the outermost leads further; with fewer that takes longer than it saves.
BY_FRONTS = 5
# Nodes side by side whose rings are grown together.
SIDE_BY_SIDE = 512
# A block of rows costs as much more as so many samples in it do: with fewer it is worth to fill the
# shorter rows up.
FILLED = 1 << 12
# Nodes that one thread looks around at once, and such that it gathers all within some edges of.
NEAR_BLOCK, GATHERED_BLOCK = 1 << 15, 1 << 12


def adjacency(links: Surface | HalfEdges, values: np.ndarray | None = None) -> sparse.csr_array:
    """The (n, n) one-ring graph: where two vertices share an edge the `values` (e,) of their
    `neighbours`, else True."""
    n = len(links.neighbour_start) - 1
    if values is None:
        values = np.ones(len(links.neighbours), bool)
    return sparse.csr_array((values, links.neighbours, links.neighbour_start), shape=(n, n))


def even_count(rings: int) -> int:
    """Nodes of so many rings where six edges meet, the middle one among them."""
    return 1 + 3 * rings * (rings + 1)


def rings_of(count: float) -> int:
    """The rings, one at least, that hold so many nodes where six edges meet."""
    rings = 1
    while even_count(rings) < count:
        rings += 1
    return rings


def with_rings(faces: np.ndarray, vertices: np.ndarray, rings: int) -> np.ndarray:
    """(n,) bool, the vertices (n,) bool and so many rings of faces (f, corners) around them."""
    found = vertices.copy()
    for _ in range(rings):
        # Corner by corner: several times faster than over the last axis of (f, corners).
        touched = np.logical_or.reduce([found[corner] for corner in faces.T])
        found[faces[touched]] = True
    return found


def ring_around(links: Surface | HalfEdges, vertices: np.ndarray, rings: int) -> np.ndarray:
    """Ascending vertices within so many edges of the vertices (k,): as `with_rings`, at the cost
    of what there is around few."""
    return _reached(links.neighbour_start, links.neighbours, vertices, rings)


def _reached(
    start: np.ndarray, neighbours: np.ndarray, vertices: np.ndarray, rings: int
) -> np.ndarray:
    """As `ring_around`, of the rows of neighbours that start so."""
    found = np.zeros(len(start) - 1, bool)
    found[vertices] = True
    front = np.flatnonzero(found)
    for _ in range(rings):
        count = start[front + 1] - start[front]
        reached = neighbours[spans(start[front], count)]
        reached = reached[~found[reached]]
        found[reached] = True
        front = np.unique(reached)
    return np.flatnonzero(found)


def rings_across(surface: Surface) -> int:
    """Rings that hold the whole of every component, from any vertex of it: no more than twice
    as many as from one."""
    n = len(surface.vertices)
    _, first = np.unique(surface.component, return_index=True)
    hops = csgraph.dijkstra(adjacency(surface), indices=first, unweighted=True, min_only=True)
    return min(2 * int(hops.max()), n)


def grow(
    reach: sparse.csr_array, graph: sparse.csr_array, rings: int, progress: Progress | None = None
) -> Iterator[tuple[np.ndarray, sparse.csr_array]]:
    """Each row of `reach` lists vertices; add those within `rings` edges of them, all once.

    On a surface every edge has a triangle, so a walk of exactly that many edges (two or more)
    reaches the nearer vertices too. It ends where rows have all that they can reach.

    Yields
    ------
    rows:
        (r,) rows of `reach`, ascending: all at once unless they become too long for that.
    grown:
        (r, n) what they have become.
    """
    if rings < BY_FRONTS:
        yield from grown_rows(
            reach, lambda rows: rows @ graph, np.diff(graph.indptr), rings, progress
        )
        return
    # What every ring has added.
    reach.sum_duplicates()
    degree = np.diff(graph.indptr)
    parts = [(np.arange(reach.shape[0]), [reach], rings)]
    while parts:
        rows, fronts, left = parts.pop()
        while left and fronts[-1].nnz:
            if progress is not None:
                progress.ask()
            half = _half(fronts, degree)
            if half:
                parts.append((rows[half:], [front[half:] for front in fronts], left))
                rows, fronts = rows[:half], [front[:half] for front in fronts]
                continue
            fronts, left = [*fronts, _beyond(fronts, graph)], left - 1
        yield rows, _together(fronts)


def grow_side_by_side(
    nodes: np.ndarray,
    points: np.ndarray,
    graph: sparse.csr_array,
    rings: int,
    progress: Progress | None = None,
) -> Iterator[tuple[np.ndarray, sparse.csr_array]]:
    """As `grow`, so many rings around many nodes (r,) at points (r, 3), not in ascending order: in
    a third of the time, as of those that lie near each other one reaches what others do."""
    order = side_by_side(points)
    for first in range(0, len(nodes), SIDE_BY_SIDE):
        rows = order[first : first + SIDE_BY_SIDE]
        some = nodes[rows]
        if progress is not None:
            progress.ask()
        within = _reached(graph.indptr, graph.indices, some, rings)
        if len(within) * len(some) > MOST_GATHERED:
            for part, reach in grow(graph[some], graph, rings - 1, progress):
                yield rows[part], reach
            continue
        yield rows, _grown_as_bits(some, within, graph, rings)


def _grown_as_bits(
    nodes: np.ndarray, within: np.ndarray, graph: sparse.csr_array, rings: int
) -> sparse.csr_array:
    """(r, n) what is within so many rings of nodes (r,), all of it among the ascending nodes
    `within`: each of these has a bit for each of the nodes, and takes those of its neighbours."""
    place = np.full(graph.shape[0], -1, np.int32)
    place[within] = np.arange(len(within), dtype=np.int32)
    count = graph.indptr[within + 1] - graph.indptr[within]
    beside = place[graph.indices[spans(graph.indptr[within], count)]]
    inside = beside >= 0
    start = np.append(0, np.cumsum(inside))[np.cumsum(count) - count]
    beside = beside[inside]
    bits = np.zeros((len(within), SIDE_BY_SIDE // 8), np.uint8)
    own = np.packbits(np.eye(len(nodes), SIDE_BY_SIDE, dtype=bool), axis=1)
    np.bitwise_or.at(bits, place[nodes], own)
    words = bits.view(np.uint64)
    for _ in range(rings):
        words |= np.bitwise_or.reduceat(words.take(beside, axis=0), start, axis=0)
    there = np.ascontiguousarray(np.unpackbits(bits, axis=1, count=len(nodes)).T).view(bool)
    held = np.count_nonzero(there, axis=1)
    column = np.flatnonzero(there) - np.repeat(len(within) * np.arange(len(nodes)), held)
    starts = np.append(0, np.cumsum(held)).astype(np.int32)
    indices = within.astype(np.int32).take(column)
    shape = len(nodes), graph.shape[0]
    return sparse.csr_array((np.ones(len(indices), bool), indices, starts), shape=shape)


def side_by_side(points: np.ndarray) -> np.ndarray:
    """(n,) rows of points (n, 3), those near each other one after the other: halved across where
    they reach the farthest, and again."""
    parts, ordered = [np.arange(len(points))], []
    while parts:
        rows = parts.pop()
        if len(rows) <= SIDE_BY_SIDE:
            ordered.append(rows)
            continue
        along = points[rows, np.ptp(points[rows], axis=0).argmax()]
        half = len(rows) // 2
        order = np.argpartition(along, half)
        parts += [rows[order[half:]], rows[order[:half]]]
    return np.concatenate(ordered)


def _beyond(fronts: list[sparse.csr_array], graph: sparse.csr_array) -> sparse.csr_array:
    """What the next ring adds: only the last front leads further, and back to no more than itself
    and the one before."""
    new = fronts[-1] @ graph
    for known in fronts[-2:]:
        new = new > known
    return new


def _half(fronts: list[sparse.csr_array], degree: np.ndarray) -> int:
    """How many rows are half of what all gather; 0 where that is not too much at once."""
    most = int(degree.max(initial=0)) + 1
    if fronts[0].shape[0] < 2 or most * sum(front.nnz for front in fronts) <= MOST_GATHERED:
        return 0
    ends = sum(np.append(0, np.cumsum(degree[one.indices] + 1.0))[one.indptr] for one in fronts)
    if ends[-1] <= MOST_GATHERED:
        return 0
    return int(np.clip(np.searchsorted(ends, ends[-1] / 2), 1, len(ends) - 2))


def _together(fronts: list[sparse.csr_array]) -> sparse.csr_array:
    """The rows of all fronts, which share nothing, beside each other."""
    starts = np.stack([front.indptr for front in fronts]).sum(axis=0, dtype=np.int32)
    indices = np.empty(starts[-1], np.int32)
    begin = starts[:-1].copy()
    for front in fronts:
        count = np.diff(front.indptr)
        place = np.arange(front.nnz, dtype=np.int32)
        place += np.repeat(begin - front.indptr[:-1], count)
        indices[place] = front.indices
        begin += count
    ones = np.ones(len(indices), bool)
    return sparse.csr_array((ones, indices, starts), shape=fronts[0].shape)


class Begun:
    """Rings around the same vertices, grown on where one scale after the other asks for them."""

    def __init__(self) -> None:
        self._fronts: dict[tuple[bytes, bytes], list[sparse.csr_array]] = {}
        # For how many vertices patches are listed around the same ones, and these; see `Patches`.
        self.nearest: dict[bytes, tuple[float, list[tuple[np.ndarray, ...]]]] = {}

    def grow(
        self, nodes: np.ndarray, graph: sparse.csr_array, rings: int, progress: Progress | None
    ) -> Iterator[tuple[np.ndarray, sparse.csr_array]]:
        """As `grow`, so many rings around `nodes` (r,) of always the same graph."""
        yield from self.around(graph[nodes], graph, rings - 1, progress)

    def around(
        self,
        start: sparse.csr_array,
        graph: sparse.csr_array,
        rings: int,
        progress: Progress | None,
    ) -> Iterator[tuple[np.ndarray, sparse.csr_array]]:
        """As the function `grow`, of always the same graph."""
        start.sum_duplicates()
        fronts = self._fronts.setdefault((start.indptr.tobytes(), start.indices.tobytes()), [start])
        degree = np.diff(graph.indptr)
        while len(fronts) <= rings:
            if progress is not None:
                progress.ask()
            if _half(fronts, degree):
                # Too much to keep.
                yield from grow(start, graph, rings, progress)
                return
            fronts.append(_beyond(fronts, graph))
        yield np.arange(start.shape[0]), _together(fronts[: rings + 1])


def grown_rows(
    reach: sparse.csr_array,
    further: Callable[[sparse.csr_array], sparse.csr_array],
    degree: np.ndarray,
    rings: int,
    progress: Progress | None,
) -> Iterator[tuple[np.ndarray, sparse.csr_array]]:
    """As `grow`, each ring by `further`, which gathers `degree` (n,) vertices at each vertex."""
    most = int(degree.max(initial=0)) + 1
    parts = [(np.arange(reach.shape[0]), reach, rings)]
    while parts:
        rows, reach, left = parts.pop()
        while left:
            if progress is not None:
                progress.ask()
            if len(rows) > 1 and reach.nnz * most > MOST_GATHERED:
                ends = np.append(0, np.cumsum(degree[reach.indices] + 1.0))[reach.indptr]
                if ends[-1] > MOST_GATHERED:
                    half = int(np.clip(np.searchsorted(ends, ends[-1] / 2), 1, len(rows) - 1))
                    parts.append((rows[half:], reach[half:], left))
                    rows, reach = rows[:half], reach[:half]
                    continue
            larger = further(reach)
            larger.data[:] = True
            left = left - 1 if larger.nnz > reach.nnz else 0
            reach = larger
        yield rows, reach


def selection(vertices: np.ndarray, count: int) -> sparse.csr_array:
    """(r, count) bool matrix whose rows are True at the vertices (r, s) named in each row."""
    rows, size = vertices.shape
    # Products of matrices whose rows have numbers of different types copy both.
    columns = vertices.ravel().astype(np.int32)
    starts = size * np.arange(rows + 1, dtype=np.int32)
    return sparse.csr_array((np.ones(len(columns), bool), columns, starts), (rows, count))


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
    count = np.bincount(sizes)
    held = np.flatnonzero(count)
    begin = 0
    for size, end in zip(held.tolist(), np.cumsum(count[held]).tolist(), strict=True):
        step = max(most // max(size, 1), 1)
        for low in range(begin, end, step):
            rows = order[low : min(low + step, end)]
            if size:
                # NumPy gathers by its own integers several times faster than by others.
                slots = reach.indptr[rows] + np.arange(size, dtype=np.intp)[:, None]
                yield rows, reach.indices[slots].astype(np.intp)
        begin = end


def by_similar_size(
    reach: sparse.csr_array, most: int, filling: np.ndarray
) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """As `by_size`, with fewer and larger blocks, in which the shorter rows are filled up with the
    vertices `filling` (r,).

    Yields
    ------
    rows, members:
        As there; size is that of the longest.
    held:
        (b,) how many of the members are of the row, the first ones.
    """
    sizes = np.diff(reach.indptr)
    order = np.argsort(sizes, kind="stable")
    count = np.bincount(sizes)
    held = np.flatnonzero(count)
    ends = np.cumsum(count[held]).tolist()
    begin, longest = 0, held.tolist()
    for place, (size, end) in enumerate(zip(longest, ends, strict=True)):
        if place + 1 < len(ends):
            wider = longest[place + 1]
            together = (end - begin) * (wider - size) <= FILLED
            if size and together and (ends[place + 1] - begin) * wider <= most:
                continue
        step = max(most // max(size, 1), 1)
        for low in range(begin, end, step):
            rows = order[low : min(low + step, end)]
            if not size:
                continue
            own, first = sizes[rows], reach.indptr[rows]
            # NumPy gathers by its own integers several times faster than by others.
            slots = np.arange(size, dtype=np.intp)[:, None]
            if own[0] == size:
                yield rows, reach.indices[first + slots].astype(np.intp), own
                continue
            there = slots < own
            members = reach.indices[np.where(there, first + slots, first)]
            yield rows, np.where(there, members, filling[rows]).astype(np.intp), own
        begin = end


def independent(graph: sparse.csr_array, progress: Progress) -> np.ndarray:
    """(c,) ascending nodes of a symmetric graph, no two of them adjacent, and every other node
    adjacent to one: a maximal independent set (Luby 1986, https://doi.org/10.1137/0215074). Edges
    of nodes with themselves tell nothing.

    Of nodes in a random order those that come before all their neighbours are taken, their
    neighbours are left out, and so on with the rest.
    """
    n = graph.shape[0]
    rank = np.random.default_rng(0).permutation(n).astype(np.int32) + 1
    taken = np.diff(graph.indptr) == 0
    rank[taken] = 0
    rest = np.flatnonzero(~taken)
    while len(rest):
        decided: list[np.ndarray] = []

        def block(first: int, rest: np.ndarray = rest, decided: list[np.ndarray] = decided) -> None:
            some = rest[first : first + NEAR_BLOCK]
            rows = graph[some]
            # A rank of zero is that of a node that is decided.
            highest = np.maximum.reduceat(rank.take(rows.indices), rows.indptr[:-1])
            new = np.flatnonzero(rank[some] >= highest)
            taken[some[new]] = True
            decided.extend((some[new], rows[new].indices))

        run(block, range(0, len(rest), NEAR_BLOCK), progress.quiet())
        for nodes in decided:
            rank[nodes] = 0
        rest = rest[rank[rest] > 0]
    return np.flatnonzero(taken)


@dataclass(frozen=True)
class Spread:
    """Nodes spread over a symmetric graph of n.

    Attributes
    ----------
    nodes:
        (c,) ascending, about a quarter of those that they are spread among.
    near:
        (n, c) bool, whether a node of the graph is within so many edges of one of those.
    finer:
        The nodes that they are spread among, with what is one edge from them; None for all.
    """

    nodes: np.ndarray
    near: sparse.csr_array
    finer: Spread | None = None


def spread(graph: sparse.csr_array, rounds: int, edges: int, progress: Progress) -> Spread:
    """Nodes spread over a symmetric graph, and which of them are within `edges` of each node.

    The first round leaves about a quarter of the nodes, a second one a third of these. No row of
    `near` is empty from one edge on after one round, from three on after two.
    """
    nodes = independent(graph, progress)
    if rounds == 1:
        return Spread(nodes, _near(graph, nodes, edges, progress))
    finer = Spread(nodes, _near(graph, nodes, 1, progress))
    # Two nodes are neighbours that some node is next to.
    beside = finer.near.T.tocsr() @ finer.near
    nodes = nodes[independent(beside, progress)]
    return Spread(nodes, _near(graph, nodes, edges, progress), finer)


def _near(
    graph: sparse.csr_array, nodes: np.ndarray, edges: int, progress: Progress
) -> sparse.csr_array:
    """(n, c) bool, whether a node is within so many edges of each of the `nodes` (c,)."""
    parts: dict[int, sparse.csr_array] = {}
    alone = np.diff(graph.indptr) == 0
    if alone.any():
        # Edges lead back to where they come from, but for these.
        graph = (graph + sparse.diags_array(alone, dtype=bool)).tocsr()

    def block(first: int) -> None:
        # From the few nodes, which as many edges lead back to, and not from all others.
        reach = selection(nodes[first : first + GATHERED_BLOCK, None], graph.shape[0])
        reach = (reach + reach @ graph).tocsr()
        for _ in range(edges - 1):
            reach = reach @ graph
        parts[first] = reach

    run(block, range(0, len(nodes), GATHERED_BLOCK), progress)
    return sparse.vstack([parts[first] for first in sorted(parts)], format="csr").T.tocsr()
