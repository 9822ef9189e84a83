"""Operator: colour the mesh by a curvature and show it."""

import bpy

from .base.errors import AttributeNameError
from .base.translation import reported
from .jobs.modal import possible
from .jobs.refusals import SCULPTED
from .scene import filters
from .scene.modes import objects_mode
from .scene.transaction import all_or_nothing
from .scene.view import maps, view_shading


class UMBILICS_OT_show_map(bpy.types.Operator):
    bl_idname = "umbilics.show_map"
    bl_label = "Show Curvature Map"
    bl_description = (
        "Colour the active and selected meshes by the chosen map, and show colours in this view. "
        "Hide Map puts all of it back"
    )
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        reason = ""
        if not filters.with_results(context):
            reason = "Detect umbilics first: the map shows what the detection measured."
        elif any(obj.mode == "SCULPT" for obj in filters.with_results(context)):
            reason = SCULPTED
        return possible(cls, reason)

    def execute(self, context: bpy.types.Context) -> set[str]:
        objects = filters.with_results(context)
        area = context.area
        try:
            with objects_mode(context, objects), all_or_nothing() as transaction:
                shown = maps.write(context, objects, transaction)
                if shown and area is not None and area.type == "VIEW_3D":
                    view_shading.show_attributes(context.screen, area, transaction)
        except AttributeNameError as error:
            self.report({"ERROR"}, reported(str(error)))
            return {"CANCELLED"}
        if not shown:
            self.report(
                {"ERROR"}, reported("The results were removed from the mesh. Detect again.")
            )
            return {"CANCELLED"}
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory((UMBILICS_OT_show_map,))
