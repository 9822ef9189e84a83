"""Operator: the cross field and the pole plan of the active mesh."""

import math

import bpy
from bpy.props import BoolProperty

from .. import core
from .data import plans
from .jobs import retopology, works
from .jobs.adjustable import AdjustableGuidance, with_settings
from .scene import selection
from .scene.retopology import guidance_objects


class UMBILICS_OT_guide(AdjustableGuidance, bpy.types.Operator):
    bl_idname = "umbilics.guide"
    bl_label = "Plan Poles"
    bl_description = (
        "Smooth a cross field over the active mesh and put an empty wherever a quad mesh that "
        "follows it needs a vertex of three or five edges"
    )

    by_hand: BoolProperty(
        name="Poles by Hand",
        description="Poles that were moved, added or deleted by hand stay as they are, and the "
        "field is bent after them; otherwise all are planned anew",
        default=True,
        options={"SKIP_SAVE"},
    )

    def job(self, context: bpy.types.Context) -> retopology.Job:
        return retopology.gather(
            context,
            selection.shown(context),
            works.plan,
            settings=self.settings(context),
            steered=True,
            with_poles=self.by_hand,
        )

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
                context,
                home,
                job.inputs.arrays,
                guidance,
                kept,
                origin,
                transaction,
                by_hand=job.steering.wanted is not None,
            )
            transaction.keep(context.scene.umbilics_display, "field")
            context.scene.umbilics_display.field = "CROSS"
        poles = guidance.poles
        three = int((poles.valence == 3).sum())
        five = len(poles) - three
        planned = f"{three} poles of valence 3 and {five} of valence 5"
        if three == 1:
            planned = f"1 pole of valence 3 and {five} of valence 5"
        if not math.isfinite(poles.expected):
            return f"{planned}; 4 - valence sums to {poles.total} on an open surface."
        return (
            f"{planned}; 4 - valence sums to {poles.total}, four times the Euler characteristic "
            f"is {poles.expected:g}."
        )

    def warnings(self, found: tuple[core.Guidance, core.Umbilics]) -> tuple[str, ...]:
        return found[0].warnings


with_settings(UMBILICS_OT_guide, plans.OF_PLAN)


register, unregister = bpy.utils.register_classes_factory((UMBILICS_OT_guide,))
