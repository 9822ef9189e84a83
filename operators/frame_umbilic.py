"""Operator: bring an umbilic into view."""

import bpy

from .scene import chosen_umbilic
from .scene.view import framing


class UMBILICS_OT_frame_umbilic(bpy.types.Operator):
    bl_idname = "umbilics.frame_umbilic"
    bl_label = "Frame Umbilic"
    bl_description = "Bring this umbilic into the middle of the view"
    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return chosen_umbilic.is_chosen(cls, context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj, _, row = chosen_umbilic.chosen(context)
        framing.frame(context, obj, row)
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory((UMBILICS_OT_frame_umbilic,))
