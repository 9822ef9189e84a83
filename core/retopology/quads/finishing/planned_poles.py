"""The poles that quads were laid out with: those of the crosses in the end, when close ones have
cancelled and whatever failed has given way."""

from __future__ import annotations

import numpy as np

from ....mesh.surface import Surface
from ....umbilics.result import Region
from ...poles import UNATTACHED, Poles, poles_at
from ..field.crosses import Crosses
from ..field.sectors import sector_turns
from ..layout.laying_out import LaidOut
from .mirroring import Plane
from .projection import ClosestPoints


def planned_poles(
    whole: Surface, regions: list[Region], laid: list[LaidOut], plane: Plane | None
) -> Poles:
    """The poles of pieces, and their images beyond a plane of symmetry, on the input surface.

    The valence is that of a pole inside; vertices of an open border have one more than edges, as in
    `TopologyCheck`. Which umbilics they come from is not told.
    """
    found = [_of_piece(one, plane) for one in laid]
    position = np.concatenate([np.zeros((0, 3)), *(place for place, _ in found)])
    valence = np.concatenate([np.zeros(0, np.int64), *(valence for _, valence in found)])
    return poles_near(whole, regions, position, valence)


def poles_near(
    whole: Surface, regions: list[Region], position: np.ndarray, valence: np.ndarray
) -> Poles:
    """Poles (k,) of these valences in the places of the surface nearest to (k, 3)."""
    closest = ClosestPoints(whole.vertices, whole.triangles, whole.twin)
    triangle, there = closest((position - whole.origin) / whole.unit)
    corner = whole.vertices[whole.triangles[triangle]]
    sides = np.swapaxes(corner[:, 1:] - corner[:, :1], 1, 2)
    # Triangles without an area have an inverse too.
    two = (np.linalg.pinv(sides) @ (there - corner[:, 0])[:, :, None])[:, :, 0]
    weights = np.column_stack([1.0 - two.sum(axis=1), two])
    count = len(valence)
    none, unsure = np.full(count, -1), np.full(count, UNATTACHED)
    still = np.zeros(count, bool)
    return poles_at(whole, regions, triangle, weights, 4 - valence, none, still, unsure)


def _of_piece(laid: LaidOut, plane: Plane | None) -> tuple[np.ndarray, np.ndarray]:
    """Places (k, 3) and valences (k,), with images where the piece has one."""
    crosses, surface = laid.map_.crosses, laid.working.surface
    quads = _quads_around(crosses)
    twice = plane is not None and not laid.wishes.single
    on_plane, border = np.zeros(len(quads), bool), crosses.border
    if twice:
        on_plane = laid.wishes.mirror & border
        # Its other border edges stay open where there are any.
        single = np.flatnonzero(crosses.twin < 0)
        ends = np.concatenate([crosses.tail[single], crosses.head[single]])
        open_edge = ~(on_plane[crosses.tail[single]] & on_plane[crosses.head[single]])
        border = np.zeros(len(quads), bool)
        border[ends[np.tile(open_edge, 2)]] = True
        quads = np.where(on_plane, 2 * quads, quads)
    valence = np.where(border, quads + 2, quads)
    rows = np.flatnonzero((valence != 4) & ~(border & (quads == 1)))
    place = surface.vertices[rows] * surface.unit + surface.origin
    valence = valence[rows]
    if twice and plane is not None:
        off = ~on_plane[rows]
        place = np.concatenate([place, plane.reflected(place[off])])
        valence = np.concatenate([valence, valence[off]])
    return place, valence


def _quads_around(crosses: Crosses) -> np.ndarray:
    """(n,) int64 how many quads meet at each vertex, on features and borders the sum of sectors."""
    first, turns = sector_turns(crosses)
    summed = np.bincount(crosses.tail[first], weights=turns, minlength=len(crosses.vertices))
    return np.where(crosses.on_feature, np.rint(summed).astype(np.int64), crosses.quarter_turns)
