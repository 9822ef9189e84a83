"""Operator: the umbilic or pole whose glyph is clicked becomes the active one of its list."""

import bpy

from .scene import choosing
from .scene.view import picking


class UMBILICS_OT_pick(bpy.types.Operator):
    bl_idname = "umbilics.pick"
    bl_label = "Pick Umbilic"
    bl_description = "Choose the umbilic or pole whose glyph is under the mouse"
    bl_options = {"INTERNAL", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        in_view = context.area is not None and context.area.type == "VIEW_3D"
        return in_view and context.mode == "OBJECT" and context.region_data is not None

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        found = picking.pick(context, (event.mouse_region_x, event.mouse_region_y))
        # Whatever else the click means goes on.
        if found is None:
            return {"PASS_THROUGH"}
        obj = found.obj
        for other in list(context.selected_objects):
            other.select_set(other == obj)
        context.view_layer.objects.active = obj
        if found.pole:
            choosing.choose_pole(context, obj, found.pole)
        else:
            choosing.choose(context, obj, found.row)
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory((UMBILICS_OT_pick,))
