"""Operator: the cross field and the pole plan of the active mesh."""

import math

import bpy

from .. import core
from .jobs import retopology
from .jobs.modal import GuidanceOperator
from .scene import selection
from .scene.retopology import guidance_objects


class UMBILICS_OT_guide(GuidanceOperator, bpy.types.Operator):
    bl_idname = "umbilics.guide"
    bl_label = "Plan Poles"
    bl_description = (
        "Smooth a cross field over the active mesh and put an empty wherever a quad mesh that "
        "follows it needs a vertex of three or five edges"
    )

    def job(self, context: bpy.types.Context) -> retopology.Job:
        return retopology.gather(context, selection.shown(context), retopology.plan)

    def done(
        self,
        context: bpy.types.Context,
        job: retopology.Job,
        found: tuple[core.Guidance, guidance_objects.Kept],
    ) -> str:
        guidance, kept = found
        with retopology.written(context, job) as (_, transaction):
            home = retopology.home_of_plan(context, job, transaction)
            origin = job.origin(kept.umbilics)
            guidance_objects.write_plan(
                context, home, job.inputs.arrays, guidance, kept, origin, transaction
            )
        context.scene.umbilics_display.field = "CROSS"
        poles = guidance.poles
        three = int((poles.valence == 3).sum())
        text = f"{three} poles of valence 3 and {len(poles) - three} of valence 5; "
        text += f"4 - valence sums to {poles.total}"
        if math.isfinite(poles.expected):
            return f"{text}, four times the Euler characteristic is {poles.expected:g}."
        return f"{text} on an open surface."


register, unregister = bpy.utils.register_classes_factory((UMBILICS_OT_guide,))
