"""The add-on in Blender's own menus, so that F3 finds all of it under "umbilic"."""

import bpy

from ..operators.add_arrows import UMBILICS_OT_add_arrows
from ..operators.add_pole import UMBILICS_OT_add_pole
from ..operators.align_to_other import UMBILICS_OT_align_to_other
from ..operators.align_to_x import UMBILICS_OT_align_to_x
from ..operators.apply_filters import UMBILICS_OT_apply_filters
from ..operators.check_topology import UMBILICS_OT_check_topology
from ..operators.clear import UMBILICS_OT_clear
from ..operators.clear_file import UMBILICS_OT_clear_file
from ..operators.compare import UMBILICS_OT_compare
from ..operators.copy_coordinates import UMBILICS_OT_copy_coordinates
from ..operators.delete_umbilic import UMBILICS_OT_delete_umbilic
from ..operators.detect import UMBILICS_OT_detect
from ..operators.draw_guides import UMBILICS_OT_draw_guides
from ..operators.export_field import UMBILICS_OT_export_field
from ..operators.frame_umbilic import UMBILICS_OT_frame_umbilic
from ..operators.guide import UMBILICS_OT_guide
from ..operators.hide_map import UMBILICS_OT_hide_map
from ..operators.lines import UMBILICS_OT_lines
from ..operators.mark_seams import UMBILICS_OT_mark_seams
from ..operators.new_retopology import UMBILICS_OT_new_retopology
from ..operators.pin import UMBILICS_OT_pin
from ..operators.preview_layout import UMBILICS_OT_preview_layout
from ..operators.remesh_to_quads import UMBILICS_OT_remesh_to_quads
from ..operators.restore_deleted import UMBILICS_OT_restore_deleted
from ..operators.ridges import UMBILICS_OT_ridges
from ..operators.rotation_symmetry import UMBILICS_OT_rotation_symmetry
from ..operators.separatrices import UMBILICS_OT_separatrices
from ..operators.show_check import UMBILICS_OT_show_check
from ..operators.show_map import UMBILICS_OT_show_map
from ..operators.symmetry import UMBILICS_OT_symmetry

# Between lines that part them, what is in the menus.
_DETECTION = (
    (
        UMBILICS_OT_detect,
        UMBILICS_OT_compare,
        UMBILICS_OT_apply_filters,
    ),
    (
        UMBILICS_OT_frame_umbilic,
        UMBILICS_OT_copy_coordinates,
        UMBILICS_OT_pin,
        UMBILICS_OT_delete_umbilic,
        UMBILICS_OT_restore_deleted,
    ),
    (UMBILICS_OT_show_map, UMBILICS_OT_hide_map, UMBILICS_OT_add_arrows),
    (UMBILICS_OT_clear, UMBILICS_OT_clear_file),
)
_RETOPOLOGY = (
    (
        UMBILICS_OT_guide,
        UMBILICS_OT_add_pole,
        UMBILICS_OT_preview_layout,
        UMBILICS_OT_remesh_to_quads,
    ),
    (
        UMBILICS_OT_lines,
        UMBILICS_OT_separatrices,
        UMBILICS_OT_ridges,
        UMBILICS_OT_draw_guides,
        UMBILICS_OT_mark_seams,
    ),
    (UMBILICS_OT_new_retopology, UMBILICS_OT_check_topology, UMBILICS_OT_show_check),
    (
        UMBILICS_OT_symmetry,
        UMBILICS_OT_align_to_x,
        UMBILICS_OT_rotation_symmetry,
        UMBILICS_OT_align_to_other,
    ),
    (UMBILICS_OT_export_field,),
)


class UMBILICS_MT_retopology(bpy.types.Menu):
    bl_label = "Retopology"

    def draw(self, context: bpy.types.Context) -> None:
        _fill(self.layout, _RETOPOLOGY)


class UMBILICS_MT_object(bpy.types.Menu):
    bl_label = "Umbilics"

    def draw(self, context: bpy.types.Context) -> None:
        _fill(self.layout, _DETECTION[:-1])
        self.layout.separator()
        self.layout.menu(UMBILICS_MT_retopology.__name__)
        self.layout.separator()
        _fill(self.layout, _DETECTION[-1:])


def _fill(
    layout: bpy.types.UILayout, groups: tuple[tuple[type[bpy.types.Operator], ...], ...]
) -> None:
    for number, group in enumerate(groups):
        if number:
            layout.separator()
        for operator in group:
            # From a menu a click is what a button is.
            layout.operator_context = "INVOKE_DEFAULT"
            if operator is UMBILICS_OT_add_pole:
                layout.operator_menu_enum(operator.bl_idname, "valence")
            elif operator is UMBILICS_OT_mark_seams:
                mark_menus(layout)
            else:
                layout.operator(operator.bl_idname)


def mark_menus(layout: bpy.types.UILayout) -> None:
    """What edges can be marked as, each with a menu of the lines."""
    for mark, text in (("SEAM", "Mark Seams"), ("SHARP", "Mark Sharp"), ("CREASE", "Crease")):
        name = UMBILICS_OT_mark_seams.bl_idname
        layout.operator_menu_enum(name, "lines", text=text).mark = mark


def draw_entry(menu: bpy.types.Menu, context: bpy.types.Context) -> None:
    """One line in Blender's Object and Mesh menus, and in those of a right click."""
    menu.layout.separator()
    menu.layout.menu(UMBILICS_MT_object.__name__)


_PLACES = (
    "VIEW3D_MT_object",
    "VIEW3D_MT_edit_mesh",
    "VIEW3D_MT_object_context_menu",
    "VIEW3D_MT_edit_mesh_context_menu",
)
_MENUS = (UMBILICS_MT_retopology, UMBILICS_MT_object)


def register() -> None:
    for menu in _MENUS:
        bpy.utils.register_class(menu)
    for place in _PLACES:
        getattr(bpy.types, place).append(draw_entry)


def unregister() -> None:
    for place in _PLACES:
        getattr(bpy.types, place).remove(draw_entry)
    for menu in reversed(_MENUS):
        bpy.utils.unregister_class(menu)
