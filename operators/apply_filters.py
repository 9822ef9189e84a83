"""Operator: filter results again that went through other filters."""

import bpy

from .base import changes
from .base.translation import reported
from .scene import filters


class UMBILICS_OT_apply_filters(bpy.types.Operator):
    bl_idname = "umbilics.apply_filters"
    bl_label = "Apply Filters to Umbilics"
    bl_description = (
        "Bring the results of the active and selected objects in line with the filters; nothing "
        "is computed again"
    )
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if not filters.with_results(context):
            cls.poll_message_set(reported("Detect umbilics first."))
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        filters.apply(context, filters.chosen_filters(context.scene))
        changes.notify("view", context)
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory((UMBILICS_OT_apply_filters,))
