"""Operator: find the umbilics of the active mesh and of the other selected ones."""

import bpy
from bpy.props import BoolProperty

from .jobs import refusals
from .jobs.modal import DetectionOperator, possible, with_modifiers
from .scene import selection


class UMBILICS_OT_detect(DetectionOperator, bpy.types.Operator):
    bl_idname = "umbilics.detect"
    bl_label = "Detect Umbilics"
    bl_description = (
        "Find the umbilics of the active mesh and of the other selected ones: the points where "
        "the surface curves equally in all directions"
    )

    again: BoolProperty(
        name="Same Faces",
        description="Where the scope is what is selected or visible, take the faces of the last "
        "detection, whatever is selected or visible now",
        options={"HIDDEN", "SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return possible(cls, why_not(context))


def why_not(context: bpy.types.Context) -> str:
    """Why nothing can be detected, in words for the user; empty if something can."""
    modified = with_modifiers(context)
    wanted = selection.wanted(context)
    whys = [refusals.why_not(obj, with_modifiers=modified) for obj in wanted]
    return "" if "" in whys else whys[0]


register, unregister = bpy.utils.register_classes_factory((UMBILICS_OT_detect,))
