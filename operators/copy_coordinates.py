"""Operator: copy where an umbilic is."""

import bpy

from .base.translation import reported
from .data import record
from .scene import chosen_umbilic


class UMBILICS_OT_copy_coordinates(bpy.types.Operator):
    bl_idname = "umbilics.copy_coordinates"
    bl_label = "Copy Umbilic Coordinates"
    bl_description = "Copy the world coordinates of this umbilic to the clipboard"
    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return chosen_umbilic.is_chosen(cls, context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        position, _ = record.place_now(*chosen_umbilic.chosen(context))
        text = ", ".join(f"{value:.6g}" for value in position)
        context.window_manager.clipboard = text
        self.report({"INFO"}, reported(f"Copied {text}"))
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory((UMBILICS_OT_copy_coordinates,))
