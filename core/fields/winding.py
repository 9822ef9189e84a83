"""The index of the principal direction field in each triangle, consistent over the surface.

The turn of the field along an edge is decided once and shared by both its triangles, so what
one triangle counts the other cannot lose: over a closed component the indices sum to the
Euler characteristic exactly, whatever the noise (the discrete Poincare-Hopf theorem).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base.parallel import run
from ..base.progress import Progress
from ..base.subsets import places_in
from ..base.unit import phase
from ..mesh.half_edges import ends_of, previous
from ..mesh.surface import BLOCK, Surface

# Cosine between normals along an edge below which the whole triangle is looked at.
ALIKE = 0.8
# How much real parts must exceed imaginary ones for round-off not to matter.
ABOVE_ROUND_OFF = 1.001


@dataclass(frozen=True)
class Winding:
    """The index of a line field in each triangle, and what follows its changes.

    Attributes
    ----------
    index:
        (m,) float64 as from `certified_index`.
    by_normals:
        (m,) float64 before the sums over closed components are seen to.
    symmetry:
        As `certified_index` takes it.
    """

    index: np.ndarray
    by_normals: np.ndarray
    symmetry: int = 2

    @classmethod
    def of(
        cls, surface: Surface, d1: np.ndarray, d2: np.ndarray, progress: Progress, symmetry: int = 2
    ) -> Winding:
        """That of a field as `certified_index` takes it."""
        by_normals = _by_vertex_normals(surface, d1, d2, progress, symmetry)
        return cls(_with_exact_sums(surface, by_normals, d1, d2, symmetry), by_normals, symmetry)

    def after(
        self, surface: Surface, vertices: np.ndarray, d1: np.ndarray, d2: np.ndarray
    ) -> Winding:
        """That of the field d1, d2, which differs from the one before at some vertices (k,)."""
        if 2 * len(vertices) > len(d1):
            return Winding.of(surface, d1, d2, Progress(), self.symmetry)
        changed = np.zeros(len(d1), bool)
        changed[vertices] = True
        rows = surface.touching(changed)
        by_normals = self.by_normals.copy()
        by_normals[rows] = _by_vertex_normals(surface, d1, d2, Progress(), self.symmetry, rows)
        index = _with_exact_sums(surface, by_normals, d1, d2, self.symmetry)
        return Winding(index, by_normals, self.symmetry)

    def turns(
        self, surface: Surface, half_edges: np.ndarray, d1: np.ndarray, d2: np.ndarray
    ) -> np.ndarray:
        """(e,) float64 in (-pi, pi]: the turns of `symmetry` times the angle of d1 along half-edges
        (e,), by the transport that the index is counted with.

        Where a direction turns by phi within its tangent plane, the turns along the half-edges that
        come to it grow by `symmetry` phi; as long as none leaves (-pi, pi), every index stays.
        """
        turns = np.empty(len(half_edges))
        frames = np.ascontiguousarray((d1 + 1j * d2).T)

        def block(first: int) -> None:
            some = half_edges[first : first + BLOCK]
            one, two = (frames.take(end, axis=1) for end in ends_of(surface.triangles, some))
            rotation = phase(np.einsum("ce,ce->e", one.conj(), two))
            turns[first : first + BLOCK] = _turn(rotation, self.symmetry)

        run(block, range(0, len(half_edges), BLOCK), Progress())
        wild = _wild(surface, self.by_normals)
        if len(wild):
            intrinsic, _ = _intrinsic_turns(surface, wild, d1, d2, self.symmetry)
            place = places_in(wild, len(surface.triangles))[half_edges // 3]
            inside = place >= 0
            turns[inside] = intrinsic[place[inside], half_edges[inside] % 3]
        return turns


def certified_index(
    surface: Surface,
    d1: np.ndarray,
    d2: np.ndarray,
    progress: Progress,
    symmetry: int = 2,
) -> np.ndarray:
    """(m,) float64 index of the field d1 in each triangle, a multiple of 1 / symmetry.

    With symmetry 2 d1 is a line field: 0, +0.5, -0.5, rarely more; with 4 a cross field.

    Vertex frames are carried along each edge by the smallest rotation between their normals.
    Where wild normals make these rotations wind differently from the surface, the component is
    done again by unfolding the angles around each vertex (Knoeppel et al. 2013), whose
    holonomies sum to 2 pi times the Euler characteristic by construction.

    Parameters
    ----------
    surface:
        The surface; n vertices, m triangles.
    d1, d2:
        (n, 3) float64 unit principal directions; d1 x d2 is the normal.
    symmetry:
        How many directions of the field a full turn holds, all of them equal: 2 or 4.
    """
    return Winding.of(surface, d1, d2, progress, symmetry).index


def _by_vertex_normals(
    surface: Surface,
    d1: np.ndarray,
    d2: np.ndarray,
    progress: Progress,
    symmetry: int,
    rows: np.ndarray | None = None,
) -> np.ndarray:
    """(r,) index of the triangles `rows` (r,), or of all, by the rotations between the vertex
    normals alone."""
    if rows is None:
        index = np.zeros(len(surface.triangles))
        rows = _around_turning_edges(surface, d1, d2, progress, symmetry)
        index[rows] = _by_vertex_normals(surface, d1, d2, progress, symmetry, rows)
        return index
    turns = np.zeros(len(rows))

    def block(first: int) -> None:
        corners = surface.triangles[rows[first : first + BLOCK]].T
        at = np.empty((3, *corners.shape), np.complex128)
        for part, vectors in ((at.real, d1), (at.imag, d2)):
            part[:] = np.moveaxis(vectors.take(corners, axis=0, mode="clip"), 2, 0)
        rotation = _rotations(at)
        wild = np.flatnonzero(~_calm(rotation, symmetry))
        if len(wild):
            edges = phase(rotation[:, wild])
            holonomy = np.angle(edges.prod(axis=0))
            turns[first + wild] = _turn(edges, symmetry).sum(axis=0) + symmetry * holonomy

    run(block, range(0, len(rows), BLOCK), progress)
    return np.rint(turns / (2 * np.pi)) / symmetry


def _around_turning_edges(
    surface: Surface, d1: np.ndarray, d2: np.ndarray, progress: Progress, symmetry: int
) -> np.ndarray:
    """Triangles that may have an index: all others have no edge along which `symmetry` times the
    angle of the field turns by more than a right angle, or the normals by more than cos^-1 `ALIKE`.

    Of three such edges the turns stay below three right angles, and the holonomy, the area of the
    spherical triangle of the normals, below 0.19: no full turn comes together, with symmetry 4
    either.
    """
    # Single precision halves the traffic and tells safely where the field hardly turns.
    frames = np.concatenate([d1, d2], axis=1, dtype=np.float32)
    start, neighbours = surface.neighbour_start, surface.neighbours
    turning = np.zeros(len(d1), bool)

    def block(first: int) -> None:
        own = np.arange(first, min(first + BLOCK, len(d1)))
        own = np.repeat(own, np.diff(start[first : first + BLOCK + 1]))
        other = neighbours[start[first] : start[first] + len(own)]
        once = own < other
        own, other = own[once], other[once]
        tail, head = frames.take(own, axis=0), frames.take(other, axis=0)
        rotation = np.empty(len(own), np.complex64)
        np.einsum("ec,ec->e", tail, head, out=rotation.real)
        rotation.imag = np.einsum("ec,ec->e", tail[:, :3], head[:, 3:])
        rotation.imag -= np.einsum("ec,ec->e", tail[:, 3:], head[:, :3])
        power = rotation if symmetry == 2 else rotation * rotation
        calm = np.abs(power.real) > ABOVE_ROUND_OFF * np.abs(power.imag)
        # The length of a rotation is one more than the cosine between the normals.
        calm &= np.square(rotation.real) + np.square(rotation.imag) > (1.0 + ALIKE) ** 2
        for end in (own[~calm], other[~calm]):
            turning[end] = True

    run(block, range(0, len(d1), BLOCK), progress)
    if not turning.any():
        return np.zeros(0, np.int64)
    return surface.with_two_of(turning)


def _rotations(at: np.ndarray) -> np.ndarray:
    """(3, b) exp(i rho) up to length for the edges ab, bc, ca of triangles with the frames
    `at` (3, 3, b) at a, b, c: rho turns the frame at an edge's tail into the one at its head.

    For frames m = d1 + i d2 it is conj(m_tail) . m_head, the rotation in the polar
    decomposition of the projection between the planes.
    """
    return np.einsum("ckr,ckr->kr", at.conj(), at[:, [1, 2, 0]])


def _calm(rotation: np.ndarray, symmetry: int) -> np.ndarray:
    """(b,) whether the index of triangles is zero without arctangents, from (3, b) rotations.

    Where each edge turns the doubled (or fourfold) angle by less than a right angle and the
    holonomy is small, the sum stays below a full turn.
    """
    power = rotation if symmetry == 2 else rotation * rotation
    around = power[0] * power[1] * power[2]
    calm = (np.abs(power.real) > ABOVE_ROUND_OFF * np.abs(power.imag)).all(axis=0)
    return calm & (around.real > ABOVE_ROUND_OFF * np.abs(around.imag))


def _turn(rotation: np.ndarray, symmetry: int) -> np.ndarray:
    """Turn of `symmetry` times the angle of d1 along an edge, in (-pi, pi]."""
    return np.angle(np.conj(rotation) ** symmetry)


def _with_exact_sums(
    surface: Surface, index: np.ndarray, d1: np.ndarray, d2: np.ndarray, symmetry: int
) -> np.ndarray:
    """Redo the closed components whose indices do not sum to their Euler characteristic."""
    rows = _wild(surface, index)
    if len(rows):
        turn, holonomy = _intrinsic_turns(surface, rows, d1, d2, symmetry)
        turns = turn.sum(axis=1) + symmetry * holonomy
        index = index.copy()
        index[rows] = np.rint(turns / (2 * np.pi)) / symmetry
    return index


def _wild(surface: Surface, index: np.ndarray) -> np.ndarray:
    """Triangles of the closed components whose indices (m,) do not sum to their Euler
    characteristic."""
    turning = np.flatnonzero(index)
    sums = surface.by_component(turning, index[turning])
    wrong = surface.closed & (sums != surface.euler_characteristic)
    if not wrong.any():
        return np.zeros(0, np.int64)
    return np.flatnonzero(wrong[surface.component[surface.triangles[:, 0]]])


def _intrinsic_turns(
    surface: Surface, rows: np.ndarray, d1: np.ndarray, d2: np.ndarray, symmetry: int
) -> tuple[np.ndarray, np.ndarray]:
    """Turns (r, 3) along the sides of the triangles `rows` (whole closed components) and their
    holonomy (r,), by angles scaled to 2 pi around every vertex."""
    half_edges = (3 * rows[:, None] + np.arange(3)).ravel()
    tails = surface.triangles.ravel()[half_edges]
    local = places_in(half_edges, 3 * len(surface.triangles))
    corner_angle = _corner_angles(surface, rows)
    total = np.bincount(tails, weights=corner_angle, minlength=len(d1))
    valence = np.bincount(tails, minlength=len(d1))
    scaled = np.where(
        total[tails] > 0,
        2 * np.pi * corner_angle / np.where(total > 0, total, 1.0)[tails],
        2 * np.pi / valence[tails],
    )
    # Walk each fan anticlockwise from its first half-edge, adding up the angles.
    next_around = local[surface.twin[previous(half_edges)]]
    angle = np.zeros(len(half_edges))
    # What is written last stays: of each vertex its first half-edge.
    leaving = np.full(len(d1), -1)
    leaving[tails[::-1]] = np.arange(len(tails))[::-1]
    vertex = np.flatnonzero(leaving >= 0)
    first = start = leaving[vertex]
    current, turned = first, np.zeros(len(first))
    while len(current):
        turned = turned + scaled[current]
        current = next_around[current]
        going = current != first
        first, current, turned = first[going], current[going], turned[going]
        angle[current] = turned
    # Angle of d1 in the same unfolding, by the first half-edge of each fan.
    _, heads = ends_of(surface.triangles, half_edges[start])
    edge = surface.vertices[heads] - surface.vertices[vertex]
    direction = np.zeros(len(d1))
    direction[vertex] = -np.arctan2(
        np.einsum("ij,ij->i", edge, d2[vertex]), np.einsum("ij,ij->i", edge, d1[vertex])
    )
    angle -= direction[tails]
    twin = local[surface.twin[half_edges]]
    # One value for both directions of an edge, so that the turns cancel to the last bit.
    lower = np.flatnonzero(half_edges < surface.twin[half_edges])
    rotation = angle[twin[lower]] + np.pi - angle[lower]
    turn = np.empty(len(angle))
    full = 2 * np.pi
    turn[lower] = full * np.rint(symmetry * rotation / full) - symmetry * rotation
    turn[twin[lower]] = -turn[lower]
    holonomy = scaled.reshape(-1, 3).sum(axis=1) - np.pi
    return turn.reshape(-1, 3), holonomy


def _corner_angles(surface: Surface, rows: np.ndarray) -> np.ndarray:
    """(3 r,) interior angle at each corner of the triangles `rows`, 0 where undefined."""
    sides = surface.side_squares[:, rows]
    ahead, back = sides, sides[[2, 0, 1]]
    # The product of two sides from a corner by the law of cosines, and their cross product.
    product = 0.5 * (ahead + back - sides[[1, 2, 0]])
    return np.arctan2(2.0 * surface.face_normal_area[1][rows], product).T.ravel()
