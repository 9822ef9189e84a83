"""Operator: ridges and ravines of the active mesh as curves."""

import bpy

from .. import core
from .data import plans
from .jobs import retopology, works
from .jobs.adjustable import AdjustableGuidance, with_settings
from .scene import selection
from .scene.retopology import curve_objects, guidance_objects, marked_edges


class UMBILICS_OT_ridges(AdjustableGuidance, bpy.types.Operator):
    bl_idname = "umbilics.ridges"
    bl_label = "Ridges"
    bl_description = (
        "Draw the lines along which the active mesh bends most, convex edges and hollows, rounded "
        "or sharp: a curve object for each"
    )

    def job(self, context: bpy.types.Context) -> retopology.Job:
        return retopology.gather(
            context,
            selection.shown(context),
            works.ridges_on_edges,
            own_edges=True,
            settings=self.settings(context),
        )

    def done(
        self,
        context: bpy.types.Context,
        job: retopology.Job,
        found: tuple[core.RidgeLines, core.RidgeEdges | None],
    ) -> str:
        lines, edges = found
        with retopology.written(context, job) as (obj, transaction):
            part = guidance_objects.RIDGES
            curve_objects.write_lines(context, obj, job.inputs.arrays, lines, part, transaction)
            marked_edges.write_ridge_edges(obj, edges, transaction)
        if not len(lines):
            return "No ridges: the mesh bends nowhere far enough for a line."
        hollow = int((lines.family == 1).sum())
        return f"Ridges: {len(lines) - hollow}, ravines: {hollow}."


with_settings(UMBILICS_OT_ridges, plans.OF_RIDGES)


register, unregister = bpy.utils.register_classes_factory((UMBILICS_OT_ridges,))
