"""Which objects an operator works on."""

from __future__ import annotations

from typing import Any

import bpy

from . import homes
from .display_objects import source_of


def active(context: bpy.types.Context) -> Any:
    """The object that is worked on: the active one, or the mesh behind one of ours; or None."""
    return source_of(context.view_layer.objects.active)


def shown(context: bpy.types.Context) -> Any:
    """The object whose results the panel shows: it keeps those of the `active` one; or None."""
    obj = active(context)
    return None if obj is None else homes.owner_of(obj)


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
