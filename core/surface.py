"""The surface as it is analysed: a clean oriented manifold made of the input mesh."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .parallel import run
from .progress import Progress

# Triangles per block: long enough that handing over the interpreter lock costs little.
BLOCK = 32768


@dataclass(frozen=True)
class Surface:
    """An oriented triangle manifold, possibly with border and several components.

    Every edge has one or two triangles, every vertex one fan of triangles, windings agree.
    `core.cleaning` makes it from any input; isolated vertices are not part of it.

    Attributes
    ----------
    vertices:
        (n, 3) float64 positions, moved and scaled to a unit box (see `origin` and `unit`).
    triangles:
        (m, 3) int32 corners, outward winding.
    source_vertex, source_triangle:
        (n,), (m,) int64 rows of the input that each vertex and triangle came from. A vertex of
        the input where sheets only touch appears once for each sheet.
    twin:
        (3 m,) int32 the half-edge that shares the edge from corner k to k + 1 of triangle t,
        for half-edge 3 t + k; -1 on a border.
    neighbour_start, neighbours:
        (n + 1,) and (e,) int32: the one-ring of vertex i is
        neighbours[neighbour_start[i]:neighbour_start[i + 1]], ascending.
    border:
        (n,) bool, True at vertices on an open border.
    component:
        (n,) int32 connected component of each vertex.
    origin, unit:
        (3,) float64 and float: input position = vertices * unit + origin.
    """

    vertices: np.ndarray
    triangles: np.ndarray
    source_vertex: np.ndarray
    source_triangle: np.ndarray
    twin: np.ndarray
    neighbour_start: np.ndarray
    neighbours: np.ndarray
    border: np.ndarray
    component: np.ndarray
    origin: np.ndarray
    unit: float

    @cached_property
    def _faces(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(m, 3) unit normals, (m,) areas and (3, m) squared lengths of the sides ab, bc, ca."""
        m = len(self.triangles)
        normals, areas, squares = np.empty((m, 3)), np.empty(m), np.empty((3, m))

        def block(first: int) -> None:
            rows = slice(first, first + BLOCK)
            a, b, c = (self.vertices[corner].T for corner in self.triangles[rows].T)
            sides = b - a, c - b, a - c
            for square, side in zip(squares, sides, strict=True):
                np.einsum("cr,cr->r", side, side, out=square[rows])
            cross = np.cross(sides[0], sides[1], axis=0)
            length = np.sqrt(np.einsum("cr,cr->r", cross, cross))
            normals[rows] = (cross / np.maximum(length, np.finfo(float).tiny)).T
            areas[rows] = 0.5 * length

        run(block, range(0, m, BLOCK), Progress())
        return normals, areas, squares

    @property
    def face_normal_area(self) -> tuple[np.ndarray, np.ndarray]:
        """(m, 3) unit normals of the triangles and (m,) their areas."""
        return self._faces[:2]

    @property
    def side_squares(self) -> np.ndarray:
        """(3, m) squared lengths of the sides ab, bc and ca of the triangles abc."""
        return self._faces[2]

    def near_border(self, rings: int) -> np.ndarray:
        """(n,) bool, True at vertices within so many edges of a border."""
        near = self.border
        if near.any():
            owner = np.repeat(np.arange(len(near)), np.diff(self.neighbour_start))
            for _ in range(rings):
                near = near.copy()
                near[owner[near[self.neighbours]]] = True
        return near

    @cached_property
    def euler_characteristic(self) -> np.ndarray:
        """(components,) int64 V - E + F of each component."""
        count = int(self.component.max()) + 1 if len(self.component) else 0
        vertices = np.bincount(self.component, minlength=count)
        owner = self.component[self.triangles[:, 0]]
        faces = np.bincount(owner, minlength=count)
        on_border = np.bincount(owner[np.flatnonzero(self.twin < 0) // 3], minlength=count)
        # Every inner edge is two half-edges, every border edge one.
        edges = (3 * faces + on_border) // 2
        return vertices - edges + faces

    @cached_property
    def closed(self) -> np.ndarray:
        """(components,) bool, True where a component has no border."""
        count = int(self.component.max()) + 1 if len(self.component) else 0
        return np.bincount(self.component, weights=self.border, minlength=count) == 0
