"""Scenes for the tests of the operators: an empty file and meshes in it."""

import bpy
import numpy as np
from mathutils import Matrix


def empty_scene() -> None:
    bpy.ops.wm.read_homefile(use_empty=True)


def add_mesh(vertices, faces, name="Thing", edges=()) -> bpy.types.Object:
    """An object made active, with a mesh of these vertices and faces."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(
        np.asarray(vertices, dtype=float).tolist(),
        list(edges),
        [list(map(int, face)) for face in faces],
    )
    return add_object(mesh, name)


def add_object(data, name="Thing") -> bpy.types.Object:
    obj = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(obj)
    for other in bpy.context.view_layer.objects:
        other.select_set(other == obj)
    bpy.context.view_layer.objects.active = obj
    bpy.context.view_layer.update()
    return obj


def add_ellipsoid(radii=(3.0, 2.0, 1.0), subdivisions=5, name="Ellipsoid") -> bpy.types.Object:
    """An icosphere whose vertices lie on an ellipsoid; it has four umbilics, all lemons."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=subdivisions, radius=1.0)
    obj = bpy.context.object
    obj.name = obj.data.name = name
    # Exactly on the sphere first: the primitive's vertices are rounded.
    points = np.array([vertex.co for vertex in obj.data.vertices])
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    obj.data.vertices.foreach_set("co", (points * radii).astype(np.float32).ravel())
    obj.data.update()
    bpy.context.view_layer.update()
    return obj


def ellipsoid_umbilics(radii=(3.0, 2.0, 1.0)) -> np.ndarray:
    """(4, 3) umbilics of the ellipsoid with radii a > b > c, sorted by sign of x, then z."""
    a, b, c = radii
    x = a * np.sqrt((a * a - b * b) / (a * a - c * c))
    z = c * np.sqrt((b * b - c * c) / (a * a - c * c))
    return np.array([(-x, 0, -z), (-x, 0, z), (x, 0, -z), (x, 0, z)])


def poles(obj) -> list[bpy.types.Object]:
    """The empties of an object's pole plan."""
    return [child for child in obj.children if "umbilics_valence" in child]


def empties(obj) -> list[bpy.types.Object]:
    return [child for child in obj.children if "umbilics_kind" in child]


def places(obj) -> np.ndarray:
    """(k, 3) world positions of the object's umbilics, sorted by sign of x, then of z."""
    bpy.context.view_layer.update()
    points = np.array([empty.matrix_world.translation for empty in empties(obj)])
    return points[np.lexsort((points[:, 2], np.sign(points[:, 0])))] if len(points) else points


def values(obj, name) -> np.ndarray:
    """An attribute of the object's mesh as an array; the mesh must not be in Edit Mode."""
    attribute = obj.data.attributes[name]
    key = "vector" if attribute.data_type == "FLOAT_VECTOR" else "value"
    width = 3 if key == "vector" else 1
    found = np.empty(len(attribute.data) * width)
    attribute.data.foreach_get(key, found)
    return found.reshape(-1, width) if width > 1 else found


def result_names(obj) -> list[str]:
    return [a.name for a in obj.data.attributes if a.name.startswith("umbilics_")]


def _custom_properties(obj) -> list[str]:
    """Names of the user's and our custom properties; Blender before 5.0 also lists those that
    add-ons define, as soon as one was read."""
    return sorted(key for key in obj.keys() if key not in obj.bl_rna.properties)  # noqa: SIM118


def census() -> dict:
    """What is in the file, to compare before and after."""
    return {
        "objects": sorted(obj.name for obj in bpy.data.objects),
        "collections": sorted(collection.name for collection in bpy.data.collections),
        "images": sorted(image.name for image in bpy.data.images),
        "meshes": {
            mesh.name: (sorted(a.name for a in mesh.attributes), len(mesh.vertices))
            for mesh in bpy.data.meshes
        },
        "properties": {obj.name: _custom_properties(obj) for obj in bpy.data.objects},
    }


def moved(x=0.0, y=0.0, z=0.0, scale=(1.0, 1.0, 1.0)) -> Matrix:
    return Matrix.LocRotScale((x, y, z), None, scale)


def parts(obj, part):
    return [child for child in obj.children if child.get("umbilics_guidance") == part]


def spline_points(curve):
    """World points of every spline of a curve object."""
    bpy.context.view_layer.update()
    matrix = np.array(curve.matrix_world)
    found = []
    for spline in curve.data.splines:
        co = np.empty(4 * len(spline.points), dtype=np.float32)
        spline.points.foreach_get("co", co)
        found.append(co.reshape(-1, 4)[:, :3] @ matrix[:3, :3].T + matrix[:3, 3])
    return found


def marked(obj, name):
    found = np.empty(len(obj.data.edges), dtype=bool)
    obj.data.edges.foreach_get(name, found)
    return found
