"""Operator: the separatrices of the umbilics of the active mesh as curves."""

import bpy

from . import guidance_results, guiding
from .guidance_operator import GuidanceOperator


class UMBILICS_OT_separatrices(GuidanceOperator, bpy.types.Operator):
    bl_idname = "umbilics.separatrices"
    bl_label = "Separatrices"
    bl_description = (
        "Draw the lines of curvature that run into the umbilics of the active mesh: the skeleton "
        "of a layout of quads"
    )

    def job(self, context):
        return guiding.gather(context, context.active_object, guiding.separatrices)

    def put(self, context, job, found):
        with guiding.written(context, job) as obj:
            guidance_results.write_lines(
                context, obj, job.inputs.arrays, found, guidance_results.SEPARATRICES
            )
        joined = int((found.target >= 0).sum())
        return f"{len(found)} separatrices, {joined} of them from umbilic to umbilic."


def register() -> None:
    bpy.utils.register_class(UMBILICS_OT_separatrices)


def unregister() -> None:
    bpy.utils.unregister_class(UMBILICS_OT_separatrices)
