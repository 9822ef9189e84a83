"""Operator: remove the results from the active mesh."""

import bpy

from .jobs import detect, worker
from .scene.modes import finished


class UMBILICS_OT_clear(bpy.types.Operator):
    bl_idname = "umbilics.clear"
    bl_label = "Clear Umbilics"
    bl_description = (
        "Remove the umbilics of the active mesh, and the poles, lines and marks made of them"
    )
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        reason = detect.why_not(context.active_object, to_clear=True)
        if worker.current() is not None:
            reason = "A detection is running. Wait for it, or press Esc."
        if reason:
            cls.poll_message_set(reason)
        return not reason

    def execute(self, context):
        if not detect.remove(context, context.active_object):
            self.report({"INFO"}, f"{context.active_object.name} has no umbilics to clear.")
            return {"CANCELLED"}
        return {"FINISHED"}

    def invoke(self, context, event):
        edited = context.mode == "EDIT_MESH"
        return finished(self.execute(context), edited)


def register() -> None:
    bpy.utils.register_class(UMBILICS_OT_clear)


def unregister() -> None:
    bpy.utils.unregister_class(UMBILICS_OT_clear)
