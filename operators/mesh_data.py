"""The one boundary between NumPy arrays and Blender's mesh data."""

from __future__ import annotations

import zlib
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import bmesh
import bpy
import numpy as np

from .errors import AttributeNameError, ChangedMeshError, ObjectError

# Kind of attribute: values per element, their NumPy type, the name foreach_get reads, and
# what the user reads when it is the wrong one.
_LAYOUT = {
    "FLOAT": (1, np.float32, "value", "Float"),
    "FLOAT_VECTOR": (3, np.float32, "vector", "Vector"),
    "INT": (1, np.int32, "value", "Integer"),
}
_DOMAIN_LABEL = {
    "POINT": "Vertex",
    "EDGE": "Edge",
    "FACE": "Face",
    "CORNER": "Face Corner",
}

_LARGEST = float(np.finfo(np.float32).max)

# What a detection leaves on a mesh: name, domain and type.
RESULTS = {
    "umbilics_k1": ("POINT", "FLOAT"),
    "umbilics_k2": ("POINT", "FLOAT"),
    "umbilics_gap": ("POINT", "FLOAT"),
    "umbilics_d1": ("POINT", "FLOAT_VECTOR"),
    "umbilics_d2": ("POINT", "FLOAT_VECTOR"),
    "umbilics_surface_type": ("POINT", "INT"),
    "umbilics_conformal_scale": ("POINT", "FLOAT"),
    "umbilics_index": ("FACE", "FLOAT"),
    "umbilics_region": ("FACE", "INT"),
}


@dataclass(frozen=True)
class MeshArrays:
    """A mesh in world space, as arrays.

    Attributes
    ----------
    vertices:
        (n, 3) float64 world positions.
    triangles:
        (m, 3) int32 corners; row i is Blender's own loop triangle i, wound outward as seen in
        the world (an object mirrored by a negative scale has two corners exchanged).
    polygon:
        (m,) int32 the mesh's face that each triangle is part of.
    polygon_count:
        Number of the mesh's faces.
    matrix:
        (4, 4) float64 from the object's space to the world.
    seams, sharp:
        (s, 2) int32 vertices of the edges marked as seams, and of those marked sharp.
    uv:
        (m, 3, 2) float64 active UV map at the triangles' corners, or None.
    given:
        Curvatures k1, k2 (n,) and world directions d1, d2 (n, 3), float64, or None.
    signature:
        Of the mesh as it was read, see `signature`.
    """

    vertices: np.ndarray
    triangles: np.ndarray
    polygon: np.ndarray
    polygon_count: int
    matrix: np.ndarray
    seams: np.ndarray
    sharp: np.ndarray
    uv: np.ndarray | None
    given: tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray] | None
    signature: str = ""


def read(
    obj: bpy.types.Object,
    given_names: tuple[str, ...] | None = None,
    with_uv: bool = False,
    depsgraph: bpy.types.Depsgraph | None = None,
) -> MeshArrays:
    """The object's mesh in world space; in Edit Mode as it is being edited.

    `given_names` names the vertex attributes of k1, k2, d1 and d2, if they are wanted. With a
    `depsgraph` it is the mesh that modifiers and shape keys make.

    Raises
    ------
    ObjectError
        The mesh has no faces, or the object's scale flattens it.
    AttributeNameError
        A given attribute is missing or not of the right type, or there is no UV map.
    """
    matrix = np.array(obj.matrix_world, dtype=np.float64)
    determinant = np.linalg.det(matrix[:3, :3])
    if not np.isfinite(matrix).all() or determinant == 0.0:
        raise ObjectError(f"{obj.name} has a scale of zero. Give it a size in all directions.")
    with current_mesh(obj, depsgraph) as mesh:
        vertices = _to_world(positions(mesh), matrix)
        triangles, loops, polygon = _triangles(mesh)
        if not len(triangles):
            raise ObjectError(
                f"{obj.name} has no faces: curvature needs a surface. "
                "Fill it, or choose another object."
            )
        seams, sharp = _marked_edges(mesh)
        uv = _active_uv(obj, mesh, loops) if with_uv else None
        given = _given(obj, mesh, matrix, given_names) if given_names else None
        polygon_count = len(mesh.polygons)
        fingerprint = signature(mesh)
    if determinant < 0.0:
        triangles = np.ascontiguousarray(triangles[:, (0, 2, 1)])
        uv = None if uv is None else np.ascontiguousarray(uv[:, (0, 2, 1)])
    return MeshArrays(
        vertices, triangles, polygon, polygon_count, matrix, seams, sharp, uv, given, fingerprint
    )


def signature(mesh: bpy.types.Mesh) -> str:
    """Differs where vertices or faces differ, of a mesh that is not in Edit Mode.

    The part before the last dash is that of the places, the part behind that of the faces.
    """
    position = mesh.attributes.get("position")
    places = _fetch(position.data, "vector", 3, np.float32) if position else np.empty(0)
    # An attribute again: reading loops is much slower.
    corner = mesh.attributes.get(".corner_vert")
    corners = _fetch(corner.data, "value", 1, np.int32) if corner else np.empty(0, np.int32)
    faces = f"{len(mesh.vertices)}.{len(mesh.polygons)}.{zlib.crc32(corners):08x}"
    return f"{zlib.crc32(places):08x}-{faces}"


def check_result_names(
    obj: bpy.types.Object, layouts: dict[str, tuple[str, str]] = RESULTS
) -> None:
    """Raise `AttributeNameError` if a result's name is taken by something that is not ours."""
    mesh = obj.data
    for name, (domain, kind) in layouts.items():
        found = mesh.attributes.get(name)
        if found is not None and (found.domain, found.data_type) != (domain, kind):
            raise AttributeNameError(
                f"{mesh.name} has an attribute {name} that is not a result of Umbilics. "
                "Rename it in the mesh's properties, under Attributes."
            )
        if found is None and name in obj.vertex_groups:
            raise AttributeNameError(
                f"{obj.name} has a vertex group {name}. Rename it: the result needs the name."
            )


def check_unchanged(
    obj: bpy.types.Object, arrays: MeshArrays, depsgraph: bpy.types.Depsgraph | None = None
) -> None:
    """Raise `ChangedMeshError` if the object's mesh is no longer the one that was read."""
    with current_mesh(obj, depsgraph) as mesh:
        same = signature(mesh) == arrays.signature
    if not same:
        raise ChangedMeshError(f"{obj.name} was changed while it was being analysed. Detect again.")


def write_results(mesh: bpy.types.Mesh, arrays: MeshArrays, results: dict[str, np.ndarray]) -> None:
    """Store results as attributes, making or replacing ours; the mesh is not in Edit Mode.

    `results` holds arrays for names in RESULTS; of those it has not, an earlier one is removed.
    What is not finite is stored as 0, so that nothing downstream meets a NaN.
    """
    remove_results(mesh, RESULTS.keys() - results.keys())
    write_attributes(mesh, results, RESULTS)


def write_attributes(
    mesh: bpy.types.Mesh, results: dict[str, np.ndarray], layouts: dict[str, tuple[str, str]]
) -> None:
    """Store arrays under their names, with the domains and types of `layouts`; as above."""
    for name in results:
        domain, kind = layouts[name]
        _, dtype, key, _ = _LAYOUT[kind]
        attribute = mesh.attributes.get(name) or mesh.attributes.new(name, kind, domain)
        values = np.nan_to_num(results[name], nan=0.0, posinf=0.0, neginf=0.0)
        # Curvatures of a tiny mesh may be beyond single precision.
        values = np.clip(values, -_LARGEST, _LARGEST).astype(dtype)
        attribute.data.foreach_set(key, np.ascontiguousarray(values).ravel())
    mesh.update()


def remove_results(
    mesh: bpy.types.Mesh,
    names: Collection[str] = RESULTS.keys(),
    layouts: dict[str, tuple[str, str]] = RESULTS,
) -> int:
    """Remove our attributes from a mesh that is not in Edit Mode; says how many there were."""
    removed = 0
    for name in names:
        layout = layouts[name]
        found = mesh.attributes.get(name)
        if found is not None and (found.domain, found.data_type) == layout:
            mesh.attributes.remove(found)
            removed += 1
    return removed


def to_corners(mesh: bpy.types.Mesh, values: np.ndarray) -> np.ndarray:
    """Values of the faces (p,) at each of their corners."""
    return np.repeat(values, _fetch(mesh.polygons, "loop_total", 1, np.int32))


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


def read_result(
    mesh: bpy.types.Mesh, name: str, layouts: dict[str, tuple[str, str]] = RESULTS
) -> np.ndarray | None:
    """A result as an array (count,) or (count, 3), float32 or int32; None if it is not there.

    The mesh must not be in Edit Mode: then there is nothing to read.
    """
    found = mesh.attributes.get(name)
    if found is None or (found.domain, found.data_type) != layouts[name] or not len(found.data):
        return None
    width, dtype, key, _ = _LAYOUT[found.data_type]
    return _fetch(found.data, key, width, dtype)


@contextmanager
def current_mesh(
    obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph | None = None
) -> Iterator[bpy.types.Mesh]:
    """The object's mesh; in Edit Mode a temporary copy of the mesh being edited.

    With a `depsgraph` it is a temporary copy of what modifiers and shape keys make of it.
    """
    if depsgraph is not None:
        if obj.mode == "EDIT":
            obj.update_from_editmode()
        evaluated = obj.evaluated_get(depsgraph)
        try:
            yield evaluated.to_mesh()
        finally:
            evaluated.to_mesh_clear()
        return
    if obj.mode != "EDIT":
        yield obj.data
        return
    copy = bpy.data.meshes.new("umbilics reading")
    try:
        bmesh.from_edit_mesh(obj.data).to_mesh(copy)
        yield copy
    finally:
        bpy.data.meshes.remove(copy)


def _fetch(collection, key: str, width: int, dtype) -> np.ndarray:
    """All values of one property of a collection: (count,) or (count, width)."""
    values = np.empty(len(collection) * width, dtype=dtype)
    if len(values):
        collection.foreach_get(key, values)
    return values if width == 1 else values.reshape(-1, width)


def positions(mesh: bpy.types.Mesh) -> np.ndarray:
    """(n, 3) float64 vertices in the object's space, of a mesh that is not in Edit Mode."""
    # Reading the attribute is some twenty times faster than reading vertices' "co".
    position = mesh.attributes.get("position")
    if position is None:
        return np.empty((0, 3))
    return _fetch(position.data, "vector", 3, np.float32).astype(np.float64)


def vertex_normals(mesh: bpy.types.Mesh) -> np.ndarray:
    """(n, 3) float32 unit normals of the vertices in the object's space."""
    return _fetch(mesh.vertex_normals, "vector", 3, np.float32)


def _to_world(positions: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    return positions @ matrix[:3, :3].T + matrix[:3, 3]


def _triangles(mesh: bpy.types.Mesh) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(m, 3) vertices and (m, 3) loops of Blender's loop triangles, (m,) their faces."""
    corner = mesh.attributes.get(".corner_vert")
    corners = _fetch(corner.data, "value", 1, np.int32) if corner else np.empty(0, np.int32)
    count = len(mesh.polygons)
    if len(corners) == 3 * count:
        # Nothing but triangles, as large meshes mostly are: Blender's own are the faces.
        loops = np.arange(3 * count, dtype=np.int32).reshape(-1, 3)
        return corners.reshape(-1, 3), loops, np.arange(count, dtype=np.int32)
    mesh.calc_loop_triangles()
    loops = _fetch(mesh.loop_triangles, "loops", 3, np.int32)
    polygon = _fetch(mesh.loop_triangle_polygons, "value", 1, np.int32)
    return corners[loops], loops, polygon


def edge_vertices(mesh: bpy.types.Mesh) -> np.ndarray:
    """(e, 2) int32 vertices of the mesh's edges."""
    return _fetch(mesh.edges, "vertices", 2, np.int32)


def mark_edges(mesh: bpy.types.Mesh, chosen: np.ndarray, mark: str) -> np.ndarray:
    """Mark edges (e,) bool as "seam" or "edge_sharp"; (e,) bool those that were not before."""
    before = _fetch(mesh.edges, f"use_{mark}", 1, bool)
    mesh.edges.foreach_set(f"use_{mark}", before | chosen)
    return chosen & ~before


def unmark_edges(mesh: bpy.types.Mesh, chosen: np.ndarray, mark: str) -> None:
    """Take a mark from edges (e,) bool."""
    before = _fetch(mesh.edges, f"use_{mark}", 1, bool)
    mesh.edges.foreach_set(f"use_{mark}", before & ~chosen)


def in_vertex_group(obj: bpy.types.Object, name: str, count: int) -> np.ndarray | None:
    """(count,) bool vertices that weigh more than a half in a group; None without the group."""
    group = obj.vertex_groups.get(name) if name else None
    if group is None or len(obj.data.vertices) != count:
        return None
    weights = (
        any(one.group == group.index and one.weight > 0.5 for one in vertex.groups)
        for vertex in obj.data.vertices
    )
    return np.fromiter(weights, bool, count)


def _marked_edges(mesh: bpy.types.Mesh) -> tuple[np.ndarray, np.ndarray]:
    """(s, 2) vertices of the edges marked as seams, and of those marked sharp."""
    # Up to Blender 4 the seams' name began with a dot.
    return _edges_with(mesh, ("uv_seam", ".uv_seam")), _edges_with(mesh, ("sharp_edge",))


def _edges_with(mesh: bpy.types.Mesh, names: tuple[str, ...]) -> np.ndarray:
    """(s, 2) vertices of the edges at which the attribute is true that has one of these names."""
    found = next((mesh.attributes[name] for name in names if name in mesh.attributes), None)
    if found is None:
        return np.empty((0, 2), dtype=np.int32)
    edges = np.flatnonzero(_fetch(found.data, "value", 1, bool))
    if not len(edges):
        return np.empty((0, 2), dtype=np.int32)
    return _fetch(mesh.edges, "vertices", 2, np.int32)[edges]


def _active_uv(obj: bpy.types.Object, mesh: bpy.types.Mesh, loops: np.ndarray) -> np.ndarray:
    layer = mesh.uv_layers.active
    if layer is None:
        raise AttributeNameError(f"{obj.name} has no UV map. Unwrap it, or set Charts to seams.")
    return _fetch(layer.uv, "vector", 2, np.float32).astype(np.float64)[loops]


def _given(
    obj: bpy.types.Object, mesh: bpy.types.Mesh, matrix: np.ndarray, names: tuple[str, ...]
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Curvatures as they are, directions turned from the object's space into the world."""
    kinds = ("FLOAT", "FLOAT", "FLOAT_VECTOR", "FLOAT_VECTOR")
    k1, k2, d1, d2 = (
        _vertex_attribute(obj, mesh, name, kind) for name, kind in zip(names, kinds, strict=True)
    )
    return k1, k2, unit(d1 @ matrix[:3, :3].T), unit(d2 @ matrix[:3, :3].T)


def _vertex_attribute(
    obj: bpy.types.Object, mesh: bpy.types.Mesh, name: str, kind: str
) -> np.ndarray:
    width, dtype, key, label = _LAYOUT[kind]
    found = mesh.attributes.get(name) if name else None
    if found is None or (found.domain, found.data_type) != ("POINT", kind):
        met = "there is none of that name"
        if found is not None:
            domain = _DOMAIN_LABEL.get(found.domain, found.domain)
            met = f"it is {found.data_type} on domain {domain}"
        raise AttributeNameError(
            f"Curvature from attributes needs the attribute '{name}' of {obj.name}, "
            f"type {label}, domain Vertex; {met}. Add it, or set Curvature to Jets."
        )
    return _fetch(found.data, key, width, dtype).astype(np.float64)


def unit(vectors: np.ndarray) -> np.ndarray:
    """(n, 3) vectors made one long; zero vectors stay zero."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return vectors / np.where(length > 0.0, length, 1.0)
