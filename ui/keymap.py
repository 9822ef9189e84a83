"""A click on a glyph in the view; it can be changed or turned off in Blender's preferences."""

import bpy

from ..operators.pick import UMBILICS_OT_pick

_items: list[tuple[bpy.types.KeyMap, bpy.types.KeyMapItem]] = []


def register() -> None:
    # Without a window there are no keys.
    keys = bpy.context.window_manager.keyconfigs.addon
    if keys is None:
        return
    keymap = keys.keymaps.new(name="Object Mode", space_type="EMPTY")
    # A click comes after its press, which has selected what lies there for Blender.
    item = keymap.keymap_items.new(UMBILICS_OT_pick.bl_idname, "LEFTMOUSE", "CLICK")
    _items.append((keymap, item))


def unregister() -> None:
    for keymap, item in _items:
        keymap.keymap_items.remove(item)
    _items.clear()
