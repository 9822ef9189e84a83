"""Operator: a quad mesh whose edges follow the curvature, beside the active mesh."""

from __future__ import annotations

from dataclasses import dataclass

import bpy

from .. import core
from .data import remeshing, topology
from .jobs import retopology
from .jobs.adjustable import Adjustable
from .scene import selection, targets
from .scene.retopology import checks, quad_meshes


@dataclass(frozen=True)
class Made:
    """The quads, how they follow the surface and the poles that they were laid out with, and the
    umbilics that were kept."""

    quads: core.QuadMesh
    check: core.TopologyCheck
    umbilics: core.Umbilics


class UMBILICS_OT_remesh_to_quads(Adjustable, bpy.types.Operator):
    bl_idname = "umbilics.remesh_to_quads"
    bl_label = "Remesh to Quads"
    bl_description = (
        "Make a mesh of quads alone beside the active mesh: its edges follow the curvature, its "
        "irregular vertices are the planned poles"
    )

    panel = "umbilics_remesh"
    adjusted = tuple(remeshing.properties())

    def idle(self) -> frozenset[str]:
        return remeshing.idle(self)

    def job(self, context: bpy.types.Context) -> retopology.Job:
        settings = remeshing.to_remesh_settings(self)

        def work(job: retopology.Job, guide: core.Guide, progress: core.Progress) -> Made:
            arrays = job.inputs.arrays
            quads = core.remesh(
                arrays.vertices,
                arrays.triangles,
                settings,
                progress.part("Remeshing", 0.0, 0.9),
                detection=guide.detection,
                sharp=arrays.sharp,
                zone=job.zone,
                strokes=job.steering.strokes,
                wanted=job.steering.wanted,
            )
            check = core.check_quads(quads, guide, progress.part("Checking", 0.9, 1.0))
            return Made(quads, check, guide.detection.umbilics)

        return retopology.gather(context, selection.shown(context), work, steered=True)

    def done(self, context: bpy.types.Context, job: retopology.Job, found: Made) -> str:
        quads = found.quads
        source = targets.named(job.object_name)
        # For writing it leaves its mode.
        is_idle = source is not None and source.mode == "OBJECT"
        with retopology.written(context, job) as (_, transaction):
            delivery = remeshing.to_delivery(self)
            arrays = job.inputs.arrays
            made = quad_meshes.add(
                context, source, arrays, quads, delivery, transaction, forward=is_idle
            )
            own = topology.OwnPlan.of(quads.planned, len(arrays.triangles))
            made.umbilics_check.surface = source
            made.umbilics_check.planned = own.to_text()
            stamp = checks.signature_of(made, None)
            against = retopology.against(job, found.umbilics, own_plan=True)
            checks.write(context, made, against, found.check, quads.planned, stamp, transaction)
            # Of several warnings the status bar shows the last one only, for a few seconds.
            made.umbilics_check.warnings = "\n".join(self.warnings(found))
            sentences = list(topology.sentences(made.umbilics_check))
            if delivery.transfer and quad_meshes.lacks_keys(source, made):
                sentences.append(
                    "Shape keys were not carried over: they are of the mesh without its modifiers; "
                    "choose Source: Base Mesh, and give the quads these modifiers"
                )
        said = ". ".join(sentences)
        count, poles = len(quads.quads), len(quads.pole_valence)
        return f"{count} quads, {poles} pole{'' if poles == 1 else 's'}. {said}."

    def warnings(self, found: Made) -> tuple[str, ...]:
        return found.quads.warnings


UMBILICS_OT_remesh_to_quads.__annotations__ = remeshing.properties()


register, unregister = bpy.utils.register_classes_factory((UMBILICS_OT_remesh_to_quads,))
