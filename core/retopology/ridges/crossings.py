"""Where e, the derivative of a principal curvature along its own line, changes its sign."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...mesh.half_edges import ends_of
from ...mesh.surface import Surface
from .slopes import Slopes

FIRST, SECOND = 0, 1


@dataclass(frozen=True)
class Crossings:
    """Ridges of one family: s segments across triangles, between points on edges.

    Attributes
    ----------
    triangle:
        (s,) int64 triangle of the surface that each segment lies in.
    node:
        (s, 2) int64 half-edge, the first of its edge, at either end.
    along:
        (3 m,) float64 place of the point on each half-edge that is a node, 0 at its tail.
    """

    triangle: np.ndarray
    node: np.ndarray
    along: np.ndarray


@dataclass(frozen=True)
class EdgeSigns:
    """How directions go over each edge, decided once for both of its triangles.

    Attributes
    ----------
    name:
        (3 m,) int64 the first half-edge of each half-edge's edge.
    sign:
        (3 m,) float64 +1 where d at the head is d at the tail carried over, -1 where its
        opposite is; the same for both families.
    """

    name: np.ndarray
    sign: np.ndarray


def edge_signs(surface: Surface, slopes: Slopes) -> EdgeSigns:
    """The signs by which directions, and with them e, are compared across edges."""
    number = np.arange(len(surface.twin))
    name = np.where(surface.twin < 0, number, np.minimum(number, surface.twin))
    tail, head = ends_of(surface.triangles)
    # The real part of conj(m) . m' of the frames m = d1 + i d2: as the certified index turns.
    turn = np.zeros(len(number))
    for d in slopes.d:
        turn += np.einsum("ec,ec->e", d[tail], d[head])
    return EdgeSigns(name, np.where(turn >= 0, 1.0, -1.0)[name])


def crossings(surface: Surface, slopes: Slopes, signs: EdgeSigns, family: int) -> Crossings:
    """The zero lines of e in the triangles around which the directions turn consistently.

    In a triangle where they do not, at an umbilic, e has no sign; ridges end at its sides.
    """
    tail, head = ends_of(surface.triangles)
    e = slopes.e[family]
    here, there = e[tail], signs.sign * e[head]
    # Zero counts as positive at the tail of the first half-edge, for both triangles alike.
    crossed = ((here >= 0) != (there >= 0)) & slopes.determined[tail] & slopes.determined[head]
    crossed = crossed[signs.name]
    along = np.where(crossed, here / np.where(crossed, here - there, 1.0), 0.0)

    corners = signs.sign.reshape(-1, 3)
    sides = crossed.reshape(-1, 3)
    triangle = np.flatnonzero((corners.prod(axis=1) > 0) & (sides.sum(axis=1) == 2))
    # The two crossed sides come first in a stable order.
    side = np.argsort(~sides[triangle], axis=1, kind="stable")[:, :2]
    node = np.take_along_axis(signs.name.reshape(-1, 3)[triangle], side, axis=1)
    return Crossings(triangle, node, along)


def at_nodes(
    surface: Surface, node: np.ndarray, along: np.ndarray, values: np.ndarray
) -> np.ndarray:
    """Values (n, ...) at vertices, linearly interpolated at `node`s (r,) half-edges."""
    tail, head = ends_of(surface.triangles, node)
    t = along[node].reshape(-1, *[1] * (values.ndim - 1))
    return (1.0 - t) * values[tail] + t * values[head]
