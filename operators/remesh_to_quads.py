"""Operator: a quad mesh whose edges follow the curvature, beside the active mesh."""

import bpy
import numpy as np

from .. import core
from .data import remeshing
from .jobs import retopology
from .jobs.adjustable import Adjustable
from .jobs.modal import GuidanceOperator
from .scene import targets
from .scene.retopology import quad_meshes


class UMBILICS_OT_remesh_to_quads(Adjustable, GuidanceOperator, bpy.types.Operator):
    bl_idname = "umbilics.remesh_to_quads"
    bl_label = "Remesh to Quads"
    bl_description = (
        "Make a mesh of quads alone beside the active mesh: its edges follow the curvature, its "
        "irregular vertices are the planned poles"
    )

    panel = "umbilics_remesh"
    adjusted = tuple(remeshing.annotations())

    def job(self, context):
        settings = remeshing.to_remesh_settings(self)

        def work(job, guide, progress):
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

        return retopology.gather(context, context.active_object, work)

    def done(self, context, job, found):
        with retopology.written(context, job) as (_, transaction):
            source = targets.named(job.object_name)
            delivery = remeshing.to_delivery(self)
            quad_meshes.add(context, source, job.inputs.arrays, found, delivery, transaction)
        angle = found.angle[np.isfinite(found.angle)]
        follows = f", {np.mean(angle):.1f}\N{DEGREE SIGN} from the curvature" if len(angle) else ""
        return f"{len(found.quads)} quads, {len(found.pole_valence)} poles{follows}."

    def warnings(self, found):
        return found.warnings


UMBILICS_OT_remesh_to_quads.__annotations__ = remeshing.annotations()


def register() -> None:
    bpy.utils.register_class(UMBILICS_OT_remesh_to_quads)


def unregister() -> None:
    bpy.utils.unregister_class(UMBILICS_OT_remesh_to_quads)
