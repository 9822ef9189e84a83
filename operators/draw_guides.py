"""Operator: lines of curvature and separatrices of the active mesh as strokes to draw over."""

import bpy

from .. import core
from .jobs import retopology, works
from .jobs.modal import GuidanceOperator
from .scene import selection
from .scene.retopology import curve_objects


class UMBILICS_OT_draw_guides(GuidanceOperator, bpy.types.Operator):
    bl_idname = "umbilics.draw_guides"
    bl_label = "Draw Guides"
    bl_description = (
        "Draw the lines of curvature, separatrices and ridges of the active mesh as Grease Pencil "
        "strokes, a layer for each family, to trace and draw over. Layers that you add stay"
    )

    def job(self, context: bpy.types.Context) -> retopology.Job:
        return retopology.gather(context, selection.shown(context), works.guides)

    def done(
        self,
        context: bpy.types.Context,
        job: retopology.Job,
        found: tuple[core.Lines, core.Lines, core.RidgeLines],
    ) -> str:
        lines, separatrices, ridges = found
        with retopology.written(context, job) as (obj, transaction):
            curve_objects.write_guides(
                context, obj, job.inputs.arrays, lines, separatrices, ridges, transaction
            )
        return (
            f"Strokes: {len(lines)} of lines of curvature, {len(separatrices)} of separatrices, "
            f"{len(ridges)} of ridges."
        )


register, unregister = bpy.utils.register_classes_factory((UMBILICS_OT_draw_guides,))
