"""Bring an umbilic, a pole or a mark of a check into view."""

from __future__ import annotations

import bpy
from mathutils import Vector

from ...data import record

# What is seen around the umbilic, in edges and as a fraction of the mesh, whichever is more.
_EDGES, _PART = 30.0, 0.15
# Below this cosine the surface is seen too much from the side, and the view turns to it.
_ASLANT = 0.3


def frame(context: bpy.types.Context, obj: bpy.types.Object, row: int) -> bool:
    """Move the 3D view to a candidate of an object; False without a 3D view or results."""
    kept = record.of(obj)
    if kept is None:
        return False
    position, normal = (Vector(vector) for vector in record.place_now(obj, kept, row))
    distance = max(_EDGES * float(kept.edge[row]), _PART * kept.extent)
    return _look_at(context, position, normal, distance)


def frame_pole(context: bpy.types.Context, empty: bpy.types.Object) -> bool:
    """Move the 3D view to a pole, whose z axis is the normal; False without a 3D view."""
    place = empty.matrix_world
    size = max(empty.parent.dimensions) if empty.parent is not None else 1.0
    normal = place.col[2].to_3d().normalized()
    return _look_at(context, place.translation.copy(), normal, _PART * size)


def frame_mark(context: bpy.types.Context, obj: bpy.types.Object, number: int) -> bool:
    """Move the 3D view to a mark of the object's check; False without a 3D view."""
    place = obj.umbilics_check.marks[number].place
    found, _, normal, _ = obj.closest_point_on_mesh(place)
    across = obj.matrix_world.to_3x3().inverted_safe().transposed() @ (
        normal if found else Vector((0.0, 0.0, 1.0))
    )
    distance = _PART * max(obj.dimensions)
    return _look_at(context, obj.matrix_world @ Vector(place), across.normalized(), distance)


def _look_at(context: bpy.types.Context, position: Vector, normal: Vector, distance: float) -> bool:
    view = _view(context)
    if view is None:
        return False
    view.view_location = position
    view.view_distance = distance
    if (view.view_rotation @ Vector((0.0, 0.0, 1.0))).dot(normal) < _ASLANT:
        view.view_rotation = normal.to_track_quat("Z", "Y")
    return True


def _view(context: bpy.types.Context) -> bpy.types.RegionView3D | None:
    """The view that the user works in, else the largest one of the window."""
    area = context.area
    if area is None or area.type != "VIEW_3D":
        areas = context.screen.areas if context.screen is not None else ()
        areas = [other for other in areas if other.type == "VIEW_3D"]
        area = max(areas, key=lambda other: other.width * other.height, default=None)
    return area.spaces.active.region_3d if area is not None else None
