"""New meshes from arrays."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import bpy
import numpy as np

from .fetch import fetch


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
    with _made("umbilics") as mesh:
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


def same_surface(mesh: bpy.types.Mesh, name: str) -> bpy.types.Mesh:
    """A new mesh of the vertices and faces of another, not in Edit Mode, and of nothing else."""
    with _made(name) as made:
        made.vertices.add(len(mesh.vertices))
        made.loops.add(len(mesh.loops))
        made.polygons.add(len(mesh.polygons))
        positions = fetch(mesh.attributes["position"].data, "vector", 3, np.float32)
        made.attributes["position"].data.foreach_set("vector", positions.ravel())
        for kind, key, dtype in (
            ("loops", "vertex_index", np.int32),
            ("polygons", "loop_start", np.int32),
            ("polygons", "use_smooth", bool),
        ):
            getattr(made, kind).foreach_set(key, fetch(getattr(mesh, kind), key, 1, dtype))
        made.update(calc_edges=True)
    return made


@contextmanager
def _made(name: str) -> Iterator[bpy.types.Mesh]:
    """A new mesh, which goes if filling it fails."""
    mesh = bpy.data.meshes.new(name)
    try:
        yield mesh
    except BaseException:
        bpy.data.meshes.remove(mesh)
        raise
