"""Operator: bring the active mesh onto another selected one that it is the same shape as."""

from typing import Any

import bpy
import numpy as np
from bpy.props import BoolProperty

from .jobs import matching
from .jobs.modal import BackgroundOperator, Message, NeedsMesh
from .scene.transaction import Transaction


class UMBILICS_OT_align_to_other(NeedsMesh, BackgroundOperator, bpy.types.Operator):
    bl_idname = "umbilics.align_to_other"
    bl_label = "Align to Other"
    bl_description = (
        "Turn and move the active mesh onto the other selected one, by umbilics that are the same "
        "points of both; parts may be missing. With several others, onto the one that it is. The "
        "mesh itself is not changed"
    )

    scaled: BoolProperty(
        name="Scale Too",
        description="The two may be of different size: the active one is scaled to the other's",
    )

    def jobs(self, context: bpy.types.Context) -> tuple[list[matching.Job], list[Any]]:
        return [matching.gather(context, self.scaled)], []

    def put(
        self,
        context: bpy.types.Context,
        job: matching.Job,
        found: matching.BestAlignment,
        whole: Transaction | None,
    ) -> list[Message]:
        best = found.alignment
        size = float(np.linalg.norm(np.ptp(job.inputs.arrays.vertices, axis=0))) * best.scale
        scaled = f", scaled {best.scale:.4g} times" if job.scaled else ""
        other = found.other.object_name
        words = (
            f"{job.object_name} lies on {other}{scaled}: {100.0 * best.overlap:.0f} % of it "
            f"overlap, {100.0 * best.error / size:.2g} % of its size apart, direction good to "
            f"{best.rotation_error:.1g}°."
        )
        matching.move(context, job, found)
        return [("INFO", words)]


register, unregister = bpy.utils.register_classes_factory((UMBILICS_OT_align_to_other,))
