"""Where the field comes so close to zero that its zeros are not told from each other.

Along an edge the deviator is taken to be linear, as in method S. Where it comes within its error
of zero on the way, it is open on which side of the edge it passes zero, and so is which of the
two triangles holds an umbilic. Such edges are undecided. Only the index around a connected set of
them is known, and how far the set reaches: one that is small and has an index is an umbilic of
that index, whatever parts it shows; one that is long and narrow is a curve of umbilics.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from ..base.parallel import run
from ..base.progress import Progress
from ..curvature.field import CurvatureField
from ..curvature.tolerances import CURVE_LENGTH, CURVE_NARROW, EDGE_BEND, REGION_BEND
from ..mesh.surface import Surface

BLOCK = 32768
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
    """

    label: np.ndarray
    length: np.ndarray
    width: np.ndarray
    diameter: np.ndarray

    @property
    def long(self) -> np.ndarray:
        """(s,) bool, sets that are curves by their shape: some independent fits side by side in
        one line."""
        return (self.length >= CURVE_LENGTH * self.diameter) & (
            self.length >= CURVE_NARROW * self.width
        )


def unresolved_sets(
    surface: Surface,
    field: CurvatureField,
    noise: np.ndarray,
    radius: np.ndarray,
    level: float,
    progress: Progress,
) -> UnresolvedSets:
    """The connected sets of undecided edges.

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
    """
    half_edge, tail, head = _undecided_edges(surface, field, noise, radius, level, progress)
    if not len(tail):
        none = np.zeros(0)
        return UnresolvedSets(np.full(len(surface.triangles), -1, np.int32), none, none, none)
    vertices, place = np.unique(np.concatenate([tail, head]), return_inverse=True)
    one, two = place[: len(tail)], place[len(tail) :]
    size = np.linalg.norm(surface.vertices[tail] - surface.vertices[head], axis=1)
    # A length of zero would be no edge to a sparse graph.
    size = np.maximum(size, np.finfo(float).tiny)
    graph = sparse.csr_array(
        sparse.coo_array((size, (one, two)), shape=(len(vertices), len(vertices)))
    )
    count, piece = csgraph.connected_components(graph, directed=False)
    label = np.full(len(surface.triangles), -1, np.int32)
    twin = surface.twin[half_edge]
    label[half_edge // 3] = piece[one]
    label[twin[twin >= 0] // 3] = piece[one[twin >= 0]]
    length = _lengths(graph, piece, count)
    inside = np.flatnonzero(label >= 0)
    area = np.bincount(
        label[inside], weights=surface.face_normal_area[1][inside], minlength=count
    )
    known = np.isfinite(radius[vertices])
    total = np.bincount(piece[known], weights=radius[vertices[known]], minlength=count)
    number = np.bincount(piece[known], minlength=count)
    # Points spread over a disc are 1 / sqrt(2) of its radius away from its middle.
    diameter = 2.0 * np.sqrt(2.0) * total / np.maximum(number, 1)
    return UnresolvedSets(label, length, area / np.maximum(length, np.finfo(float).tiny), diameter)


def _undecided_edges(
    surface: Surface,
    field: CurvatureField,
    noise: np.ndarray,
    radius: np.ndarray,
    level: float,
    progress: Progress,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Half-edges (e,), one an edge, whose deviator comes within its error of zero; their ends."""
    names = np.arange(len(surface.twin), dtype=np.int32)
    edges = np.flatnonzero(surface.twin < names)
    corners, heads = surface.triangles.ravel(), surface.triangles[:, [1, 2, 0]].ravel()
    frames = np.ascontiguousarray((field.d1 + 1j * field.d2).T)
    error = np.where(np.isfinite(noise), level * noise, 0.0)
    # What is as large as the bend of the surface over the fit is no error of a smooth surface.
    error[~(error * radius <= REGION_BEND)] = 0.0
    beside = surface.near_border(BORDER_RINGS)
    excess = np.zeros(len(edges))

    def block(first: int) -> None:
        some = edges[first : first + BLOCK]
        tail, head = corners[some], heads[some]
        turn = np.einsum("cr,cr->r", frames[:, tail].conj(), frames[:, head])
        size = np.abs(turn)
        turn = np.where(size > 0, turn / np.where(size > 0, size, 1.0), 1.0)
        start, end = field.gap[tail], field.gap[head] * turn**2
        change = end - start
        square = np.abs(change) ** 2
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.clip(np.nan_to_num(-start * change.real / square), 0.0, 1.0)
        least = np.abs(start + share * change)
        allowed = (1.0 - share) * error[tail] + share * error[head]
        allowed = np.maximum(allowed, EDGE_BEND * np.abs(change))
        with np.errstate(divide="ignore", invalid="ignore"):
            missed = np.where(least <= allowed, 0.0, least / allowed)
        excess[first : first + BLOCK] = np.where(beside[tail] | beside[head], np.inf, missed)

    run(block, range(0, len(edges), BLOCK), progress)
    ends = np.zeros(len(surface.vertices), bool)
    ends[corners[edges[excess <= 1.0]]] = ends[heads[edges[excess <= 1.0]]] = True
    chosen = edges[(excess <= 1.0) | (excess <= LINK) & ends[corners[edges]] & ends[heads[edges]]]
    return chosen, corners[chosen], heads[chosen]


def _lengths(graph: sparse.csr_array, piece: np.ndarray, count: int) -> np.ndarray:
    """(count,) the way between two far ends of each connected piece: from any vertex to the
    farthest, and from there to the farthest again."""
    _, start = np.unique(piece, return_index=True)
    for _ in range(2):
        # One start in each piece: they do not reach each other.
        away = csgraph.dijkstra(graph, directed=False, indices=start, min_only=True)
        order = np.lexsort((away, piece))
        start = order[np.cumsum(np.bincount(piece, minlength=count)) - 1]
    return away[start]
