"""Singular vertices of a cross field that is given in the triangles."""

from __future__ import annotations

import numpy as np

from ..base.plane import corner_angles
from ..mesh.half_edges import inner_edges, previous
from ..mesh.surface import Surface
from .planes import FaceFrames, in_plane


def face_field_singularities(
    surface: Surface, planes: FaceFrames, direction: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Where a field of one cross to a triangle is singular.

    Crosses of neighbouring triangles are matched by the smallest turn across their edge. The
    index of an inner vertex is the sum of the turns around it and its angle defect, over a full
    turn; over a closed surface these sum to the Euler characteristic exactly.

    Parameters
    ----------
    direction:
        (m, 3) float64 one direction of the cross in each triangle.

    Returns
    -------
    vertex, quarters:
        (s,) int64 singular vertices of the surface, (s,) int64 four times their index.
    """
    n = len(surface.vertices)
    twin = surface.twin
    cross = in_plane(surface, np.arange(len(surface.triangles)), direction) ** 4
    inner = np.flatnonzero(twin >= 0)
    lower = inner_edges(twin)
    carried = cross[inner // 3] * planes.turn[inner] ** 4
    turn = np.zeros(len(twin))
    turn[inner] = np.angle(cross[twin[inner] // 3] * carried.conj()) / 4.0
    # Exactly opposite for both sides of an edge, also where the turn is half a right angle.
    turn[twin[lower]] = -turn[lower]
    corner = np.arange(len(twin))
    vertex = surface.triangles.ravel()
    angle = corner_angles(planes.corner)
    # Anticlockwise around a vertex one leaves a triangle by the side that comes back to it.
    around = np.bincount(vertex, weights=turn[previous(corner)] - angle, minlength=n)
    index = (around + 2.0 * np.pi) / (2.0 * np.pi)
    quarters = np.rint(4.0 * index).astype(np.int64)
    quarters[surface.border] = 0
    found = np.flatnonzero(quarters)
    return found, quarters[found]
