"""Fields of directions that are kept with a mesh, to be drawn as strokes."""

from __future__ import annotations

import bpy
import numpy as np

from ...data import record
from ...mesh.attributes import read_result
from ...mesh.fetch import fetch, unit_vectors
from ...mesh.read import positions, vertex_normals
from .. import homes
from ..retopology import guidance_objects


def read_field(obj: bpy.types.Object) -> tuple[np.ndarray, ...] | None:
    """Places, d1, d2 (n, 3) and gap (n,) at the vertices; None where there is nothing to draw.

    Within umbilical regions, where no direction means anything, the gap is 0.
    """
    mesh = _readable(obj, homes.DETECTION)
    if mesh is None:
        return None
    names = ("umbilics_d1", "umbilics_d2", "umbilics_gap")
    found = [values for name in names if (values := read_result(mesh, name)) is not None]
    if len(found) < len(names):
        return None
    d1, d2, gap = found
    gap = np.where(_undirected(obj, mesh), 0.0, gap).astype(np.float32)
    return positions(_as_seen(obj, mesh)), d1, d2, gap


def _undirected(obj: bpy.types.Object, mesh: bpy.types.Mesh) -> np.ndarray:
    """(n,) bool vertices of the mesh inside regions without directions."""
    kept, number = record.of(obj), read_result(mesh, "umbilics_region")
    inside = np.zeros(len(mesh.vertices), bool)
    if kept is None or number is None or not kept.detection.regions:
        return inside
    without = [not one.has_directions for one in kept.detection.regions]
    faces = np.append(False, without)[np.clip(number, 0, len(without))]
    corners = fetch(mesh.loops, "vertex_index", 1, np.int32)
    sizes = fetch(mesh.polygons, "loop_total", 1, np.int32)
    inside[corners[np.repeat(faces, sizes)]] = True
    # At the rim of a region there are directions beside it.
    inside[corners[np.repeat(~faces, sizes)]] = False
    return inside


def read_cross(obj: bpy.types.Object) -> tuple[np.ndarray, ...] | None:
    """As `read_field`, of the smoothed cross field; the gap is 1, since it means the same
    everywhere."""
    mesh = _readable(obj, homes.PLAN)
    if mesh is None:
        return None
    name = "umbilics_cross"
    d1 = read_result(mesh, name, guidance_objects.ATTRIBUTES)
    if d1 is None:
        return None
    # The arms are at right angles in the world, not in the space of a stretched object.
    matrix = np.array(obj.matrix_world)[:3, :3]
    back = np.linalg.inv(matrix)
    seen = _as_seen(obj, mesh)
    normal = unit_vectors(vertex_normals(seen) @ back)
    across = np.cross(normal, unit_vectors(d1 @ matrix.T))
    d2 = unit_vectors(across @ back.T).astype(np.float32)
    return positions(seen), d1, d2, np.ones(len(d1), np.float32)


def _readable(obj: bpy.types.Object, part: str) -> bpy.types.Mesh | None:
    """The mesh that holds the values, unless the object is being worked on."""
    return homes.mesh_of(obj, part) if obj.mode == "OBJECT" else None


def _as_seen(obj: bpy.types.Object, mesh: bpy.types.Mesh) -> bpy.types.Mesh:
    """The mesh whose places values of `mesh` belong to.

    On the object's own mesh there may be results of what modifiers and shape keys make of it,
    vertex by vertex.
    """
    if mesh != obj.data or obj.umbilics.source == "BASE":
        return mesh
    evaluated = obj.evaluated_get(bpy.context.view_layer.depsgraph).data
    return evaluated if len(evaluated.vertices) == len(mesh.vertices) else mesh
