"""Which objects can be analysed and keep results, and why others cannot, in words for the user."""

from __future__ import annotations

import bpy

from ..base.errors import ObjectError
from ..mesh.evaluated import is_in, outside
from ..scene import homes, targets

# Objects that Blender makes meshes of when it is asked to.
CONVERTIBLE = ("CURVE", "SURFACE", "FONT", "META", "CURVES", "POINTCLOUD", "GREASEPENCIL")
SCULPTED = "Leave Sculpt Mode first: the mesh is not up to date while it is sculpted."


def check_object(obj: bpy.types.Object | None, with_modifiers: bool = False) -> None:
    """Raise `ObjectError` if the object's mesh cannot be read and written."""
    reason = why_not(obj, with_modifiers=with_modifiers)
    if reason:
        raise ObjectError(reason)


def why_not(
    obj: bpy.types.Object | None, to_clear: bool = False, with_modifiers: bool = False
) -> str:
    """Why the object can have no results, in words for the user; empty if it can.

    With `to_clear`, why none can be removed from it: then faces are not needed. Results of the
    mesh `with_modifiers` can go to a mesh of ours.
    """
    if obj is None:
        return "There is no active object. Click a mesh first."
    if obj.type != "MESH":
        return _no_mesh(obj)
    # A local object with another file's mesh has its values on a mesh of ours, which can go.
    keeps = targets.is_local if to_clear else targets.is_own
    if not with_modifiers and not keeps(homes.owner_of(obj)):
        return (
            f"{obj.name} is linked from another file and cannot keep results here. Choose "
            "Source: As Seen, which puts them beside it, or make the object and its mesh "
            "local: Object > Relations > Make Local."
        )
    if with_modifiers and not is_in(bpy.context.view_layer, obj):
        return outside(obj)
    if obj.mode == "SCULPT":
        return SCULPTED
    # Modifiers may make faces of a mesh that has none.
    faces_needed = not (to_clear or with_modifiers)
    if faces_needed and obj.mode != "EDIT" and not obj.data.polygons:
        return f"{obj.name} has no faces: curvature needs a surface."
    return ""


def _no_mesh(obj: bpy.types.Object) -> str:
    """What to do with an object that is no mesh, in words."""
    way = "Choose a mesh."
    if obj.type == "ARMATURE":
        way = "Choose the mesh that the armature moves; its pose counts."
    elif obj.type == "EMPTY" and obj.instance_type == "COLLECTION":
        way = "Choose a mesh, or make the instance real: Object > Apply > Make Instances Real."
    elif obj.type in CONVERTIBLE:
        way = "Choose a mesh, or convert it: Object > Convert > Mesh."
    return f"{obj.name} is not a mesh. {way}"
