"""Operator: keep an umbilic whatever the filters say, or no longer."""

import bpy

from .scene import chosen_umbilic


class UMBILICS_OT_pin(bpy.types.Operator):
    bl_idname = "umbilics.pin"
    bl_label = "Pin Umbilic"
    bl_description = "Keep this umbilic whatever the filters say; once more to let go of it"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return chosen_umbilic.can_be_changed(cls, context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        chosen_umbilic.toggle(context, "pinned")
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory((UMBILICS_OT_pin,))
