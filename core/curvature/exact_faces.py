"""Shape operators on the faces of tessellated parts: exact, on cylinders along the axis."""

from __future__ import annotations

import numpy as np

from ..base.unit import unit
from ..mesh.surface import Surface
from ..mesh.tessellated import Tessellation
from .field import CurvatureField
from .from_normals import curvature_from_normals


def on_faces(surface: Surface, normals: np.ndarray, part: Tessellation) -> CurvatureField:
    """The operators of exact faces at the vertices that have no others, elsewhere and where a face
    gives no directions those of the normals.

    A vertex on several has those of the one that bends most, of cylinders and cones before flat
    and spherical faces, which have no directions to give. The normal on a cylinder or cone is
    its own, not the mean across a crease.

    Parameters
    ----------
    normals:
        (n, 3) unit normals at the vertices of the surface.
    """
    directed = np.linalg.norm(part.axis, axis=1) > 0.5
    n = len(surface.vertices)
    # From the least bent face to the most: what is written last stays.
    order = np.argsort(np.lexsort((np.abs(part.mean_curvature), directed)))
    face = np.full(n, -1)
    inside = np.flatnonzero(part.face >= 0)
    inside = inside[np.argsort(order[part.face[inside]], kind="stable")]
    face[surface.triangles[inside].ravel()] = np.repeat(part.face[inside], 3)
    face[~part.exact_vertices(surface)] = -1
    found = np.flatnonzero(face >= 0)
    rows = found[directed[face[found]]]
    facing, areas = surface.face_normal_area
    total = np.zeros((3, n))
    bent = inside[directed[part.face[inside]]]
    weighted = areas[bent] * facing.take(bent, axis=0).T
    for corner in surface.triangles[bent].T:
        own = face[corner] == part.face[bent]
        for along, added in zip(weighted, total, strict=True):
            added += np.bincount(corner, own * along, minlength=n)
    normal = unit(total[:, rows].T)
    along = part.axis[face[rows]]
    along = unit(along - np.einsum("nc,nc->n", along, normal)[:, None] * normal)
    sound = (np.linalg.norm(normal, axis=1) > 0.5) & (np.linalg.norm(along, axis=1) > 0.5)
    rows, normal, along = rows[sound], normal[sound], along[sound]
    others = np.ones(n, bool)
    others[rows] = False
    rest = curvature_from_normals(surface, normals, vertices=others)
    values = {name: value.copy() for name, value in vars(rest).items()}
    values["k1"][found] = values["k2"][found] = part.mean_curvature[face[found]]
    curvature = 2.0 * part.mean_curvature[face[rows]]
    across = np.cross(normal, along)
    # The axis is the direction of the larger curvature, zero, where the face is hollow.
    hollow = (curvature < 0)[:, None]
    first = np.where(hollow, along, across)
    values["k1"][rows], values["k2"][rows] = np.maximum(curvature, 0), np.minimum(curvature, 0)
    values["d1"][rows], values["d2"][rows] = first, np.cross(normal, first)
    values["normal"][rows] = normal
    return CurvatureField(**values)
