"""Bring an umbilic into view."""

from __future__ import annotations

import bpy
from mathutils import Vector

from ...data import record

# What is seen around the umbilic, in edges and as a fraction of the mesh, whichever is more.
_EDGES, _PART = 30.0, 0.15
# Below this cosine the surface is seen too much from the side, and the view turns to it.
_ASLANT = 0.3


def frame(context: bpy.types.Context, row: int) -> bool:
    """Move the 3D view to a candidate of the active object; False without a 3D view or results."""
    view = _view(context)
    if view is None:
        return False
    obj = context.view_layer.objects.active
    kept = record.of(obj)
    if kept is None:
        return False
    position, normal = (Vector(vector) for vector in record.place_now(obj, kept, row))
    view.view_location = position
    view.view_distance = max(_EDGES * float(kept.edge[row]), _PART * kept.extent)
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
