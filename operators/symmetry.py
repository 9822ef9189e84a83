"""Operator: the mirror plane of the active mesh."""

import bpy

from .. import core
from .jobs import retopology, works
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

    def job(self, context: bpy.types.Context) -> retopology.Job:
        return retopology.gather(context, selection.shown(context), works.mirror)

    def done(self, context: bpy.types.Context, job: retopology.Job, found: core.MirrorPlane) -> str:
        with retopology.written(context, job) as (obj, transaction):
            guidance_objects.write_mirror(context, obj, job.inputs.arrays, found, transaction)
        return (
            f"Mirror plane from {len(found.pairs)} matched umbilics; the image lies "
            f"{found.error:.3g} away from the shape."
        )


register, unregister = bpy.utils.register_classes_factory((UMBILICS_OT_symmetry,))
