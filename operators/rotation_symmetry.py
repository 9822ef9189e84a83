"""Operator: the axis about which turns bring the active mesh onto itself."""

import bpy

from .. import core
from .jobs import retopology, works
from .jobs.modal import GuidanceOperator
from .scene import selection
from .scene.retopology import guidance_objects


class UMBILICS_OT_rotation_symmetry(GuidanceOperator, bpy.types.Operator):
    bl_idname = "umbilics.rotation_symmetry"
    bl_label = "Find Rotation Axis"
    bl_description = (
        "Find the axis about which turns bring the active mesh onto itself, and by what part of a "
        "whole turn, from umbilics that are images of each other"
    )

    def job(self, context: bpy.types.Context) -> retopology.Job:
        return retopology.gather(context, selection.shown(context), works.rotation)

    def done(
        self, context: bpy.types.Context, job: retopology.Job, found: core.RotationSymmetry
    ) -> str:
        with retopology.written(context, job) as (obj, transaction):
            guidance_objects.write_axis(context, obj, job.inputs.arrays, found, transaction)
        return (
            f"Rotation symmetry of order {found.order}: a turn by {360.0 / found.order:g}° leaves "
            f"the image {found.error:.3g} away from the shape."
        )


register, unregister = bpy.utils.register_classes_factory((UMBILICS_OT_rotation_symmetry,))
