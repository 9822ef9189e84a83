"""The surface as it is analysed: a clean oriented manifold made of the input mesh."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..base.parallel import run
from ..base.progress import Progress

# Triangles per block: long enough that handing over the interpreter lock costs little.
BLOCK = 32768
# Likewise where their corners are only gathered.
GATHERED = 1 << 18
# An area in the unit box that is round-off of its coordinates.
NO_AREA = float(np.finfo(float).eps) ** 2


@dataclass(frozen=True)
class Surface:
    """An oriented triangle manifold, possibly with border and several components.

    Every edge has one or two triangles, every vertex one fan of triangles, windings agree.
    `core.mesh.mending.repair.clean` makes it from any input; isolated vertices are not part of it.

    Attributes
    ----------
    vertices:
        (n, 3) float64 positions, moved and scaled to a unit box (see `origin` and `unit`).
    triangles:
        (m, 3) int32 corners, outward winding.
    source_vertex, source_triangle:
        (n,), (m,) int64 rows of the input that each vertex and triangle came from. A vertex of
        the input where sheets only touch appears once for each sheet, a triangle that was split
        once for each part. `core.mesh.input_map` goes there and back.
    joined:
        (j, 2) int64 input vertices without one of their own, and those that they were joined
        with.
    recut, recut_corners:
        (r,) int64 ascending rows of the triangles that were turned or are parts of one of the
        input, and (r, 3, 3) float64 their corners as weights of its corners.
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
    joined: np.ndarray
    recut: np.ndarray
    recut_corners: np.ndarray

    @cached_property
    def coordinates(self) -> np.ndarray:
        """(3, n) the vertices coordinate by coordinate, to gather from."""
        return np.ascontiguousarray(self.vertices.T)

    @cached_property
    def _faces(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """(m, 3) unit normals, (m,) areas, (3, m) squared lengths of the sides ab, bc, ca and
        (m,) signed volumes of the tetrahedra from the origin to the triangles."""
        m = len(self.triangles)
        normals, areas = np.empty((m, 3)), np.empty(m)
        squares, volumes = np.empty((3, m)), np.empty(m)

        coordinates = self.coordinates

        def block(first: int) -> None:
            rows = slice(first, first + BLOCK)
            abc = np.ascontiguousarray(self.triangles[rows].T)
            corners, sides = np.empty((2, 3, *abc.shape))
            for here, at, side in zip(coordinates, corners, sides, strict=True):
                np.take(here, abc, out=at, mode="clip")
                np.subtract(at[1:], at[:2], out=side[:2])
                np.subtract(at[0], at[2], out=side[2])
            np.einsum("ckr,ckr->kr", sides, sides, out=squares[:, rows])
            (ax, bx, _), (ay, by, _), (az, bz, _) = sides
            cross = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
            x, y, z = cross
            length = np.sqrt(x * x + y * y + z * z)
            np.multiply(0.5, length, out=areas[rows])
            from_origin = corners[:, 0]
            volumes[rows] = np.einsum("cr,cr->r", from_origin, np.stack(cross)) / 6.0
            np.maximum(length, np.finfo(float).tiny, out=length)
            for along, out in zip(cross, normals[rows].T, strict=True):
                np.divide(along, length, out=out)

        run(block, range(0, m, BLOCK), Progress())
        return normals, areas, squares, volumes

    @property
    def face_normal_area(self) -> tuple[np.ndarray, np.ndarray]:
        """(m, 3) unit normals of the triangles and (m,) their areas."""
        return self._faces[:2]

    @property
    def side_squares(self) -> np.ndarray:
        """(3, m) squared lengths of the sides ab, bc and ca of the triangles abc."""
        return self._faces[2]

    @cached_property
    def vertex_area(self) -> np.ndarray:
        """(n,) area of the triangles around each vertex."""
        around = np.repeat(self._faces[1], 3)
        return np.bincount(self.triangles.ravel(), around, minlength=len(self.vertices))

    @property
    def owner(self) -> np.ndarray:
        """(e,) int64 the vertex whose one-ring each of the `neighbours` is in."""
        return np.repeat(np.arange(len(self.vertices)), np.diff(self.neighbour_start))

    @property
    def ring_lengths(self) -> np.ndarray:
        """(e,) length of the edge to each of the `neighbours`."""
        # Coordinate by coordinate: several times faster than along the rows of (e, 3).
        valence, squares = np.diff(self.neighbour_start), np.zeros(len(self.neighbours))
        for here in self.coordinates:
            offset = here.take(self.neighbours, mode="clip")
            offset -= np.repeat(here, valence)
            squares += np.square(offset, out=offset)
        return np.sqrt(squares, out=squares)

    @property
    def mean_side(self) -> float:
        """Mean length of the sides of all triangles."""
        return float(np.sqrt(self.side_squares).mean())

    @property
    def usual_side(self) -> float:
        """About the side of an equilateral triangle of the median area, of those with any; 0 where
        there are none."""
        area = self._faces[1][self._faces[1] > 0]
        return 1.5 * float(np.sqrt(np.median(area))) if len(area) else 0.0

    def mean_sides(self, rows: np.ndarray) -> np.ndarray:
        """(r,) mean length of the sides of the triangles `rows` (r,)."""
        return np.sqrt(self.side_squares[:, rows]).mean(axis=0)

    @cached_property
    def least_height(self) -> np.ndarray:
        """(m,) the smallest of the three heights of each triangle."""
        longest = np.sqrt(self.side_squares.max(axis=0))
        return 2.0 * self._faces[1] / np.maximum(longest, np.finfo(float).tiny)

    @cached_property
    def volume(self) -> np.ndarray:
        """(components,) volume within each closed component, negative with normals inwards."""
        volumes = self._faces[3]
        if self.component_count == 1:
            return volumes.sum(keepdims=True)
        return self.by_component(slice(None), volumes)

    def at_corners(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Values (n,) at the corners a, b, c of the triangles, (m,) each: several times faster than
        as (m, 3), and to reduce as well."""
        m = len(self.triangles)
        a, b, c = found = np.empty((3, m), values.dtype)

        def block(first: int) -> None:
            rows = slice(first, first + GATHERED)
            for corner, at in zip(self.triangles[rows].T, found[:, rows], strict=True):
                np.take(values, corner, out=at, mode="clip")

        run(block, range(0, m, GATHERED), Progress())
        return a, b, c

    def touching(self, vertices: np.ndarray) -> np.ndarray:
        """Ascending rows of the triangles with a corner among the vertices (n,) bool."""
        a, b, c = self.at_corners(vertices)
        return np.flatnonzero(a | b | c)

    def with_two_of(self, vertices: np.ndarray) -> np.ndarray:
        """Ascending rows of the triangles with two corners among the vertices (n,) bool."""
        a, b, c = self.at_corners(vertices)
        return np.flatnonzero((a & b) | (b & c) | (c & a))

    def near_border(self, rings: int) -> np.ndarray:
        """(n,) bool, True at vertices within so many edges of a border."""
        near = self.border
        if near.any():
            owner = self.owner
            for _ in range(rings):
                near = near.copy()
                near[owner[near[self.neighbours]]] = True
        return near

    @cached_property
    def component_count(self) -> int:
        """How many connected components there are."""
        return int(self.component.max()) + 1 if len(self.component) else 0

    def by_component(
        self, triangles: np.ndarray | slice, weights: np.ndarray | None = None
    ) -> np.ndarray:
        """(components,) number of the given triangles in each component, or sum of weights."""
        owner = self.component[self.triangles[triangles, 0]]
        return np.bincount(owner, weights=weights, minlength=self.component_count)

    @cached_property
    def euler_characteristic(self) -> np.ndarray:
        """(components,) int64 V - E + F of each component."""
        vertices = np.bincount(self.component, minlength=self.component_count)
        if self.component_count == 1:
            faces = np.array([len(self.triangles)])
        else:
            faces = self.by_component(slice(None))
        on_border = self.by_component(np.flatnonzero(self.twin < 0) // 3)
        # Every inner edge is two half-edges, every border edge one.
        edges = (3 * faces + on_border) // 2
        return vertices - edges + faces

    @cached_property
    def closed(self) -> np.ndarray:
        """(components,) bool, True where a component has no border."""
        closed = np.ones(self.component_count, bool)
        closed[self.component[self.border]] = False
        return closed


def relative_areas(vertices: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, float]:
    """(m,) areas of triangles (m, 3), in a square whose side is the other number: no size is too
    large for that."""
    corner = vertices[triangles]
    side = float(np.abs(corner[np.isfinite(corner)]).max(initial=0.0)) or 1.0
    a, b, c = (corner / side).transpose(1, 0, 2)
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1), side
