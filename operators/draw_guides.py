"""Operator: lines of curvature and separatrices of the active mesh as strokes to draw over."""

import bpy

from .jobs import retopology
from .jobs.modal import GuidanceOperator
from .scene import selection
from .scene.retopology import guidance_objects


class UMBILICS_OT_draw_guides(GuidanceOperator, bpy.types.Operator):
    bl_idname = "umbilics.draw_guides"
    bl_label = "Draw Guides"
    bl_description = (
        "Draw the lines of curvature, separatrices and ridges of the active mesh as Grease Pencil "
        "strokes, a layer for each family, to trace and draw over. Layers that you add stay"
    )

    def job(self, context):
        return retopology.gather(context, selection.shown(context), retopology.guides)

    def done(self, context, job, found):
        with retopology.written(context, job) as (obj, transaction):
            guidance_objects.write_guides(
                context, obj, job.inputs.arrays, *found, transaction=transaction
            )
        lines, separatrices, ridges = found
        return (
            f"{len(lines)} lines of curvature, {len(separatrices)} separatrices and "
            f"{len(ridges)} ridges drawn."
        )


def register() -> None:
    bpy.utils.register_class(UMBILICS_OT_draw_guides)


def unregister() -> None:
    bpy.utils.unregister_class(UMBILICS_OT_draw_guides)
