"""Operator: a pole of the user's own in the plan of the active mesh."""

from __future__ import annotations

import bpy
import numpy as np
from bpy.props import EnumProperty

from .base.translation import reported
from .scene import selection
from .scene.retopology import by_hand
from .scene.transaction import all_or_nothing


class UMBILICS_OT_add_pole(bpy.types.Operator):
    bl_idname = "umbilics.add_pole"
    bl_label = "Add Pole"
    bl_description = (
        "Add a pole to the plan, on the surface where it is nearest to the 3D cursor; move it to "
        "where it is wanted and plan again"
    )
    bl_options = {"REGISTER", "UNDO"}

    valence: EnumProperty(
        name="Valence",
        description="Edges that meet at the pole",
        items=[
            ("3", "Three Edges", "A pole where the surface bulges like a fingertip"),
            ("5", "Five Edges", "A pole where the surface is a saddle, as between fingers"),
        ],
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        obj = selection.shown(context)
        if obj is None or obj.type != "MESH" or not obj.umbilics_plan.planned:
            cls.poll_message_set(
                reported("Plan poles first, and make their mesh the active object.")
            )
            return False
        if obj.mode != "OBJECT":
            cls.poll_message_set(reported("Leave Edit Mode first: poles are objects of their own."))
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = selection.shown(context)
        context.view_layer.update()
        depsgraph = context.evaluated_depsgraph_get()
        cursor = obj.matrix_world.inverted_safe() @ context.scene.cursor.location
        found, place, normal, _ = obj.closest_point_on_mesh(cursor, depsgraph=depsgraph)
        if not found:
            self.report({"ERROR"}, reported(f"{obj.name} has no surface for a pole to stand on."))
            return {"CANCELLED"}
        across = obj.matrix_world.to_3x3().inverted_safe().transposed() @ normal
        with all_or_nothing() as transaction:
            pole = by_hand.add_pole(
                context,
                obj,
                np.array(obj.matrix_world @ place),
                np.array(across.normalized()),
                int(self.valence),
                transaction,
            )
            transaction.keep_selection(context.view_layer)
            for other in context.view_layer.objects:
                other.select_set(other == pole)
        self.report(
            {"INFO"}, reported(f"Pole of {self.valence} edges added. Move it, then plan again.")
        )
        return {"FINISHED"}


def register() -> None:
    bpy.utils.register_class(UMBILICS_OT_add_pole)


def unregister() -> None:
    bpy.utils.unregister_class(UMBILICS_OT_add_pole)
