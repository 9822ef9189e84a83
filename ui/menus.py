"""The add-on in Blender's own menus, so that F3 finds all of it under "umbilic"."""

import bpy

from ..operators.apply_filters import UMBILICS_OT_apply_filters
from ..operators.clear import UMBILICS_OT_clear
from ..operators.clear_file import UMBILICS_OT_clear_file
from ..operators.compare import UMBILICS_OT_compare
from ..operators.detect import UMBILICS_OT_detect
from ..operators.frame_umbilic import UMBILICS_OT_frame_umbilic
from ..operators.hide_map import UMBILICS_OT_hide_map
from ..operators.restore_deleted import UMBILICS_OT_restore_deleted
from ..operators.show_map import UMBILICS_OT_show_map


class UMBILICS_MT_object(bpy.types.Menu):
    bl_label = "Umbilics"

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        layout.operator(UMBILICS_OT_detect.bl_idname)
        layout.operator(UMBILICS_OT_compare.bl_idname)
        layout.operator(UMBILICS_OT_apply_filters.bl_idname)
        layout.operator(UMBILICS_OT_restore_deleted.bl_idname)
        layout.operator(UMBILICS_OT_frame_umbilic.bl_idname)
        layout.separator()
        layout.operator(UMBILICS_OT_show_map.bl_idname)
        layout.operator(UMBILICS_OT_hide_map.bl_idname)
        layout.separator()
        layout.operator(UMBILICS_OT_clear.bl_idname)
        layout.operator(UMBILICS_OT_clear_file.bl_idname)


def draw_entry(menu: bpy.types.Menu, context: bpy.types.Context) -> None:
    """One line in Blender's Object and Mesh menus."""
    menu.layout.separator()
    menu.layout.menu(UMBILICS_MT_object.__name__)


_PLACES = ("VIEW3D_MT_object", "VIEW3D_MT_edit_mesh")


def register() -> None:
    bpy.utils.register_class(UMBILICS_MT_object)
    for place in _PLACES:
        getattr(bpy.types, place).append(draw_entry)


def unregister() -> None:
    for place in _PLACES:
        getattr(bpy.types, place).remove(draw_entry)
    bpy.utils.unregister_class(UMBILICS_MT_object)
