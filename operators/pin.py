"""Operator: keep an umbilic whatever the filters say, or no longer."""

import bpy

from . import umbilic_actions


class UMBILICS_OT_pin(bpy.types.Operator):
    bl_idname = "umbilics.pin"
    bl_label = "Pin Umbilic"
    bl_description = "Keep this umbilic whatever the filters say; once more to let go of it"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return umbilic_actions.can_be_changed(cls, context)

    def execute(self, context):
        umbilic_actions.toggle(context, "pinned", umbilic_actions.chosen_row(context))
        return {"FINISHED"}


def register() -> None:
    bpy.utils.register_class(UMBILICS_OT_pin)


def unregister() -> None:
    bpy.utils.unregister_class(UMBILICS_OT_pin)
