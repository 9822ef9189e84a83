"""Operator: colour a mesh that was checked by the angle of its quads, and show it."""

import bpy

from .base.errors import AttributeNameError
from .base.translation import reported
from .scene.modes import object_mode
from .scene.transaction import all_or_nothing
from .scene.view import maps, view_shading


class UMBILICS_OT_show_check(bpy.types.Operator):
    bl_idname = "umbilics.show_check"
    bl_label = "Show Angles"
    bl_description = (
        "Colour the active mesh by the angle between its quads and the directions of curvature, "
        "and show colours in this view. Put Back takes all of it back"
    )
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        obj = context.active_object
        if obj is None or obj.type != "MESH" or not obj.umbilics_check.checked:
            cls.poll_message_set(reported("Check the topology of the active mesh first."))
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = context.active_object
        area = context.area
        try:
            with object_mode(context, obj), all_or_nothing() as transaction:
                shown = maps.write_check(obj, transaction)
                if shown and area is not None and area.type == "VIEW_3D":
                    view_shading.show_attributes(context.screen, area, transaction)
        except AttributeNameError as error:
            self.report({"ERROR"}, reported(str(error)))
            return {"CANCELLED"}
        if not shown:
            self.report(
                {"ERROR"},
                reported(
                    f"The angles are not on the mesh of {obj.name}: its modifiers make other "
                    "faces, or it was edited. Apply the modifiers and check again."
                ),
            )
            return {"CANCELLED"}
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory((UMBILICS_OT_show_check,))
