"""Operator: lines of curvature of the active mesh as curves."""

import bpy

from . import guidance_results, guiding
from .guidance_operator import GuidanceOperator


class UMBILICS_OT_lines(GuidanceOperator, bpy.types.Operator):
    bl_idname = "umbilics.lines"
    bl_label = "Lines of Curvature"
    bl_description = (
        "Draw evenly spaced lines of curvature on the active mesh, a curve object for each family"
    )

    def job(self, context):
        return guiding.gather(context, context.active_object, guiding.lines)

    def put(self, context, job, found):
        with guiding.written(context, job) as obj:
            guidance_results.write_lines(
                context, obj, job.inputs.arrays, found, guidance_results.LINES
            )
        return f"{len(found)} lines of curvature."


def register() -> None:
    bpy.utils.register_class(UMBILICS_OT_lines)


def unregister() -> None:
    bpy.utils.unregister_class(UMBILICS_OT_lines)
