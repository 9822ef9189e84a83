"""Operator: lines of curvature of the active mesh as curves."""

import bpy

from .. import core
from .data import plans
from .jobs import retopology, works
from .jobs.adjustable import AdjustableGuidance, with_settings
from .scene import selection
from .scene.retopology import curve_objects, guidance_objects


class UMBILICS_OT_lines(AdjustableGuidance, bpy.types.Operator):
    bl_idname = "umbilics.lines"
    bl_label = "Lines of Curvature"
    bl_description = (
        "Draw evenly spaced lines of curvature on the active mesh, a curve object for each family"
    )

    def job(self, context: bpy.types.Context) -> retopology.Job:
        settings = self.settings(context)
        return retopology.gather(context, selection.shown(context), works.lines, settings=settings)

    def done(self, context: bpy.types.Context, job: retopology.Job, found: core.Lines) -> str:
        with retopology.written(context, job) as (obj, transaction):
            curve_objects.write_lines(
                context, obj, job.inputs.arrays, found, guidance_objects.LINES, transaction
            )
        return f"Lines of curvature: {len(found)}."


with_settings(UMBILICS_OT_lines, plans.OF_LINES)


register, unregister = bpy.utils.register_classes_factory((UMBILICS_OT_lines,))
