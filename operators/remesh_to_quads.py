"""Operator: a quad mesh whose edges follow the curvature, beside the active mesh."""

import bpy
import numpy as np

from .. import core
from .data import remeshing
from .jobs import retopology
from .jobs.adjustable import Adjustable
from .scene import selection, targets
from .scene.retopology import quad_meshes


class UMBILICS_OT_remesh_to_quads(Adjustable, bpy.types.Operator):
    bl_idname = "umbilics.remesh_to_quads"
    bl_label = "Remesh to Quads"
    bl_description = (
        "Make a mesh of quads alone beside the active mesh: its edges follow the curvature, its "
        "irregular vertices are the planned poles"
    )

    panel = "umbilics_remesh"
    adjusted = tuple(remeshing.properties())

    def job(self, context: bpy.types.Context) -> retopology.Job:
        settings = remeshing.to_remesh_settings(self)

        def work(job: retopology.Job, guide: core.Guide, progress: core.Progress) -> core.QuadMesh:
            arrays = job.inputs.arrays
            return core.remesh(
                arrays.vertices,
                arrays.triangles,
                settings,
                progress,
                detection=guide.detection,
                sharp=arrays.sharp,
                zone=job.zone,
            )

        return retopology.gather(context, selection.shown(context), work)

    def done(self, context: bpy.types.Context, job: retopology.Job, found: core.QuadMesh) -> str:
        with retopology.written(context, job) as (_, transaction):
            source = targets.named(job.object_name)
            delivery = remeshing.to_delivery(self)
            quad_meshes.add(context, source, job.inputs.arrays, found, delivery, transaction)
        angle = found.angle[np.isfinite(found.angle)]
        follows = f", {np.mean(angle):.1f}\N{DEGREE SIGN} from the curvature" if len(angle) else ""
        return f"{len(found.quads)} quads, {len(found.pole_valence)} poles{follows}."

    def warnings(self, found: core.QuadMesh) -> tuple[str, ...]:
        return found.warnings


UMBILICS_OT_remesh_to_quads.__annotations__ = remeshing.properties()


register, unregister = bpy.utils.register_classes_factory((UMBILICS_OT_remesh_to_quads,))
