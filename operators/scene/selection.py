"""Which objects an operator works on."""

from __future__ import annotations

import bpy

from .display_objects import source_of


def wanted(context: bpy.types.Context) -> list[bpy.types.Object | None]:
    """The active object, then the other selected meshes; an object that displays
    results stands for its source.

    The first is None where there is no active object. With the active object not selected it is
    the only one, as for Blender's own operators that work on the active object.
    """
    active = context.view_layer.objects.active
    objects = [active]
    if active is not None and active.select_get():
        selected = context.view_layer.objects.selected
        objects += [obj for obj in selected if obj.type == "MESH"]
    return list(dict.fromkeys(map(source_of, objects)))
