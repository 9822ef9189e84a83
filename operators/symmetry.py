"""Operator: the mirror plane of the active mesh."""

import bpy

from .jobs import retopology
from .jobs.modal import GuidanceOperator
from .scene import selection
from .scene.retopology import guidance_objects


class UMBILICS_OT_symmetry(GuidanceOperator, bpy.types.Operator):
    bl_idname = "umbilics.symmetry"
    bl_label = "Find Mirror Plane"
    bl_description = (
        "Find the plane that mirrors the active mesh onto itself, from umbilics that are images "
        "of each other"
    )

    def job(self, context):
        return retopology.gather(context, selection.shown(context), retopology.mirror)

    def done(self, context, job, found):
        with retopology.written(context, job) as (obj, transaction):
            guidance_objects.write_mirror(context, obj, job.inputs.arrays, found, transaction)
        return (
            f"Mirror plane from {len(found.pairs)} matched umbilics; the image lies "
            f"{found.error:.3g} away from the shape."
        )


def register() -> None:
    bpy.utils.register_class(UMBILICS_OT_symmetry)


def unregister() -> None:
    bpy.utils.unregister_class(UMBILICS_OT_symmetry)
