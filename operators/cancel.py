"""Operator: stop the detection that is running."""

import bpy

from .base.translation import reported
from .jobs import worker


class UMBILICS_OT_cancel(bpy.types.Operator):
    bl_idname = "umbilics.cancel"
    bl_label = "Cancel Detection"
    bl_description = "Stop the detection that is running; the scene stays as it is"
    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if worker.current() is None:
            cls.poll_message_set(reported("No detection is running."))
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        task = worker.current()
        if task is not None:
            task.cancel()
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory((UMBILICS_OT_cancel,))
