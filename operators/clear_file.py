"""Operator: remove all results from the file, whatever scene they are in."""

import bpy

from .base.translation import reported
from .jobs import detect, refusals
from .jobs.modal import possible
from .scene import homes, orphans
from .scene.display_objects import source_of
from .scene.modes import finished, objects_mode
from .scene.transaction import all_or_nothing


class UMBILICS_OT_clear_file(bpy.types.Operator):
    bl_idname = "umbilics.clear_file"
    bl_label = "Clear Umbilics in File"
    bl_description = (
        "Remove the results of all objects in all scenes of this file, and what is left of "
        "deleted, joined and separated objects. Nothing of yours is removed"
    )
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return possible(cls)

    def execute(self, context: bpy.types.Context) -> set[str]:
        # An object of ours goes with the one that it shows the results of.
        ours = [*orphans.with_results(), *orphans.checked()]
        found = list(dict.fromkeys(map(source_of, ours)))
        refused = [why for obj in found if (why := refusals.why_not(obj, to_clear=True))]
        allowed = [obj for obj in found if not refusals.why_not(obj, to_clear=True)]
        with objects_mode(context, map(homes.owner_of, allowed)), all_or_nothing() as transaction:
            left = orphans.remove(transaction, but=allowed)
            cleared = [detect.remove(context, obj, transaction) for obj in allowed]
        for why in refused:
            self.report({"WARNING"}, reported(why))
        if not (any(cleared) or left):
            self.report({"INFO"}, reported("There is nothing of Umbilics in this file."))
            return {"CANCELLED"}
        count = sum(cleared)
        told = ["Cleared one object." if count == 1 else f"Cleared {count} objects."] * bool(count)
        told += ["What was left of other objects is removed."] * bool(left)
        self.report({"INFO"}, reported(" ".join(told)))
        return {"FINISHED"}

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        edited = context.mode == "EDIT_MESH"
        return finished(self.execute(context), edited)


register, unregister = bpy.utils.register_classes_factory((UMBILICS_OT_clear_file,))
