"""Operator: lines of curvature and separatrices of the active mesh as strokes to draw over."""

import bpy

from . import guidance_results, guiding
from .guidance_operator import GuidanceOperator


class UMBILICS_OT_draw_guides(GuidanceOperator, bpy.types.Operator):
    bl_idname = "umbilics.draw_guides"
    bl_label = "Draw Guides"
    bl_description = (
        "Draw the lines of curvature and the separatrices of the active mesh as Grease Pencil "
        "strokes, a layer for each family, to trace and draw over. Layers that you add stay"
    )

    def job(self, context):
        return guiding.gather(context, context.active_object, guiding.guides)

    def put(self, context, job, found):
        with guiding.written(context, job) as obj:
            guidance_results.write_guides(context, obj, job.inputs.arrays, *found)
        lines, separatrices = found
        return f"{len(lines)} lines of curvature and {len(separatrices)} separatrices drawn."


def register() -> None:
    bpy.utils.register_class(UMBILICS_OT_draw_guides)


def unregister() -> None:
    bpy.utils.unregister_class(UMBILICS_OT_draw_guides)
