"""Operator: turn and move the active object so that its mirror plane is x = 0."""

import bpy
from mathutils import Matrix, Vector

from .base.translation import reported
from .scene import selection
from .scene.retopology import guidance_objects


class UMBILICS_OT_align_to_x(bpy.types.Operator):
    bl_idname = "umbilics.align_to_x"
    bl_label = "Align to X"
    bl_description = (
        "Turn and move the active object so that its mirror plane becomes the plane x = 0, as "
        "the Mirror modifier wants it; the mesh itself is not changed"
    )
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        obj = selection.active(context)
        if obj is None or not guidance_objects.parts_of(obj, guidance_objects.MIRROR):
            cls.poll_message_set(reported("Find the mirror plane first."))
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        context.view_layer.update()
        obj = selection.active(context)
        plane = guidance_objects.parts_of(obj, guidance_objects.MIRROR)[0].matrix_world
        normal = plane.col[1].to_3d().normalized()
        if normal.x < 0.0:
            normal = -normal
        turn = normal.rotation_difference(Vector((1.0, 0.0, 0.0))).to_matrix().to_4x4()
        middle = obj.matrix_world.translation.copy()
        turned = Matrix.Translation(middle) @ turn @ Matrix.Translation(-middle)
        place = turned @ plane.translation
        obj.matrix_world = Matrix.Translation((-place.x, 0.0, 0.0)) @ turned @ obj.matrix_world
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory((UMBILICS_OT_align_to_x,))
