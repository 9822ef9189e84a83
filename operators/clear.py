"""Operator: remove the results from the active mesh."""

import bpy

from . import engine


class UMBILICS_OT_clear(bpy.types.Operator):
    bl_idname = "umbilics.clear"
    bl_label = "Clear Umbilics"
    bl_description = "Remove the umbilics of the active mesh: empties, collection and attributes"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        reason = engine.why_not(context.active_object, to_clear=True)
        if reason:
            cls.poll_message_set(reason)
        return not reason

    def execute(self, context):
        if not engine.remove(context, context.active_object):
            self.report({"INFO"}, f"{context.active_object.name} has no umbilics to clear.")
            return {"CANCELLED"}
        return {"FINISHED"}


def register() -> None:
    bpy.utils.register_class(UMBILICS_OT_clear)


def unregister() -> None:
    bpy.utils.unregister_class(UMBILICS_OT_clear)
