"""Operator: draw the principal directions of the active mesh with Geometry Nodes."""

import bpy

from .base.translation import reported
from .jobs import refusals
from .scene import homes, selection, targets
from .scene.transaction import all_or_nothing
from .scene.view.arrow_nodes import GROUP_TAG, arrow_group


class UMBILICS_OT_add_arrows(bpy.types.Operator):
    bl_idname = "umbilics.add_arrows"
    bl_label = "Add Arrows"
    bl_description = (
        "Draw arrows along the principal directions with a Geometry Nodes modifier, from the "
        "attributes that a detection left on the mesh"
    )
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        obj = selection.active(context)
        reason = refusals.why_not(obj)
        if not reason and not targets.is_own(obj):
            reason = (
                f"{obj.name} is linked from another file and can have no arrows here. Make it and "
                "its mesh local: Object > Relations > Make Local."
            )
        elif not reason and not obj.umbilics.detected:
            reason = f"{obj.name} has no results. Detect first."
        elif not reason and homes.mesh_of(obj) != obj.data:
            reason = (
                f"The directions are those of what modifiers make of {obj.name}, not of its own "
                "mesh. Apply the modifiers, or detect with Source: Base Mesh."
            )
        if reason:
            cls.poll_message_set(reported(reason))
        return not reason

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = selection.active(context)
        if any(modifier.type == "NODES" and is_ours(modifier) for modifier in obj.modifiers):
            self.report({"INFO"}, reported(f"{obj.name} has arrows already."))
            return {"CANCELLED"}
        with all_or_nothing() as transaction:
            # Made first: what fails leaves no modifier behind.
            group = arrow_group(transaction)
            obj.modifiers.new("Umbilics Arrows", "NODES").node_group = group
        return {"FINISHED"}


def is_ours(modifier: bpy.types.Modifier) -> bool:
    """Whether a Geometry Nodes modifier draws our arrows."""
    return modifier.node_group is not None and GROUP_TAG in modifier.node_group


register, unregister = bpy.utils.register_classes_factory((UMBILICS_OT_add_arrows,))
