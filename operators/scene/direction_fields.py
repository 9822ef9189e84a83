"""Fields of directions that are kept with a mesh, to be drawn as strokes."""

from __future__ import annotations

import bpy
import numpy as np

from ..mesh.attributes import read_result
from ..mesh.fetch import unit_vectors
from ..mesh.read import positions, vertex_normals
from . import guidance_objects


def read_field(obj: bpy.types.Object) -> tuple[np.ndarray, ...] | None:
    """Places, d1, d2 (n, 3) and gap (n,) at the vertices; None where there is nothing to draw."""
    if obj.mode != "OBJECT":
        return None
    names = ("umbilics_d1", "umbilics_d2", "umbilics_gap")
    found = [read_result(obj.data, name) for name in names]
    if any(values is None for values in found):
        return None
    return positions(obj.data), *found


def read_cross(obj: bpy.types.Object) -> tuple[np.ndarray, ...] | None:
    """As `read_field`, of the smoothed cross field; the gap is 1, since it means the same
    everywhere."""
    if obj.mode != "OBJECT":
        return None
    name = "umbilics_cross"
    d1 = read_result(obj.data, name, guidance_objects.ATTRIBUTES)
    if d1 is None:
        return None
    # The arms are at right angles in the world, not in the space of a stretched object.
    matrix = np.array(obj.matrix_world)[:3, :3]
    back = np.linalg.inv(matrix)
    normal = unit_vectors(vertex_normals(obj.data) @ back)
    across = np.cross(normal, unit_vectors(d1 @ matrix.T))
    d2 = unit_vectors(across @ back.T).astype(np.float32)
    return positions(obj.data), d1, d2, np.ones(len(d1), np.float32)
