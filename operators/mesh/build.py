"""New meshes from arrays."""

from __future__ import annotations

import bpy
import numpy as np


def from_triangles(
    vertices: np.ndarray, triangles: np.ndarray, smooth: bool = False
) -> bpy.types.Mesh:
    """A new mesh of (n, 3) vertices and (m, 3) triangles."""
    corners = np.ascontiguousarray(triangles).ravel()
    return from_polygons(vertices, corners, np.full(len(triangles), 3), smooth)


def from_polygons(
    vertices: np.ndarray, corners: np.ndarray, sizes: np.ndarray, smooth: bool = False
) -> bpy.types.Mesh:
    """A new mesh of (n, 3) vertices and faces of (m,) `sizes`, whose corners follow each other
    in (c,) `corners`."""
    mesh = bpy.data.meshes.new("umbilics")
    mesh.vertices.add(len(vertices))
    mesh.loops.add(len(corners))
    mesh.polygons.add(len(sizes))
    if len(sizes):
        positions = np.nan_to_num(vertices).astype(np.float32)
        mesh.attributes["position"].data.foreach_set("vector", positions.ravel())
        mesh.loops.foreach_set("vertex_index", np.asarray(corners, dtype=np.int32))
        starts = np.cumsum(sizes) - sizes
        mesh.polygons.foreach_set("loop_start", starts.astype(np.int32))
        mesh.polygons.foreach_set("use_smooth", np.full(len(sizes), smooth))
    mesh.update(calc_edges=True)
    mesh.validate()
    return mesh
