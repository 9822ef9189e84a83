"""Shape operators on the cylinders and cones of tessellated parts: exact, along the axis."""

from __future__ import annotations

import numpy as np

from ..mesh.surface import Surface
from ..mesh.tessellated import Tessellation
from .field import CurvatureField


def on_faces(surface: Surface, field: CurvatureField, part: Tessellation) -> CurvatureField:
    """The field with the operators of a cylinder or cone at the vertices that lie on one.

    A vertex on several has those of the one that bends most; flat and spherical faces have no
    directions to give. The normal is that of the face, not the mean across a crease.

    Parameters
    ----------
    field:
        Shape operators at the n vertices of the surface, in its own coordinates.
    """
    directed = np.linalg.norm(part.axis, axis=1) > 0.5
    if not directed.any():
        return field
    n = len(surface.vertices)
    bend = np.where(directed, np.abs(part.mean_curvature), -1.0)
    # From the least bent face to the most: what is written last stays.
    face = np.full(n, -1)
    inside = np.flatnonzero(part.face >= 0)
    inside = inside[directed[part.face[inside]]]
    inside = inside[np.argsort(bend[part.face[inside]], kind="stable")]
    for corner in surface.triangles[inside].T:
        face[corner] = np.where(
            bend[part.face[inside]] >= np.where(face[corner] >= 0, bend[face[corner]], -1.0),
            part.face[inside],
            face[corner],
        )
    rows = np.flatnonzero(face >= 0)
    normals, areas = surface.face_normal_area
    total = np.zeros((n, 3))
    for corner in surface.triangles[inside].T:
        own = face[corner] == part.face[inside]
        weighted = normals[inside[own]] * areas[inside[own], None]
        for axis in range(3):
            total[:, axis] += np.bincount(corner[own], weighted[:, axis], minlength=n)
    normal = _unit(total[rows])
    along = part.axis[face[rows]]
    along = _unit(along - np.einsum("nc,nc->n", along, normal)[:, None] * normal)
    sound = (np.linalg.norm(normal, axis=1) > 0.5) & (np.linalg.norm(along, axis=1) > 0.5)
    rows, normal, along = rows[sound], normal[sound], along[sound]
    curvature = 2.0 * part.mean_curvature[face[rows]]
    across = np.cross(normal, along)
    # The axis is the direction of the larger curvature, zero, where the face is hollow.
    hollow = (curvature < 0)[:, None]
    first = np.where(hollow, along, across)
    values = {name: value.copy() for name, value in vars(field).items()}
    values["k1"][rows], values["k2"][rows] = np.maximum(curvature, 0), np.minimum(curvature, 0)
    values["d1"][rows], values["d2"][rows] = first, np.cross(normal, first)
    values["normal"][rows] = normal
    return CurvatureField(**values)


def _unit(vectors: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0)
