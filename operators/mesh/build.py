"""New meshes from arrays."""

from __future__ import annotations

import bpy
import numpy as np


def from_triangles(
    vertices: np.ndarray, triangles: np.ndarray, smooth: bool = False
) -> bpy.types.Mesh:
    """A new mesh of (n, 3) vertices and (m, 3) triangles."""
    mesh = bpy.data.meshes.new("umbilics")
    mesh.vertices.add(len(vertices))
    mesh.loops.add(3 * len(triangles))
    mesh.polygons.add(len(triangles))
    if len(triangles):
        positions = np.nan_to_num(vertices).astype(np.float32)
        mesh.attributes["position"].data.foreach_set("vector", positions.ravel())
        corners = np.ascontiguousarray(triangles, dtype=np.int32).ravel()
        mesh.loops.foreach_set("vertex_index", corners)
        starts = np.arange(0, len(corners), 3, dtype=np.int32)
        mesh.polygons.foreach_set("loop_start", starts)
        mesh.polygons.foreach_set("use_smooth", np.full(len(triangles), smooth))
    mesh.update(calc_edges=True)
    mesh.validate()
    return mesh
