"""A field as the turns of its directions over the edges of a mesh, and the charges they enclose.

Angles are those of the field times its symmetry: a line field's angle is doubled, a cross
field's taken four times, so that a full turn is the least charge there is. Where the turns around
a place sum to 2 pi more, its charge is one more.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...base.subsets import places_in
from ...fields.directions import DirectionField
from ...fields.planes import FaceFrames, in_plane
from ...fields.winding import Winding
from ...mesh.half_edges import ends_of
from ...mesh.rings import with_rings
from ...mesh.surface import NO_AREA, Surface

# Cotangent weights outside these bounds come from slivers; a weight near zero lets all the
# turning happen over one edge.
LEAST_WEIGHT, LARGEST_WEIGHT = 0.05, 10.0
# Cost of a way where the directions mean nothing, to one where they mean as much as usual.
LEAST_COST = 0.05
# What usually is meant is at least this part of the largest: sums of costs stay exact enough.
USUAL = 1e-6


@dataclass(frozen=True)
class Turns:
    """e edges between n directions, which enclose c places where charges may be.

    Attributes
    ----------
    tail, head:
        (e,) int rows of the directions.
    turn:
        (e,) float64 in (-pi, pi], from tail to head.
    weight:
        (e,) float64 how much the edge resists to turning.
    left, right:
        (e,) int the places on both sides; the turn counts for the one and against the other.
        -1: outside the surface.
    cost:
        (e,) float64 of moving a charge from one to the other.
    directions, places:
        n and c.
    """

    tail: np.ndarray
    head: np.ndarray
    turn: np.ndarray
    weight: np.ndarray
    left: np.ndarray
    right: np.ndarray
    cost: np.ndarray
    directions: int
    places: int


@dataclass(frozen=True)
class Cutout:
    """A part of a surface to work on.

    Attributes
    ----------
    triangles, vertices:
        (r,) and (v,) int64 rows of the surface, ascending.
    """

    triangles: np.ndarray
    vertices: np.ndarray

    @classmethod
    def around(cls, surface: Surface, vertices: np.ndarray, rings: int) -> Cutout:
        """The triangles of all vertices within so many edges of the given ones."""
        near = np.zeros(len(surface.vertices), bool)
        near[vertices] = True
        near = with_rings(surface.triangles, near, rings)
        triangles = surface.touching(near)
        near[surface.triangles[triangles]] = True
        return cls(triangles, np.flatnonzero(near))

    @classmethod
    def whole(cls, surface: Surface) -> Cutout:
        """All of a surface."""
        return cls(np.arange(len(surface.triangles)), np.arange(len(surface.vertices)))

    def sides(self, surface: Surface) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(3 r,) the half-edges of its triangles, the twin of each (-1 on a border of the surface)
        and whether the cutout goes on beyond it."""
        half = (3 * self.triangles[:, None] + np.arange(3)).ravel()
        twin = surface.twin[half]
        inside = np.zeros(len(surface.triangles), bool)
        inside[self.triangles] = True
        return half, twin, (twin >= 0) & inside[twin // 3]

    def edges(self, surface: Surface) -> tuple[np.ndarray, np.ndarray]:
        """(e,) a half-edge of each of its edges but those beyond which the surface goes on and the
        cutout does not, and the twin of each."""
        half, twin, inner = self.sides(surface)
        chosen = np.flatnonzero((twin < 0) | (inner & (half < twin)))
        return half[chosen], twin[chosen]

    def weights(self, surface: Surface, half: np.ndarray, twin: np.ndarray) -> np.ndarray:
        """(e,) half the sum of the cotangents across from each of its `edges`, within bounds."""
        squares = surface.side_squares[:, self.triangles]
        area = np.maximum(surface.face_normal_area[1][self.triangles], NO_AREA)
        # Across from a side the cotangent is that of the angle between the two others.
        quarter = (squares.sum(axis=0) - 2.0 * squares) / (8.0 * area)
        across = np.zeros(surface.triangles.size)
        across.reshape(-1, 3)[self.triangles] = quarter.T
        both = across[half] + np.where(twin >= 0, across[twin], 0.0)
        return np.clip(both, LEAST_WEIGHT, LARGEST_WEIGHT)

    def rim(self, surface: Surface) -> np.ndarray:
        """(v,) bool, its vertices that have triangles beyond."""
        count = np.bincount(surface.triangles.ravel(), minlength=len(surface.vertices))
        mine = np.bincount(
            surface.triangles[self.triangles].ravel(), minlength=len(surface.vertices)
        )
        return (mine < count)[self.vertices]


def turns_at_vertices(
    surface: Surface, cutout: Cutout, field: DirectionField, winding: Winding
) -> Turns:
    """The turns of a field at the vertices of a cutout; its charges, the index times the symmetry,
    in triangles. Charges go rather where the magnitude is small.

    Parameters
    ----------
    winding:
        That of the field.
    """
    half, twin = cutout.edges(surface)
    tail, head = ends_of(surface.triangles, half)
    here, there = half // 3, twin // 3
    # From the middle of one triangle to that of the other, by a third of their heights.
    area = surface.face_normal_area[1]
    length = np.sqrt(surface.side_squares[half % 3, here])
    both = area[here] + np.where(twin >= 0, area[there], 0.0)
    way = both / (1.5 * np.maximum(length, np.finfo(float).tiny))
    size = np.nan_to_num(field.magnitude)
    # Where most of a surface is flat the usual magnitude is nothing.
    typical = max(float(np.median(size)), USUAL * float(size.max()), np.finfo(float).tiny)
    place = places_in(cutout.triangles, len(surface.triangles))
    row = places_in(cutout.vertices, len(surface.vertices))
    return Turns(
        tail=row[tail],
        head=row[head],
        turn=winding.turns(surface, half, field.direction, field.across),
        weight=cutout.weights(surface, half, twin),
        left=place[here],
        right=np.where(twin >= 0, place[there], -1),
        cost=way * (0.5 * (size[tail] + size[head]) / typical + LEAST_COST),
        directions=len(cutout.vertices),
        places=len(cutout.triangles),
    )


def turns_in_triangles(
    surface: Surface, cutout: Cutout, planes: FaceFrames, direction: np.ndarray
) -> Turns:
    """The turns of a cross field in the triangles of a cutout, each the smallest one across its
    edge; its charges, four times the index, at vertices. Border edges enclose nothing.

    Parameters
    ----------
    direction:
        (m, 3) float64 one direction of the cross in each triangle.
    """
    half, twin, inner = cutout.sides(surface)
    chosen = inner & (half < twin)
    half, twin = half[chosen], twin[chosen]
    cross = np.zeros(len(surface.triangles), complex)
    cross[cutout.triangles] = in_plane(surface, cutout.triangles, direction[cutout.triangles]) ** 4
    here, there = half // 3, twin // 3
    carried = cross[here] * planes.turn[half] ** 4
    tail, head = ends_of(surface.triangles, half)
    row = places_in(cutout.triangles, len(surface.triangles))
    place = places_in(cutout.vertices, len(surface.vertices))
    # At a border a charge is outside already.
    place[surface.border] = -1
    return Turns(
        tail=row[here],
        head=row[there],
        turn=np.angle(cross[there] * carried.conj()),
        weight=np.ones(len(half)),
        left=place[head],
        right=place[tail],
        cost=np.linalg.norm(surface.vertices[head] - surface.vertices[tail], axis=1),
        directions=len(cutout.triangles),
        places=len(cutout.vertices),
    )
