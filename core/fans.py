"""The triangles around each vertex in cyclic order."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .surface import Surface


def successors(surface: Surface) -> np.ndarray:
    """(3m,) int32: the next corner around the same vertex, anticlockwise; -1 at a border.

    Corner 3 * triangle + position also names the half-edge that leaves it.
    """
    # The side that comes back to a corner leaves the corner before it.
    return np.roll(surface.twin.reshape(-1, 3), 1, axis=1).ravel()


@dataclass(frozen=True)
class Fans:
    """The corners around each vertex in anticlockwise order.

    Attributes
    ----------
    start:
        (n + 1,) int64: the corners of vertex i are corners[start[i]:start[i + 1]].
    corners:
        (3m,) int64 corner numbers 3 * triangle + position. At a border vertex the first
        corner is the one that has no corner before it.
    """

    start: np.ndarray
    corners: np.ndarray

    def triangles(self) -> np.ndarray:
        """(3m,) the triangle of each corner."""
        return self.corners // 3

    def ring(self, triangles: np.ndarray) -> np.ndarray:
        """(3m,) the neighbour that each corner's outgoing side ends at, in the same order.

        At an inner vertex this is the whole one-ring; at a border vertex its last neighbour,
        the start of the side that comes back to the last corner, is left out.
        """
        return np.roll(triangles, -1, axis=1).ravel()[self.corners]


def ordered_fans(surface: Surface) -> Fans:
    """The fans of all vertices (n) of a surface of m triangles."""
    triangles, n = surface.triangles, len(surface.vertices)
    corner_vertex = triangles.ravel()
    after = successors(surface)
    count = np.bincount(corner_vertex, minlength=n)
    start = np.concatenate([[0], np.cumsum(count)])
    # A fan begins at the corner that follows none, and anywhere at an inner vertex.
    current = np.full(n, -1, dtype=np.int64)
    current[corner_vertex[::-1]] = np.arange(len(corner_vertex))[::-1]
    opening = np.ones(len(corner_vertex), dtype=bool)
    opening[after[after >= 0]] = False
    current[corner_vertex[opening]] = np.flatnonzero(opening)
    corners = np.empty(len(corner_vertex), dtype=np.int64)
    vertex = np.flatnonzero(count > 0)
    # One step around all vertices at a time; those whose fan is complete fall out.
    for step in range(int(count.max(initial=0))):
        vertex = vertex[count[vertex] > step]
        corners[start[vertex] + step] = current[vertex]
        current[vertex] = after[current[vertex]]
    return Fans(start, corners)
