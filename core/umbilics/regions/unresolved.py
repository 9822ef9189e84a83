"""Where the field comes so close to zero that its zeros are not told from each other.

Along an edge the deviator is taken to be linear, as in method S. Where it comes within its error
of zero on the way, it is open on which side of the edge it passes zero, and so is which of the
two triangles holds an umbilic. Such edges are undecided. Only the index around a connected set of
them is known, and how far the set reaches: one that is small and has an index is an umbilic of
that index, whatever parts it shows; one that is long and narrow is a curve of umbilics.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from ...base.parallel import run
from ...base.progress import Progress
from ...base.subsets import spans
from ...curvature.field import CurvatureField
from ...curvature.tolerances import CURVE_LENGTH, CURVE_MISS, CURVE_NARROW, EDGE_BEND, REGION_BEND
from ...mesh.half_edges import edge_keys
from ...mesh.surface import BLOCK, Surface

# Rings from a border that are left out: as far as fits reach.
BORDER_RINGS = 5
# One edge in a row that misses by more than its neighbours does not end a curve.
LINK = 3.0


@dataclass(frozen=True)
class UnresolvedSets:
    """Connected sets of undecided edges, s of them.

    Attributes
    ----------
    label:
        (m,) int32 set that each triangle of the surface has an undecided edge of, -1 for none.
    length:
        (s,) float64 from end to end along the edges of the set; half the way around where it is
        closed.
    width:
        (s,) float64 area of its triangles over its length.
    diameter:
        (s,) float64 mean diameter of the discs that its fits reach over.
    missed:
        (s,) float64 by how many of its errors the deviator misses zero along the edges, on
        average.
    """

    label: np.ndarray
    length: np.ndarray
    width: np.ndarray
    diameter: np.ndarray
    missed: np.ndarray

    @property
    def curves(self) -> np.ndarray:
        """(s,) bool, sets that are curves: by their shape, some independent fits side by side in
        one line, and by the deviator, which misses zero along them by no more than errors do."""
        narrow = self.length >= CURVE_NARROW * self.width
        return narrow & (self.length >= CURVE_LENGTH * self.diameter) & (self.missed <= CURVE_MISS)


def unresolved_sets(
    surface: Surface,
    field: CurvatureField,
    noise: np.ndarray,
    radius: np.ndarray,
    level: float,
    starts: np.ndarray,
    progress: Progress,
    most_missed: float = np.inf,
) -> UnresolvedSets:
    """The connected sets of undecided edges around vertices.

    Sets are joined over edges between them that miss zero by up to `LINK` times as much. Near an
    open border nothing is called undecided: what it cuts off from a fit its error does not tell.

    Parameters
    ----------
    surface:
        n vertices, m triangles.
    field:
        Shape operators at the vertices.
    noise, radius:
        (n,) standard error of the gap and root mean square distance of the samples that it
        comes from.
    level:
        Standard errors that the deviator must be from zero, not to be within its error.
    starts:
        Vertices from which the sets are followed: corners of triangles that hold umbilics, or
        the `low_vertices`.
    most_missed:
        Sets that miss zero by more of their errors on average are left out.
    """
    edges = _Edges(surface, field, noise, radius, level)
    tail, head, missed, apart = _undecided_edges(edges, starts, progress)
    vertices, graph, count, piece = _pieces(surface, tail, head)
    of_vertex = np.full(len(surface.vertices), -1, np.int32)
    of_vertex[vertices] = piece
    own = of_vertex[tail]
    number = np.bincount(own, minlength=count)
    mean = np.bincount(own, weights=missed, minlength=count) / number
    if (mean > most_missed).any():
        kept = mean <= most_missed
        rows = np.flatnonzero(kept[piece])
        vertices, graph = vertices[rows], graph[rows][:, rows]
        piece = (np.cumsum(kept) - 1)[piece[rows]]
        mean, count = mean[kept], int(kept.sum())
        of_vertex[:] = -1
        of_vertex[vertices] = piece
    if not count:
        none = np.zeros(0)
        return UnresolvedSets(np.full(len(surface.triangles), -1, np.int32), none, none, none, none)
    label = _labelled(surface, of_vertex, apart)
    length = _lengths(graph, piece, count)
    inside = np.flatnonzero(label >= 0)
    area = np.bincount(label[inside], weights=surface.face_normal_area[1][inside], minlength=count)
    known = np.isfinite(radius[vertices])
    total = np.bincount(piece[known], weights=radius[vertices[known]], minlength=count)
    number = np.bincount(piece[known], minlength=count)
    # Points spread over a disc are 1 / sqrt(2) of its radius away from its middle.
    diameter = 2.0 * np.sqrt(2.0) * total / np.maximum(number, 1)
    width = area / np.maximum(length, np.finfo(float).tiny)
    return UnresolvedSets(label, length, width, diameter, mean)


def _pieces(
    surface: Surface, tail: np.ndarray, head: np.ndarray
) -> tuple[np.ndarray, sparse.csr_array, int, np.ndarray]:
    """Of edges (e,), (e,) their v vertices, ascending, the graph (v, v) of their lengths, how many
    pieces it has, in the order of their lowest vertices, and the piece (v,) of each vertex."""
    held = np.zeros(len(surface.vertices), bool)
    held[tail] = held[head] = True
    vertices = np.flatnonzero(held)
    place = np.cumsum(held) - 1
    square = np.zeros(len(tail))
    for along in surface.coordinates:
        square += np.square(along.take(tail) - along.take(head))
    # A length of zero would be no edge to a sparse graph.
    size = np.maximum(np.sqrt(square), np.finfo(float).tiny)
    shape = (len(vertices), len(vertices))
    graph = sparse.csr_array(sparse.coo_array((size, (place[tail], place[head])), shape=shape))
    count, piece = csgraph.connected_components(graph, directed=False)
    return vertices, graph, int(count), piece


def low_vertices(surface: Surface, gap: np.ndarray) -> np.ndarray:
    """Vertices none of whose neighbours has a smaller gap (n,): every curve along which it
    vanishes passes close to some, also where the deviator has no zero in any triangle."""
    start, neighbours = surface.neighbour_start, surface.neighbours
    low = np.empty(len(gap), bool)

    def block(first: int) -> None:
        begin = start[first : first + BLOCK + 1]
        around = gap.take(neighbours[begin[0] : begin[-1]])
        lowest = np.minimum.reduceat(around, begin[:-1] - begin[0])
        np.less_equal(gap[first : first + BLOCK], lowest, out=low[first : first + BLOCK])

    run(block, range(0, len(gap), BLOCK), Progress())
    return np.flatnonzero(low)


@dataclass(frozen=True)
class _Edges:
    """What tells how close the deviator comes to zero along an edge; see `unresolved_sets`."""

    surface: Surface
    field: CurvatureField
    noise: np.ndarray
    radius: np.ndarray
    level: float

    @cached_property
    def beside(self) -> np.ndarray:
        """(n,) bool, vertices next to a border."""
        return self.surface.near_border(BORDER_RINGS)

    def missed(self, tail: np.ndarray, head: np.ndarray) -> np.ndarray:
        """(e,) by how many of its errors the deviator misses zero along each edge; infinite
        next to a border."""
        start, end = self._gap.take(tail), self._gap.take(head)
        # The deviator at the head is turned by twice the angle between the frames.
        (a, b), (c, d) = (
            (self.field.d1.take(end, axis=0), self.field.d2.take(end, axis=0))
            for end in (tail, head)
        )
        cosine, sine = (x + y + z for x, y, z in ((a * c + b * d).T, (a * d - b * c).T))
        size = cosine * cosine + sine * sine
        with np.errstate(divide="ignore", invalid="ignore"):
            along = np.where(size > 0.0, (cosine * cosine - sine * sine) / size, 1.0) * end - start
            across = np.where(size > 0.0, 2.0 * cosine * sine / size, 0.0) * end
            square = along * along + across * across
            share = np.clip(np.nan_to_num(-start * along / square), 0.0, 1.0)
            least = np.sqrt((start + share * along) ** 2 + (share * across) ** 2)
            allowed = (1.0 - share) * self._error.take(tail) + share * self._error.take(head)
            allowed = np.maximum(allowed, EDGE_BEND * np.sqrt(square))
            missed = np.where(least <= 0.0, 0.0, least / allowed)
        return np.where(self.beside[tail] | self.beside[head], np.inf, missed)

    @cached_property
    def _gap(self) -> np.ndarray:
        return self.field.gap

    @cached_property
    def _error(self) -> np.ndarray:
        """(n,) of the deviator at the vertices."""
        error = self.level * self.noise
        # What is as large as the bend of the surface over the fit is no error of a smooth surface.
        smooth = np.isfinite(error) & (error * self.radius <= REGION_BEND)
        return np.where(smooth, error, 0.0)


def _undecided_edges(
    edges: _Edges, starts: np.ndarray, progress: Progress
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Ends (e,), (e,) of the undecided edges that hang together with the vertices `starts`, by how
    many errors (e,) they miss zero, and the `edge_keys` of all others between their ends, sorted.

    They are followed from vertex to vertex, each vertex once, and over one edge in a row that
    misses zero by more.
    """
    surface = edges.surface
    begin, neighbours = surface.neighbour_start, surface.neighbours
    seen, ends, passed = np.zeros((3, len(surface.vertices)), bool)
    passed[starts] = True
    front = np.unique(starts)
    tails, heads, misses = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)], [np.zeros(0)]
    apart = [np.zeros((2, 0), np.int64)]
    while len(front):
        progress.ask()
        count = begin[front + 1] - begin[front]
        tail = np.repeat(front, count)
        head = neighbours[spans(begin[front], count)]
        new = ~seen[head]
        seen[front] = True
        # Edges within the front are met from both of their ends.
        new &= ~seen[head] | (tail < head)
        tail, head = tail[new], head[new]
        missed = _in_blocks(edges, tail, head, progress)
        linked = missed <= LINK
        apart.append(np.stack([tail[~linked], head[~linked]]))
        tail, head, missed = tail[linked], head[linked], missed[linked]
        ends[tail[missed <= 1.0]] = ends[head[missed <= 1.0]] = True
        tails.append(tail)
        heads.append(head)
        misses.append(missed)
        reached = np.zeros(len(seen), bool)
        reached[head[ends[tail] | passed[tail]]] = True
        front = np.flatnonzero(reached & ~seen)
    tail, head, missed = (np.concatenate(parts) for parts in (tails, heads, misses))
    chosen = (missed <= 1.0) | ends[tail] & ends[head]
    one, other = np.concatenate(apart, axis=1)
    both = ends[one] & ends[other]
    keys = np.sort(edge_keys(one[both], other[both], len(ends)))
    return tail[chosen], head[chosen], missed[chosen], keys


def _in_blocks(edges: _Edges, tail: np.ndarray, head: np.ndarray, progress: Progress) -> np.ndarray:
    missed = np.empty(len(tail))

    def block(first: int) -> None:
        rows = slice(first, first + BLOCK)
        missed[rows] = edges.missed(tail[rows], head[rows])

    if len(tail) <= BLOCK:
        block(0)
    else:
        run(block, range(0, len(tail), BLOCK), progress)
    return missed


def _labelled(surface: Surface, piece: np.ndarray, apart: np.ndarray) -> np.ndarray:
    """(m,) int32 the piece of the undecided edges that each triangle has one of, -1 for none.

    `piece` (n,) is that of the vertices, -1 for none; between two that have one all edges are
    undecided but for those whose keys are listed in `apart`, ascending.
    """
    label = np.full(len(surface.triangles), -1, np.int32)
    rows = surface.with_two_of(piece >= 0)
    pieces = [piece.take(corner) for corner in surface.triangles[rows].T]
    for one, two in ((0, 1), (1, 2), (2, 0)):
        there = (pieces[one] >= 0) & (pieces[two] >= 0)
        if len(apart):
            start, end = (surface.triangles[rows, corner] for corner in (one, two))
            key = edge_keys(start, end, len(piece))
            slot = np.minimum(np.searchsorted(apart, key), len(apart) - 1)
            there &= apart[slot] != key
        label[rows[there]] = pieces[one][there]
    return label


def _lengths(graph: sparse.csr_array, piece: np.ndarray, count: int) -> np.ndarray:
    """(count,) the way between two far ends of each connected piece: from any vertex to the
    farthest, and from there to the farthest again."""
    _, start = np.unique(piece, return_index=True)
    for _ in range(2):
        # One start in each piece: they do not reach each other.
        away = csgraph.dijkstra(graph, directed=False, indices=start, min_only=True)
        farthest = np.zeros(count)
        np.maximum.at(farthest, piece, away)
        start[piece[away == farthest[piece]]] = np.flatnonzero(away == farthest[piece])
    return away[start]
