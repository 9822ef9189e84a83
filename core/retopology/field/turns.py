"""A field as the turns of its directions over the edges of a mesh, and the charges they enclose.

Angles are those of the field times its symmetry: a line field's angle is doubled, a cross
field's taken four times, so that a full turn is the least charge there is. Where the turns around
a place sum to 2 pi more, its charge is one more.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...fields.planes import FaceFrames, in_plane
from ...fields.winding import edge_turns
from ...mesh.surface import Surface

# Cotangent weights outside these bounds come from slivers; a weight near zero lets all the
# turning happen over one edge.
LEAST_WEIGHT, LARGEST_WEIGHT = 0.05, 10.0
# A charge goes rather where the directions mean little: beside the gap over its median, this.
LEAST_COST = 0.05


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


def turns_of_lines(
    surface: Surface, d1: np.ndarray, d2: np.ndarray, gap: np.ndarray
) -> Turns:
    """The turns of a line field at the vertices; its charges, twice the index, in triangles.

    Parameters
    ----------
    d1, d2, gap:
        (n, 3) unit directions, (n, 3) those at right angles and (n,) k1 - k2.
    """
    twin = surface.twin
    half = np.flatnonzero((twin < 0) | (np.arange(len(twin), dtype=twin.dtype) < twin))
    tail = surface.triangles.ravel()[half]
    head = surface.triangles[:, [1, 2, 0]].ravel()[half]
    left, right = half // 3, np.where(twin[half] >= 0, twin[half] // 3, -1)
    middle = surface.vertices[surface.triangles].mean(axis=1)
    # Out of the surface half of the way leads.
    beyond = np.where(right >= 0, right, left)
    ends = 0.5 * (surface.vertices[tail] + surface.vertices[head])
    way = np.linalg.norm(middle[left] - ends, axis=1)
    way += np.where(right >= 0, np.linalg.norm(middle[beyond] - ends, axis=1), 0.0)
    typical = max(float(np.median(gap)), np.finfo(float).tiny)
    cost = way * (0.5 * (gap[tail] + gap[head]) / typical + LEAST_COST)
    return Turns(
        tail=tail,
        head=head,
        turn=edge_turns(surface, d1, d2)[half],
        weight=_cotangents(surface, half),
        left=left,
        right=right,
        cost=cost,
        directions=len(surface.vertices),
        places=len(surface.triangles),
    )


def turns_of_faces(surface: Surface, planes: FaceFrames, direction: np.ndarray) -> Turns:
    """The turns of a cross field in the triangles, each the smallest one across its edge; its
    charges, four times the index, at vertices. Border edges enclose nothing.

    Parameters
    ----------
    direction:
        (m, 3) float64 one direction of the cross in each triangle.
    """
    twin = surface.twin
    half = np.flatnonzero(np.arange(len(twin), dtype=twin.dtype) < twin)
    cross = in_plane(surface, np.arange(len(surface.triangles)), direction) ** 4
    here, there = half // 3, twin[half] // 3
    carried = cross[here] * planes.turn[half] ** 4
    tail = surface.triangles.ravel()[half]
    head = surface.triangles[:, [1, 2, 0]].ravel()[half]
    # At a border a charge is outside already.
    inner = ~surface.border
    return Turns(
        tail=here,
        head=there,
        turn=np.angle(cross[there] * carried.conj()),
        weight=np.ones(len(half)),
        left=np.where(inner[head], head, -1),
        right=np.where(inner[tail], tail, -1),
        cost=np.linalg.norm(surface.vertices[head] - surface.vertices[tail], axis=1),
        directions=len(surface.triangles),
        places=len(surface.vertices),
    )


def _cotangents(surface: Surface, half: np.ndarray) -> np.ndarray:
    """(e,) half the sum of the cotangents across from each edge, within bounds."""
    squares = surface.side_squares
    area = np.maximum(surface.face_normal_area[1], np.finfo(float).tiny)
    # Across from a side the cotangent is that of the angle between the two others.
    across = (squares.sum(axis=0) - 2.0 * squares) / (4.0 * area)
    across = across.T.ravel()
    twin = surface.twin[half]
    both = 0.5 * (across[half] + np.where(twin >= 0, across[twin], 0.0))
    return np.clip(both, LEAST_WEIGHT, LARGEST_WEIGHT)
