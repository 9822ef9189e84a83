"""Operator: hold the active mesh, a retopology, against the surface that it should follow."""

import bpy

from .. import core
from .base.errors import ObjectError
from .data import topology
from .jobs import retopology, works
from .jobs.modal import GuidanceOperator
from .mesh.attributes import check_result_names, is_whole
from .mesh.read import polygons_in_world
from .scene import targets
from .scene.modes import object_mode
from .scene.retopology import checks
from .scene.transaction import all_or_nothing


class UMBILICS_OT_check_topology(GuidanceOperator, bpy.types.Operator):
    bl_idname = "umbilics.check_topology"
    bl_label = "Check Topology"
    bl_description = (
        "Hold the active mesh against the surface that it should follow: its irregular vertices "
        "against the planned poles, its edges against the directions of curvature, its distance"
    )

    def job(self, context: bpy.types.Context) -> retopology.Job:
        checked = context.active_object
        surface = _surface_of(context, checked)
        mesh = checked.data
        ours = checks.are_held(mesh) or is_whole(mesh, checks.ATTRIBUTES)
        check_result_names(checked, checks.ATTRIBUTES, ours)
        with object_mode(context, checked, push=False):
            context.view_layer.update()
            seen = checks.depsgraph_of(context, context.scene.umbilics_display.source)
            places, corners, start = polygons_in_world(checked, seen)
            if not len(corners):
                raise ObjectError(f"{checked.name} has no faces to check.")
            self._stamp = checks.signature_of(checked, seen)
        self._checked = checked.name_full
        own = topology.own_plan(checked.umbilics_check)
        self._own_plan = own is not None

        def work(
            job: retopology.Job, guide: core.Guide, progress: core.Progress
        ) -> tuple[core.TopologyCheck, core.Poles, core.Umbilics]:
            if own is None:
                part = progress.part("Planning poles", 0.0, 0.6)
                poles = works.plan(job, guide, part)[0].poles
            else:
                read = job.inputs.arrays
                poles = own.poles(read.vertices, read.triangles)
            part = progress.part("Comparing", 0.6, 1.0)
            found = core.check_topology(places, corners, start, guide, poles, part)
            return found, poles, guide.detection.umbilics

        job = retopology.gather(context, surface, work, steered=own is None)
        if own is not None and len(job.inputs.arrays.triangles) != own.triangles:
            raise ObjectError(
                f"{surface.name} has other faces than when these quads were made of it. Turn Plan "
                "of the Quads off to compare with a new plan."
            )
        return job

    def done(
        self,
        context: bpy.types.Context,
        job: retopology.Job,
        found: tuple[core.TopologyCheck, core.Poles, core.Umbilics],
    ) -> str:
        checked = targets.still_there(self._checked)
        with object_mode(context, checked), all_or_nothing() as transaction:
            seen = checks.depsgraph_of(context, checks.source_in(self._stamp))
            if checks.signature_of(checked, seen) != self._stamp:
                raise ObjectError(f"{checked.name} was changed meanwhile. Try again.")
            check, poles, umbilics = found
            against = retopology.against(job, umbilics, self._own_plan)
            checks.write(context, checked, against, check, poles, self._stamp, transaction)
            return f"{'. '.join(topology.sentences(checked.umbilics_check))}."


def _surface_of(context: bpy.types.Context, checked: bpy.types.Object | None) -> bpy.types.Object:
    """The mesh that the active one is held against."""
    if checked is None or checked.type != "MESH":
        raise ObjectError("Make the mesh that is to be checked the active object.")
    if not targets.is_own(checked):
        raise ObjectError(f"{checked.name} is linked from another file and cannot keep a check.")
    chosen = checked.umbilics_check.surface
    others = [chosen] if chosen is not None else list(context.selected_objects)
    others = [obj for obj in others if obj.type == "MESH" and obj != checked]
    if len(others) != 1:
        raise ObjectError(
            "Choose the surface: select it together with the mesh that is to be checked, which is "
            "the active one, or name it in the panel under Check."
        )
    return others[0]


register, unregister = bpy.utils.register_classes_factory((UMBILICS_OT_check_topology,))
