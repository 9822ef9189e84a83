"""Operator: remove the results from the active mesh and the other selected ones."""

import bpy

from .base.translation import reported
from .jobs import detect, refusals
from .jobs.modal import possible
from .scene import homes, orphans, selection
from .scene.modes import finished, objects_mode
from .scene.transaction import all_or_nothing


class UMBILICS_OT_clear(bpy.types.Operator):
    bl_idname = "umbilics.clear"
    bl_label = "Clear Umbilics"
    bl_description = (
        "Remove the umbilics of the active mesh and of the other selected ones, the poles, lines "
        "and marks made of them, and what is left of deleted objects"
    )
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        whys = [refusals.why_not(obj, to_clear=True) for obj in selection.wanted(context)]
        return possible(cls, "" if "" in whys else whys[0])

    def execute(self, context: bpy.types.Context) -> set[str]:
        wanted = selection.wanted(context)
        allowed = [obj for obj in wanted if not refusals.why_not(obj, to_clear=True)]
        with objects_mode(context, map(homes.owner_of, allowed)), all_or_nothing() as transaction:
            left = orphans.remove(transaction, but=allowed)
            cleared = [detect.remove(context, obj, transaction) for obj in allowed]
        if not (left or any(cleared)):
            name = wanted[0].name if len(wanted) == 1 and wanted[0] else "The selection"
            self.report({"INFO"}, reported(f"{name} has no umbilics to clear."))
            return {"CANCELLED"}
        return {"FINISHED"}

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        edited = context.mode == "EDIT_MESH"
        return finished(self.execute(context), edited)


register, unregister = bpy.utils.register_classes_factory((UMBILICS_OT_clear,))
