"""Reading an object's mesh into arrays in world space."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import bmesh
import bpy
import numpy as np

from ..base.errors import AttributeNameError, ChangedMeshError, ObjectError
from . import fingerprint
from .edge_marks import marked_edges
from .evaluated import evaluated_mesh, works_on
from .fetch import DOMAIN_LABEL, LAYOUT, fetch, unit_vectors
from .fingerprint import Fingerprint
from .scope import WHOLE, Scope, faces_in, in_vertex_group


@dataclass(frozen=True)
class MeshArrays:
    """A mesh in world space, as arrays.

    Attributes
    ----------
    vertices:
        (n, 3) float64 world positions.
    triangles:
        (m, 3) int32 corners of the faces in the scope, wound outward as seen in the world (an
        object mirrored by a negative scale has two corners exchanged).
    loop_triangle:
        (m,) int32 number of Blender's own loop triangle that each row is.
    polygon:
        (m,) int32 the mesh's face that each triangle is part of.
    polygon_count:
        Number of the mesh's faces, those outside the scope included.
    matrix:
        (4, 4) float64 from the object's space to the world.
    seams, sharp:
        (s, 2) int32 vertices of the edges marked as seams, and of those marked sharp.
    uv:
        (m, 3, 2) float64 active UV map at the triangles' corners, or None.
    given:
        Curvatures k1, k2 (n,) and world directions d1, d2 (n, 3), float64, or None.
    fingerprint:
        Of all that was read, as it was then.
    given_names:
        Names of the attributes behind `given`.
    scope:
        Which part of the object it is.
    """

    vertices: np.ndarray
    triangles: np.ndarray
    loop_triangle: np.ndarray
    polygon: np.ndarray
    polygon_count: int
    matrix: np.ndarray
    seams: np.ndarray
    sharp: np.ndarray
    uv: np.ndarray | None
    given: tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray] | None
    fingerprint: Fingerprint
    given_names: tuple[str, ...] = ()
    scope: Scope = WHOLE


def read_mesh(
    obj: bpy.types.Object,
    given_names: tuple[str, ...] | None = None,
    with_uv: bool = False,
    depsgraph: bpy.types.Depsgraph | None = None,
    scope: Scope = WHOLE,
) -> MeshArrays:
    """The object's mesh in world space; in Edit Mode as it is being edited.

    `given_names` names the vertex attributes of k1, k2, d1 and d2, if they are wanted. With a
    `depsgraph` it is the mesh that modifiers and shape keys make, and the object is not in Edit
    Mode. Faces outside the `scope` are left out, vertices never.

    Raises
    ------
    ObjectError
        The mesh has no faces, none in the scope, or the object's scale flattens it or is no number;
        or it cannot be evaluated.
    AttributeNameError
        A given attribute is missing or not of the right type, or there is no UV map.
    """
    matrix = _to_a_place(obj)
    with current_mesh(obj, depsgraph) as mesh:
        vertices = _to_world(positions(mesh), matrix)
        triangles, loops, polygon = _triangles(mesh)
        if not len(triangles):
            raise _no_faces(obj, depsgraph is not None)
        rows = np.arange(len(triangles), dtype=np.int32)
        wanted = faces_in(obj, mesh, scope)
        if wanted is not None:
            rows = rows[wanted[polygon]]
            triangles, loops, polygon = triangles[rows], loops[rows], polygon[rows]
        if np.linalg.det(matrix[:3, :3]) < 0.0:
            triangles, loops = (
                np.ascontiguousarray(corners[:, (0, 2, 1)]) for corners in (triangles, loops)
            )
        seams, sharp = marked_edges(mesh)
        uv = _active_uv(obj, mesh, loops) if with_uv else None
        given = _given(obj, mesh, matrix, given_names) if given_names else None
        read = fingerprint.of_mesh(mesh, matrix, with_uv, given_names or ())
        if wanted is not None:
            read = read.plus(fingerprint.SCOPE, wanted)
        return MeshArrays(
            vertices=vertices,
            triangles=triangles,
            loop_triangle=rows,
            polygon=polygon,
            polygon_count=len(mesh.polygons),
            matrix=matrix,
            seams=seams,
            sharp=sharp,
            uv=uv,
            given=given,
            fingerprint=read,
            given_names=tuple(given_names or ()),
            scope=scope,
        )


def _to_a_place(obj: bpy.types.Object) -> np.ndarray:
    """(4, 4) float64 from the object's space to the world, where a surface stays one."""
    matrix = np.array(obj.matrix_world, dtype=np.float64)
    if not np.isfinite(matrix).all():
        raise ObjectError(f"{obj.name} stands nowhere: its place, turn or scale is not a number.")
    if np.linalg.det(matrix[:3, :3]) == 0.0:
        raise ObjectError(f"{obj.name} has a scale of zero. Give it a size in all directions.")
    return matrix


def _no_faces(obj: bpy.types.Object, evaluated: bool) -> ObjectError:
    """What is said of a mesh without faces."""
    if evaluated and (len(obj.data.polygons) or works_on(obj)):
        return ObjectError(
            f"The modifiers of {obj.name} leave no faces, or nothing but instances. "
            "Realize the instances in its Geometry Nodes, or choose Source: Base Mesh."
        )
    return ObjectError(
        f"{obj.name} has no faces: curvature needs a surface. "
        "Fill it, or choose another object."
    )


def check_unchanged(
    obj: bpy.types.Object, arrays: MeshArrays, depsgraph: bpy.types.Depsgraph | None = None
) -> None:
    """Raise `ChangedMeshError` if something that was read of the object is no longer the same."""
    with current_mesh(obj, depsgraph) as mesh:
        now = fingerprint_of(obj, mesh, arrays.uv is not None, arrays.given_names, arrays.scope)
    parts = {*now.digests, fingerprint.SCALE}
    if arrays.scope.is_momentary:
        parts.discard(fingerprint.SCOPE)
    changed = arrays.fingerprint.changed(now, sorted(parts))
    if changed:
        what = " ".join(fingerprint.WORDS[part] for part in changed)
        raise ChangedMeshError(
            f"{obj.name} was changed meanwhile. {what} Try again."
        )


def fingerprint_of(
    obj: bpy.types.Object,
    mesh: bpy.types.Mesh,
    with_uv: bool,
    given_names: tuple[str, ...],
    scope: Scope,
    zone: str = "",
) -> Fingerprint:
    """Of what would be read of an object now, whose mesh is `mesh`; `zone` names a vertex group."""
    found = fingerprint.of_mesh(mesh, np.array(obj.matrix_world), with_uv, given_names)
    try:
        wanted = faces_in(obj, mesh, scope)
    except ObjectError:
        wanted = np.zeros(0, bool)
    if wanted is not None:
        found = found.plus(fingerprint.SCOPE, wanted)
    if zone:
        found = found.plus(fingerprint.ZONE, in_vertex_group(obj, mesh, zone))
    return found


@contextmanager
def current_mesh(
    obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph | None = None
) -> Iterator[bpy.types.Mesh]:
    """The object's mesh; in Edit Mode a temporary copy of the mesh being edited.

    With a `depsgraph` it is a temporary copy of what modifiers and shape keys make of it; then
    the object is not in Edit Mode, where Blender shows only some of them.
    """
    if depsgraph is not None:
        with evaluated_mesh(obj, depsgraph) as mesh:
            yield mesh
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


def positions(mesh: bpy.types.Mesh) -> np.ndarray:
    """(n, 3) float64 vertices in the object's space, of a mesh that is not in Edit Mode."""
    # Reading the attribute is some twenty times faster than reading vertices' "co".
    position = mesh.attributes.get("position")
    if position is None:
        return np.empty((0, 3))
    return fetch(position.data, "vector", 3, np.float32).astype(np.float64)


def polygons_in_world(
    obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph | None = None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(n, 3) places in the world, (c,) vertices of the faces one behind the other, and (f + 1,)
    where each begins, of a mesh as `current_mesh` has it."""
    with current_mesh(obj, depsgraph) as mesh:
        places = _to_world(positions(mesh), np.array(obj.matrix_world))
        corners = fetch(mesh.loops, "vertex_index", 1, np.int32)
        start = np.append(fetch(mesh.polygons, "loop_start", 1, np.int32), len(corners))
    return places, corners, start


def vertex_normals(mesh: bpy.types.Mesh) -> np.ndarray:
    """(n, 3) float32 unit normals of the vertices in the object's space."""
    return fetch(mesh.vertex_normals, "vector", 3, np.float32)


def edge_vertices(mesh: bpy.types.Mesh) -> np.ndarray:
    """(e, 2) int32 vertices of the mesh's edges."""
    return fetch(mesh.edges, "vertices", 2, np.int32)


def _to_world(positions: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    return positions @ matrix[:3, :3].T + matrix[:3, 3]


def _triangles(mesh: bpy.types.Mesh) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(m, 3) vertices and (m, 3) loops of Blender's loop triangles, (m,) their faces."""
    corner = mesh.attributes.get(".corner_vert")
    corners = fetch(corner.data, "value", 1, np.int32) if corner else np.empty(0, np.int32)
    count = len(mesh.polygons)
    if len(corners) == 3 * count:
        # Nothing but triangles, as large meshes mostly are: Blender's own are the faces.
        loops = np.arange(3 * count, dtype=np.int32).reshape(-1, 3)
        return corners.reshape(-1, 3), loops, np.arange(count, dtype=np.int32)
    mesh.calc_loop_triangles()
    loops = fetch(mesh.loop_triangles, "loops", 3, np.int32)
    polygon = fetch(mesh.loop_triangle_polygons, "value", 1, np.int32)
    return corners[loops], loops, polygon


def _active_uv(obj: bpy.types.Object, mesh: bpy.types.Mesh, loops: np.ndarray) -> np.ndarray:
    layer = mesh.uv_layers.active
    if layer is None:
        raise AttributeNameError(f"{obj.name} has no UV map. Unwrap it, or set Charts to seams.")
    return fetch(layer.uv, "vector", 2, np.float32).astype(np.float64)[loops]


def _given(
    obj: bpy.types.Object, mesh: bpy.types.Mesh, matrix: np.ndarray, names: tuple[str, ...]
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Curvatures as they are, directions turned from the object's space into the world."""
    kinds = ("FLOAT", "FLOAT", "FLOAT_VECTOR", "FLOAT_VECTOR")
    k1, k2, d1, d2 = (
        _vertex_attribute(obj, mesh, name, kind) for name, kind in zip(names, kinds, strict=True)
    )
    return k1, k2, unit_vectors(d1 @ matrix[:3, :3].T), unit_vectors(d2 @ matrix[:3, :3].T)


def _vertex_attribute(
    obj: bpy.types.Object, mesh: bpy.types.Mesh, name: str, kind: str
) -> np.ndarray:
    width, dtype, key, label = LAYOUT[kind]
    found = mesh.attributes.get(name) if name else None
    if found is None or (found.domain, found.data_type) != ("POINT", kind):
        met = "there is none of that name"
        if found is not None:
            domain = DOMAIN_LABEL.get(found.domain, found.domain)
            met = f"it is {found.data_type} on domain {domain}"
        raise AttributeNameError(
            f"Curvature from attributes needs the attribute '{name}' of {obj.name}, "
            f"type {label}, domain Vertex; {met}. Add it, or set Curvature to Jets."
        )
    return fetch(found.data, key, width, dtype).astype(np.float64)
