"""Operator: bring back the umbilics that were deleted by hand."""

import bpy

from .base import changes
from .base.translation import reported
from .scene import filters, selection, targets


class UMBILICS_OT_restore_deleted(bpy.types.Operator):
    bl_idname = "umbilics.restore_deleted"
    bl_label = "Restore Deleted Umbilics"
    bl_description = "Bring back the umbilics of the active object that were deleted by hand"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        obj = selection.shown(context)
        if obj is None or not obj.umbilics.deleted or not targets.is_local(obj):
            cls.poll_message_set(reported("No umbilic was deleted."))
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = selection.shown(context)
        filters.put_rows(context, obj, "deleted", "")
        changes.notify("view", context)
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory((UMBILICS_OT_restore_deleted,))
