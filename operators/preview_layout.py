"""Operator: the patches that quads would be laid out in, as curves, before any quad is made."""

import bpy

from .. import core
from .data import remeshing
from .jobs import retopology
from .jobs.adjustable import Adjustable
from .scene import selection
from .scene.retopology import curve_objects


class UMBILICS_OT_preview_layout(Adjustable, bpy.types.Operator):
    bl_idname = "umbilics.preview_layout"
    bl_label = "Preview Layout"
    bl_description = (
        "Draw the lines that divide the active mesh into the patches of the quads, as curves: from "
        "pole to pole, along creases and borders. Choose them for Guide Strokes, edit them, and "
        "the quads follow"
    )

    panel = "umbilics_remesh"
    adjusted = tuple(remeshing.settings_properties())

    def idle(self) -> frozenset[str]:
        return remeshing.idle(self)

    def job(self, context: bpy.types.Context) -> retopology.Job:
        settings = remeshing.to_remesh_settings(self)

        def work(
            job: retopology.Job, guide: core.Guide, progress: core.Progress
        ) -> core.QuadLayout:
            arrays = job.inputs.arrays
            return core.quad_layout(
                arrays.vertices,
                arrays.triangles,
                settings,
                progress,
                detection=guide.detection,
                sharp=arrays.sharp,
                zone=job.zone,
                strokes=job.steering.strokes,
                wanted=job.steering.wanted,
            )

        return retopology.gather(context, selection.shown(context), work, steered=True)

    def done(self, context: bpy.types.Context, job: retopology.Job, found: core.QuadLayout) -> str:
        with retopology.written(context, job) as (obj, transaction):
            curve_objects.write_layout(context, obj, job.inputs.arrays, found, transaction)
        return f"Patches: {found.rectangles}, poles: {len(found.pole_valence)}."

    def warnings(self, found: core.QuadLayout) -> tuple[str, ...]:
        return found.warnings


UMBILICS_OT_preview_layout.__annotations__ = remeshing.settings_properties()


register, unregister = bpy.utils.register_classes_factory((UMBILICS_OT_preview_layout,))
