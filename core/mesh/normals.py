"""Vertex normals from the triangles around each vertex, and their smoothing."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from ..base.parallel import run
from ..base.progress import Progress
from ..base.subsets import spans
from .rings import ring_around
from .surface import BLOCK, Surface

# Parts of a large surface that threads sum on their own, few since each has sums of all vertices.
# As many whatever the machine has, and added in order: sums are the same everywhere, to the bit.
PARTS = 4


def vertex_normals(surface: Surface) -> np.ndarray:
    """(n, 3) unit outward normals, the cross products of a corner's sides a, b weighted by
    1 / (|a|^2 |b|^2), which is exact for vertices on a sphere (Max 1999).

    Long slivers hardly count, so that normals stand upright at a ragged border. Where the
    weighted sum vanishes, the normal of the largest triangle around the vertex.
    """
    normal, area = surface.face_normal_area
    m, n = len(surface.triangles), len(surface.vertices)
    size = -(-m // PARTS) if m > BLOCK else m
    parts: dict[int, tuple[np.ndarray, np.ndarray]] = {}

    def part(first: int) -> None:
        rows = slice(first, first + size)
        weights = corner_weights(area[rows], surface.side_squares[:, rows])
        starts = np.arange(0, weights.size + 1, 3, dtype=np.int32)
        corners = sparse.csc_array(
            (weights.ravel(), surface.triangles[rows].ravel(), starts), shape=(n, len(weights))
        )
        parts[first] = corners @ normal[rows], corners @ np.ones(len(weights))

    run(part, range(0, m, size), Progress())
    total, scale = parts.pop(0)
    for first in sorted(parts):
        more, weights = parts[first]
        total += more
        scale += weights
    return _unit_or_largest_face(surface, total, scale)


def corner_weights(area: np.ndarray, side_squares: np.ndarray) -> np.ndarray:
    """(m, 3) weights of the unit normals of triangles in the normals of their corners (Max 1999),
    from their areas (m,) and the squares of their sides ab, bc, ca (3, m)."""
    ab, bc, ca = side_squares
    # Area / (|a|^2 |b|^2) by the side across from the corner. Where a side has no length the
    # triangle is degenerate, and nothing is known of its normal.
    scale = ab * bc
    scale *= ca
    np.divide(area, scale, out=scale, where=scale > 0)
    weights = np.empty((len(area), 3))
    for corner, across in enumerate((bc, ca, ab)):
        np.multiply(scale, across, out=weights[:, corner])
    return weights


def _unit_or_largest_face(surface: Surface, total: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """Sums of normals (n, 3) made unit; where they cancel (against `scale`, (n,)) the normal of
    the largest triangle around the vertex."""
    length = np.sqrt(np.einsum("nc,nc->n", total, total))
    lost = ~(length > 1e-9 * scale)
    total /= np.where(lost, 1.0, length)[:, None]
    if lost.any():
        total[lost] = _largest_face_normal(surface)[lost]
    return total


def _largest_face_normal(surface: Surface) -> np.ndarray:
    normal, area = surface.face_normal_area
    order = np.argsort(area, kind="stable")
    result = np.zeros((len(surface.vertices), 3))
    result[:, 2] = 1.0  # a vertex of degenerate triangles only; any unit vector will do
    sound = order[area[order] > 0]
    # Assigned in rising order of area, so that the largest triangle's normal stays.
    result[surface.triangles[sound].ravel()] = np.repeat(normal[sound], 3, axis=0)
    return result


def smooth_normals(
    surface: Surface, normals: np.ndarray, passes: int, progress: Progress | None = None
) -> np.ndarray:
    """`passes` of a linear filter over unit normals (n, 3): the paper's normal smoothing.

    Each pass replaces a normal by the mean over the vertex and its one-ring, weighted by the
    area around each vertex so that crowded vertices do not count more, and makes it unit
    length again. A normal whose mean vanishes is kept.
    """
    if passes <= 0:
        return normals.copy()
    return Smoothing(surface).smoothed(normals, passes, progress)


class Smoothing:
    """The filter of `smooth_normals` over a surface, for passes with something between them."""

    def __init__(self, surface: Surface) -> None:
        self.surface, self.area = surface, surface.vertex_area
        self.start, self.neighbours = surface.neighbour_start, surface.neighbours

    def smoothed(
        self, normals: np.ndarray, passes: int, progress: Progress | None = None
    ) -> np.ndarray:
        """(n, 3) unit normals after so many passes, at least one."""
        n = len(self.area)
        for _ in range(passes):
            after = np.empty((n, 3))

            def block(first: int, before: np.ndarray = normals, after: np.ndarray = after) -> None:
                rows = slice(first, first + BLOCK)
                begin = self.start[first : first + BLOCK + 1]
                around = self.neighbours[begin[0] : begin[-1]]
                after[rows] = self._means(before, rows, around, begin - begin[0])

            run(block, range(0, n, BLOCK), progress.quiet() if progress else Progress())
            normals = after
        return normals

    def smoothed_at(self, normals: np.ndarray, passes: int, vertices: np.ndarray) -> np.ndarray:
        """(n, 3) normals that are at some vertices (v,) what so many passes make of them, at the
        cost of what there is around these."""
        normals = normals.copy()
        for left in reversed(range(passes)):
            rows = ring_around(self.surface, vertices, left)
            count = self.start[rows + 1] - self.start[rows]
            around = self.neighbours[spans(self.start[rows], count)]
            begin = np.append(0, np.cumsum(count))
            normals[rows] = self._means(normals, rows, around, begin)
        return normals

    def _means(
        self, before: np.ndarray, rows: np.ndarray | slice, around: np.ndarray, begin: np.ndarray
    ) -> np.ndarray:
        """(r, 3) unit means of normals (n, 3) over vertices and what is `around` each of them,
        from `begin` (r + 1,) on."""
        weights = self.area.take(around, mode="clip")
        ring = sparse.csr_array((weights, around, begin), shape=(len(begin) - 1, len(before)))
        own = self.area[rows]
        mean = ring @ before + own[:, None] * before[rows]
        length = np.sqrt(np.einsum("rc,rc->r", mean, mean))
        # No ring is empty.
        kept = ~(length > 1e-9 * (own + np.add.reduceat(weights, begin[:-1])))
        if kept.any():
            mean[kept], length[kept] = before[rows][kept], 1.0
        return mean / length[:, None]
