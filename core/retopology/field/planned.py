"""A cross field that has the planned poles, and no others, at its vertices and in its faces."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...base.progress import Progress
from ...fields.directions import DirectionField
from ...fields.face_index import face_field_singularities
from ...fields.planes import FaceFrames
from ...mesh.surface import Surface
from ..cross_field import CrossField
from ..features import Features
from .agreement import rotated, with_index
from .settling import settle
from .simplified import STIFF
from .turns import Patch, turns_in_triangles

# Rings around the singular vertices that differ, within which triangles turn.
NEARBY = 12


def with_poles(
    surface: Surface,
    planes: FaceFrames,
    cross: CrossField,
    features: Features,
    triangle: np.ndarray,
    sign: np.ndarray,
    progress: Progress,
) -> CrossField:
    """Turn a cross field so that its singularities are the poles.

    In the faces each pole is at a corner of its triangle, and triangles beside hard features keep
    to them. What the sum over the surface forbids stays as it is; so does what the curvature is
    sure of, as far as it can.

    Parameters
    ----------
    features:
        What the field runs along.
    triangle, sign:
        (k,) triangles of the poles and (k,) 4 - valence of each.
    """
    quarters = np.zeros(len(surface.triangles), np.int64)
    np.add.at(quarters, triangle, sign)
    lines = DirectionField(cross.direction, cross.normal, cross.strength, symmetry=4)
    part = progress.part("Moving poles", 0.0, 0.5)
    none = np.zeros(len(quarters))
    found = with_index(surface, lines, quarters / 4.0, none, STIFF * cross.confidence, part)
    part = progress.part("Moving poles", 0.5, 1.0)
    held = _beside(surface, features)
    faces, astray = _faces(surface, planes, cross, held, triangle, sign, part)
    return replace(
        cross,
        direction=found.field.direction,
        triangle_index=found.index,
        face_direction=faces,
        astray=astray,
    )


def _faces(
    surface: Surface,
    planes: FaceFrames,
    cross: CrossField,
    beside: np.ndarray,
    triangle: np.ndarray,
    sign: np.ndarray,
    progress: Progress,
) -> tuple[np.ndarray, int]:
    """(m, 3) directions in the triangles, with the poles for their singular vertices, and how many
    of these are others than the poles; directions `beside` (m,) bool features stay."""
    vertex, quarters = face_field_singularities(surface, planes, cross.face_direction)
    charge = np.zeros(len(surface.vertices), np.int64)
    charge[vertex] = quarters
    corner, value = _corners(surface, charge, triangle, sign)
    np.subtract.at(charge, corner, value)
    # Poles on a border, and those that must share a vertex.
    astray = len(triangle) - len(np.unique(corner))
    changing = np.flatnonzero(charge)
    if not len(changing):
        return cross.face_direction, astray
    angle = np.zeros(len(surface.triangles))
    for patch in (Patch.around(surface, changing, NEARBY), Patch.whole(surface)):
        turns = turns_in_triangles(surface, patch, planes, cross.face_direction)
        _, twin, inner = patch.sides(surface)
        held = np.any(((twin >= 0) & ~inner).reshape(-1, 3), axis=1) | beside[patch.triangles]
        sure = STIFF * cross.confidence[surface.triangles[patch.triangles]].mean(axis=1)
        none = np.zeros(len(patch.vertices))
        settled = settle(turns, charge[patch.vertices], none, held, sure, progress)
        angle[patch.triangles] = settled.angle / 4.0
        if not settled.left.any():
            break
    across = np.cross(surface.face_normal_area[0], cross.face_direction)
    astray += int(np.count_nonzero(settled.left))
    return rotated(cross.face_direction, across, angle), astray


def _beside(surface: Surface, features: Features) -> np.ndarray:
    """(m,) bool triangles with an edge on a hard feature."""
    twin = surface.twin[features.half_edge]
    found = np.zeros(len(surface.triangles), bool)
    found[np.concatenate([features.half_edge, twin[twin >= 0]]) // 3] = True
    return found


def _corners(
    surface: Surface, quarters: np.ndarray, triangle: np.ndarray, sign: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Vertices that stand for the poles, where the faces are singular already if they can be, and
    the signs of the poles; border vertices cannot."""
    vertex = np.full(len(triangle), -1)
    taken = surface.border.copy()
    corners = surface.triangles[triangle].T
    # First those that are singular already, then others; two poles at one vertex would be none.
    for wanted in (quarters, None):
        for corner in corners:
            fits = (vertex < 0) & ~taken[corner]
            if wanted is not None:
                fits &= wanted[corner] * sign > 0
            rows = np.flatnonzero(fits)
            _, first = np.unique(corner[rows], return_index=True)
            vertex[rows[first]] = corner[rows[first]]
            taken[corner[rows[first]]] = True
    for corner in corners:
        free = (vertex < 0) & ~surface.border[corner]
        vertex[free] = corner[free]
    known = vertex >= 0
    return vertex[known], sign[known]
