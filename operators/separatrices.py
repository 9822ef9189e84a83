"""Operator: the separatrices of the umbilics of the active mesh as curves."""

import bpy

from .data import plans
from .jobs import retopology
from .jobs.adjustable import AdjustableGuidance, with_settings
from .jobs.modal import GuidanceOperator
from .scene.retopology import guidance_objects


class UMBILICS_OT_separatrices(AdjustableGuidance, GuidanceOperator, bpy.types.Operator):
    bl_idname = "umbilics.separatrices"
    bl_label = "Separatrices"
    bl_description = (
        "Draw the lines of curvature that run into the umbilics of the active mesh: the skeleton "
        "of a layout of quads"
    )

    def job(self, context):
        settings = self.settings(context)
        return retopology.gather(
            context, context.active_object, retopology.separatrices, settings=settings
        )

    def done(self, context, job, found):
        with retopology.written(context, job) as (obj, transaction):
            part = guidance_objects.SEPARATRICES
            guidance_objects.write_lines(context, obj, job.inputs.arrays, found, part, transaction)
        joined = int((found.target >= 0).sum())
        return f"{len(found)} separatrices, {joined} of them from umbilic to umbilic."


with_settings(UMBILICS_OT_separatrices, plans.OF_SEPARATRICES)


def register() -> None:
    bpy.utils.register_class(UMBILICS_OT_separatrices)


def unregister() -> None:
    bpy.utils.unregister_class(UMBILICS_OT_separatrices)
