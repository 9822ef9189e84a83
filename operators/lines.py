"""Operator: lines of curvature of the active mesh as curves."""

import bpy

from .data import plans
from .jobs import retopology
from .jobs.adjustable import AdjustableGuidance, with_settings
from .jobs.modal import GuidanceOperator
from .scene.retopology import guidance_objects


class UMBILICS_OT_lines(AdjustableGuidance, GuidanceOperator, bpy.types.Operator):
    bl_idname = "umbilics.lines"
    bl_label = "Lines of Curvature"
    bl_description = (
        "Draw evenly spaced lines of curvature on the active mesh, a curve object for each family"
    )

    def job(self, context):
        settings = self.settings(context)
        return retopology.gather(
            context, context.active_object, retopology.lines, settings=settings
        )

    def done(self, context, job, found):
        with retopology.written(context, job) as (obj, transaction):
            guidance_objects.write_lines(
                context, obj, job.inputs.arrays, found, guidance_objects.LINES, transaction
            )
        return f"{len(found)} lines of curvature."


with_settings(UMBILICS_OT_lines, plans.OF_LINES)


def register() -> None:
    bpy.utils.register_class(UMBILICS_OT_lines)


def unregister() -> None:
    bpy.utils.unregister_class(UMBILICS_OT_lines)
