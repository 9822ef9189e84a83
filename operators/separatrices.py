"""Operator: the separatrices of the umbilics of the active mesh as curves."""

import bpy

from .. import core
from .data import plans
from .jobs import retopology, works
from .jobs.adjustable import AdjustableGuidance, with_settings
from .scene import selection
from .scene.retopology import curve_objects, guidance_objects


class UMBILICS_OT_separatrices(AdjustableGuidance, bpy.types.Operator):
    bl_idname = "umbilics.separatrices"
    bl_label = "Separatrices"
    bl_description = (
        "Draw the lines of curvature that run into the umbilics of the active mesh: the skeleton "
        "of a layout of quads"
    )

    def job(self, context: bpy.types.Context) -> retopology.Job:
        settings = self.settings(context)
        return retopology.gather(
            context, selection.shown(context), works.separatrices, settings=settings
        )

    def done(self, context: bpy.types.Context, job: retopology.Job, found: core.Lines) -> str:
        with retopology.written(context, job) as (obj, transaction):
            part = guidance_objects.SEPARATRICES
            curve_objects.write_lines(context, obj, job.inputs.arrays, found, part, transaction)
        joined = int((found.target >= 0).sum())
        return f"Separatrices: {len(found)}, from umbilic to umbilic: {joined}."


with_settings(UMBILICS_OT_separatrices, plans.OF_SEPARATRICES)


register, unregister = bpy.utils.register_classes_factory((UMBILICS_OT_separatrices,))
