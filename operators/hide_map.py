"""Operator: remove the map and put the view back as it was."""

import bpy

from .base.translation import reported
from .scene import targets
from .scene.modes import objects_mode
from .scene.transaction import all_or_nothing
from .scene.view import maps, view_shading


class UMBILICS_OT_hide_map(bpy.types.Operator):
    bl_idname = "umbilics.hide_map"
    bl_label = "Hide Curvature Map"
    bl_description = "Remove the colours of the map and shade the view exactly as it was before"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        area = context.area
        changed = (
            area is not None
            and area.type == "VIEW_3D"
            and view_shading.is_changed(context.screen, area)
        )
        if not changed and not any(map(maps.is_shown_on, context.scene.objects)):
            cls.poll_message_set(reported("No map is shown."))
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        # Named first: objects that show a map go meanwhile, and Blender does not expect that of
        # one who walks through them.
        shown = [obj for obj in context.scene.objects if maps.is_shown_on(obj)]
        shown = list(filter(targets.is_local, shown))
        with objects_mode(context, shown), all_or_nothing() as transaction:
            for obj in shown:
                maps.hide(context, obj, transaction)
            for screen, area in view_shading.areas():
                view_shading.put_back(screen, area, transaction)
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory((UMBILICS_OT_hide_map,))
