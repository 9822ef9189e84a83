"""A map of a cut surface to the plane that follows its crosses and matches across the cut.

The gradients of the map come as close as they can to the directions of the crosses, in the sense
of least squares, under linear conditions: across the cut the map goes on turned by the matching
and shifted, and along features one coordinate stays. Whole numbers are not asked for here
(Bommer et al. 2009, 10.1145/1531326.1531383; Myles & Zorin 2013, 10.1145/2461912.2461970).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from ....base.plane import corner_angles, doubled_areas
from ....mesh.half_edges import following
from ..field.crosses import QUARTER, TURNS, Crosses, distances, fans
from ..field.sectors import sector_turns
from .elimination import free_basis
from .seams import Seams, seams

# No triangle weighs less than this part of the mean.
LEAST_WEIGHT = 0.02
# How far the wanted Jacobians are off the identity.
TRACE = 1e-3
# What turning off sure directions counts beside stretching: quads may be longer than wide, but
# lines of curvature are where they are. At poles, in so many lengths of quads, both count alike:
# there the map is a cone, which turns in any way. Chosen on waves 0 to 11 of the benchmark: with 20
# maps are 0.4 degrees nearer, and 6 of them have to be loosened in place of 4; confirmed on its
# real surfaces.
FOLLOWED, LOOSE = 10.0, 2.0


@dataclass(frozen=True)
class SeamlessProblem:
    """The unknowns and conditions of a seamless map.

    Attributes
    ----------
    crosses, seams:
        What is mapped and how it is cut.
    unknown:
        (m, 6) int64 unknown that is the real part of each triangle's corner, then the imaginary
        parts; coordinates that features hold equal are one unknown.
    shifts:
        (4 c, unknowns) sparse: what the c edges of the cut shift the map by, as the real and the
        imaginary parts at their starts, then at their ends.
    weight:
        (m,) float64 areas over their mean.
    target:
        (m, 4) float64 Jacobians that are wanted: the identity but for a trace that keeps poles
        from lying on one line of the map by accident of symmetry.
    shear:
        (m,) float64 what a map counts that turns off the crosses beside one that stretches along
        them.
    """

    crosses: Crosses
    seams: Seams
    unknown: np.ndarray
    shifts: sparse.csr_array
    weight: np.ndarray
    target: np.ndarray
    shear: np.ndarray

    @cached_property
    def count(self) -> int:
        """How many unknowns there are."""
        return self.shifts.shape[1]

    @cached_property
    def conditions(self) -> sparse.csr_array:
        """(2 c, unknowns): times the unknowns it must be 0, both ends being shifted alike."""
        half = self.shifts.shape[0] // 2
        return (self.shifts[:half] - self.shifts[half:]).tocsr()

    def basis(self, moving: np.ndarray | None = None) -> sparse.csr_array:
        """(unknowns, f) how all unknowns change by free ones, where only those `moving` (k,) do.

        Free are shifts along pieces of the cut and, at each vertex, one of its copies.
        """
        edges = self.shifts.shape[0] // 4
        if moving is None:
            moving = np.arange(self.count)
        shifts = self.shifts[:, moving]
        cut = np.flatnonzero(np.diff(shifts.indptr).reshape(4, edges).any(axis=0))
        rows = (np.arange(4)[:, None] * edges + cut).ravel()
        one = sparse.eye_array(2 * len(cut))
        own = free_basis(
            sparse.hstack([shifts[rows], -sparse.vstack([one, one])]), len(moving)
        ).tocoo()
        place = moving[own.row], own.col
        return sparse.coo_array((own.data, place), shape=(self.count, own.shape[1])).tocsr()

    @cached_property
    def whole_basis(self) -> sparse.csr_array:
        """The basis in which all unknowns move."""
        return self.basis()

    @cached_property
    def owner(self) -> np.ndarray:
        """(unknowns, n) which vertices' copies each unknown is a coordinate of, as 0 and 1."""
        rows = self.unknown.ravel()
        columns = np.concatenate([self.crosses.triangles] * 2, axis=1).ravel()
        shape = (self.count, len(self.crosses.vertices))
        found = sparse.coo_array((np.ones(len(rows)), (rows, columns)), shape=shape).tocsr()
        found.data[:] = 1.0
        return found

    @cached_property
    def derivative(self) -> np.ndarray:
        """(m, 4, 6) takes the unknowns of a triangle to its Jacobian, u_x, u_y, v_x, v_y."""
        gradient = _gradients(self.crosses.corner * TURNS[-self.seams.comb % 4][:, None])
        result = np.zeros((len(gradient), 4, 6))
        result[:, 0, :3] = result[:, 2, 3:] = gradient.real
        result[:, 1, :3] = result[:, 3, 3:] = gradient.imag
        return result

    def jacobian(self, x: np.ndarray) -> np.ndarray:
        """(m, 4) Jacobians of the solution x."""
        return np.einsum("mij,mj->mi", self.derivative, x[self.unknown])

    def places(self, x: np.ndarray) -> np.ndarray:
        """(m, 3) complex128 corners of the triangles in the plane."""
        value = x[self.unknown]
        return value[:, :3] + 1j * value[:, 3:]

    def turns(self, x: np.ndarray) -> np.ndarray:
        """(n,) right angles that the triangles around each vertex make in the plane."""
        angle = corner_angles(self.places(x))
        return np.bincount(self.crosses.tail, angle, len(self.crosses.vertices)) / QUARTER

    @cached_property
    def _sectors(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Corners of the sectors between features one after the other, where each starts, its
        vertex and the turns that it should make."""
        first, turns = sector_turns(self.crosses)
        if not len(first):
            return first, first, first, turns
        corner, start = fans(self.crosses.twin, self.crosses.feature, first)
        return corner, start[:-1], self.crosses.tail[first], turns

    def wound_wrongly(self, x: np.ndarray) -> np.ndarray:
        """(v,) vertices around which, or in a sector of which, the map makes other than the wanted
        turns."""
        crosses = self.crosses
        angle = corner_angles(self.places(x))
        total = np.bincount(crosses.tail, angle, len(crosses.vertices)) / QUARTER
        wrong = np.abs(total - crosses.quarter_turns) > 0.5
        wrong &= ~crosses.border & ~crosses.on_feature
        corner, start, vertex, turns = self._sectors
        if len(start):
            made = np.add.reduceat(angle[corner], start) / QUARTER
            wrong[vertex[np.abs(made - turns) > 0.5]] = True
        return np.flatnonzero(wrong)


@dataclass(frozen=True)
class SeamlessMap:
    """A seamless map, see `SeamlessProblem`.

    Attributes
    ----------
    crosses, seams:
        As of the problem.
    place:
        (m, 3) complex128 corners of the triangles in the plane, in lengths of quads.
    """

    crosses: Crosses
    seams: Seams
    place: np.ndarray


def pose(crosses: Crosses, follow: np.ndarray | None = None) -> SeamlessProblem:
    """The problem of a map along the crosses, which matter as much as `follow` (m,) says; None for
    no more than even sizes do."""
    cut = seams(crosses)
    n = cut.count
    edge = np.flatnonzero(cut.cut)
    edge = edge[edge < crosses.twin[edge]]
    sheet = cut.sheet.ravel()
    other = crosses.twin[edge]
    near = sheet[following(edge)], sheet[edge]
    far = sheet[other], sheet[following(other)]
    turn = TURNS[cut.matching[edge]]
    # far - turn near at each end, as rows for the real and the imaginary part.
    row = np.arange(len(edge))
    entries = []
    for side in (0, 1):
        for imaginary, first, second in ((0, turn.real, -turn.imag), (1, turn.imag, turn.real)):
            part = (2 * side + imaginary) * len(edge) + row
            entries += [
                (part, imaginary * n + far[side], np.ones(len(row))),
                (part, near[side], -first),
                (part, n + near[side], -second),
            ]
    rows, columns, values = (np.concatenate(part) for part in zip(*entries, strict=True))
    unknown, number = _merged(cut)
    shifts = sparse.coo_array(
        (values, (rows, unknown[columns])), shape=(4 * len(edge), number)
    ).tocsr()
    shifts.eliminate_zeros()
    area = 0.5 * doubled_areas(crosses.corner)
    corner = np.concatenate([unknown[cut.sheet], unknown[n + cut.sheet]], axis=1)
    weight = np.maximum(area / area.mean(), LEAST_WEIGHT)
    target = np.array([1.0, 0.0, 0.0, 1.0]) + TRACE * _scatter(crosses.vertices, crosses.triangles)
    shear = np.ones(len(weight))
    if follow is not None:
        pole = np.flatnonzero(crosses.singular)
        far = distances(crosses, pole, LOOSE)[crosses.triangles].min(axis=1)
        shear += (FOLLOWED - 1.0) * follow * np.minimum(far / LOOSE, 1.0)
    return SeamlessProblem(crosses, cut, corner, shifts, weight, target, shear)


def determinant(jacobian: np.ndarray) -> np.ndarray:
    """(m,) determinants of Jacobians (m, 4)."""
    return jacobian[:, 0] * jacobian[:, 3] - jacobian[:, 1] * jacobian[:, 2]


def _merged(cut: Seams) -> tuple[np.ndarray, int]:
    """(2 copies,) the unknown of each coordinate, and how many there are.

    Along a feature on the real axis the imaginary parts are one unknown, and the other way.
    """
    n = cut.count
    edge = np.flatnonzero(cut.axis >= 0)
    shift = np.where(cut.axis[edge] == 0, n, 0)
    sheet = cut.sheet.ravel()
    one, two = sheet[edge] + shift, sheet[following(edge)] + shift
    graph = sparse.coo_array((np.ones(len(edge)), (one, two)), shape=(2 * n, 2 * n))
    number, unknown = csgraph.connected_components(graph, directed=False)
    return unknown.astype(np.int64), int(number)


def _scatter(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """(m, 4) smooth values within -1 and 1 that no symmetry of the surface shares."""
    waves = np.random.default_rng(0).normal(size=(3, 4))
    return np.sin(vertices[triangles].mean(axis=1) @ (3.0 * waves) + waves[0])


def _gradients(corner: np.ndarray) -> np.ndarray:
    """(m, 3) complex gradients of the hat functions at corners (m, 3)."""
    side = np.roll(corner, 1, axis=1) - np.roll(corner, -1, axis=1)
    least = 1e-6 * (np.abs(side) ** 2).max(axis=1)
    double = np.maximum(doubled_areas(corner), np.maximum(least, np.finfo(float).tiny))
    return 1j * side / double[:, None]
