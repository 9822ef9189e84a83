"""Operator: take one umbilic out of the results."""

import bpy

from .scene import chosen_umbilic


class UMBILICS_OT_delete_umbilic(bpy.types.Operator):
    bl_idname = "umbilics.delete_umbilic"
    bl_label = "Delete Umbilic"
    bl_description = "Take this umbilic out of the results; Restore Deleted brings it back"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return chosen_umbilic.can_be_changed(cls, context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        chosen_umbilic.toggle(context, "deleted")
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory((UMBILICS_OT_delete_umbilic,))
