"""Objects of ours that lie where an object of the user's lies and carry results that it cannot.

One is a child of the object that it belongs to and carries the custom property
`umbilics_display`: how it was when we made it. As long as it still is so, it is ours. A
duplicate has another name, one that was renamed, edited or put into another mode is no longer
as it was, and one that was unparented belongs to nothing: from then on it is the user's, and it
is neither replaced nor removed.
"""

from __future__ import annotations

from typing import Any, TypeGuard

import bpy

from ..data.belonging import OWNER_TAG, mesh_behind
from ..mesh.fingerprint import mesh_signature
from .empties import local_views
from .targets import is_local
from .transaction import Transaction

TAG = "umbilics_display"
_LIFT = "Umbilics Lift"
# A map lies this far above the surface that it hides, as a fraction of its extent.
_HEIGHT = 1e-3


def is_ours(obj: bpy.types.Object | None) -> TypeGuard[bpy.types.Object]:
    """Whether an object is one of these and as we made it."""
    if obj is None or obj.type != "MESH" or obj.get(TAG) is None or not is_local(obj):
        return False
    return obj.mode == "OBJECT" and obj[TAG].to_dict() == _state(obj)


def source_of(obj: bpy.types.Object | None) -> Any:
    """The object that one of ours stands for or belongs to; any other object itself."""
    obj = mesh_behind(obj)
    return obj.parent if is_ours(obj) and obj.parent is not None else obj


def display_of(source: bpy.types.Object) -> bpy.types.Object | None:
    """The object of ours that belongs to `source`, if there is one."""
    return next((child for child in source.children if is_ours(child)), None)


def place(
    context: bpy.types.Context,
    source: bpy.types.Object,
    mesh: bpy.types.Mesh,
    lifted: bool,
    transaction: Transaction,
) -> bpy.types.Object:
    """An object of ours with this mesh where `source` is, in place of an earlier one.

    `lifted`: just above the surface, to be seen instead of it, and not to be clicked.
    """
    display = display_of(source)
    if display is None:
        display = bpy.data.objects.new(f"Umbilics of {source.name}", mesh)
        transaction.made(display)
        for collection in _collections(context, source):
            collection.objects.link(display)
        display.parent = source
        display[OWNER_TAG] = source.name_full
        display.hide_render = True
        for view in local_views(context, source):
            display.local_view_set(view, True)
    else:
        was_lifted = _LIFT in display.modifiers
        transaction.keep_custom(display, (TAG,))
        transaction.on_failure(_dress, display, source, display.data, was_lifted)
    old = display.data
    _dress(display, source, mesh, lifted)
    if old != mesh and not old.users:
        transaction.discard([old])
    display[TAG] = _state(display)
    return display


def _dress(
    display: bpy.types.Object, source: bpy.types.Object, mesh: bpy.types.Mesh, lifted: bool
) -> None:
    display.data = mesh
    display.hide_select = lifted
    display.modifiers.clear()
    if lifted:
        lift = display.modifiers.new(_LIFT, "DISPLACE")
        lift.mid_level = 0.0
        lift.strength = _HEIGHT * max(source.dimensions) / _scale(source)


def remove(context: bpy.types.Context, display: bpy.types.Object, transaction: Transaction) -> None:
    """Have one of ours go, and its mesh where nothing else uses it."""
    source, mesh, objects = display.parent, display.data, context.view_layer.objects
    if objects.active == display and source is not None and source.name in objects:
        transaction.on_failure(setattr, objects, "active", display)
        transaction.on_failure(source.select_set, source.select_get())
        source.select_set(True)
        objects.active = source
    transaction.discard([display])
    if mesh.users == 1:
        transaction.discard([mesh])


def _state(obj: bpy.types.Object) -> dict[str, Any]:
    """What tells one that we made from one that the user has changed."""
    return {
        "name": obj.name,
        "surface": mesh_signature(obj.data),
        "materials": len(obj.data.materials),
        "modifiers": " ".join(modifier.name for modifier in obj.modifiers),
    }


def _scale(obj: bpy.types.Object) -> float:
    """The object's largest scale, by which lengths in its own space are smaller."""
    return max(map(abs, obj.matrix_world.to_scale())) or 1.0


def _collections(context: bpy.types.Context, obj: bpy.types.Object) -> list[bpy.types.Collection]:
    """The object's own, as far as they belong to this file, else the scene's."""
    return [one for one in obj.users_collection if is_local(one)] or [context.scene.collection]
