"""Operator: an empty mesh over the active one to build quads on by hand."""

import bpy

from .base.translation import reported
from .scene import selection, targets
from .scene.transaction import all_or_nothing


class UMBILICS_OT_new_retopology(bpy.types.Operator):
    bl_idname = "umbilics.new_retopology"
    bl_label = "New Retopology Mesh"
    bl_description = (
        "Add an empty mesh that sticks to the active one, with snapping to faces, and start "
        "building quads in Edit Mode with the guides in view"
    )
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        obj = selection.active(context)
        if obj is None or obj.type != "MESH" or obj.mode != "OBJECT":
            cls.poll_message_set(reported("Make the surface the active object, in Object Mode."))
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        surface = selection.active(context)
        with all_or_nothing() as transaction:
            transaction.keep_selection(context.view_layer)
            mesh = transaction.made(bpy.data.meshes.new(f"{surface.name} Retopology"))
            made = transaction.made(bpy.data.objects.new(mesh.name, mesh))
            own = [one for one in surface.users_collection if targets.is_local(one)]
            for collection in own or [context.scene.collection]:
                collection.objects.link(made)
            modifier = made.modifiers.new("Shrinkwrap", "SHRINKWRAP")
            modifier.target = surface
            modifier.show_on_cage = True
            made.show_in_front = True
            made.umbilics_check.surface = surface
            for other in list(context.selected_objects):
                other.select_set(False)
            made.select_set(True)
            context.view_layer.objects.active = made
            tools = context.scene.tool_settings
            transaction.keep(tools, "use_snap", "snap_elements")
            tools.use_snap = True
            tools.snap_elements = {"FACE"}
            bpy.ops.object.mode_set(mode="EDIT")
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory((UMBILICS_OT_new_retopology,))
