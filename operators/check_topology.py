"""Operator: hold the active mesh, a retopology, against the surface that it should follow."""

import bpy
import numpy as np

from .. import core
from .base.errors import ObjectError
from .data import topology
from .jobs import retopology
from .jobs.modal import GuidanceOperator
from .mesh.attributes import check_result_names, write_attributes
from .mesh.fetch import fetch
from .mesh.fingerprint import mesh_signature
from .mesh.read import current_mesh, positions
from .scene import targets
from .scene.modes import object_mode
from .scene.transaction import all_or_nothing

# 1 for a vertex that stands for a planned pole, 2 for an extra one.
ATTRIBUTES = {
    "umbilics_check_pole": ("POINT", "INT"),
    "umbilics_check_distance": ("POINT", "FLOAT"),
    "umbilics_check_angle": ("FACE", "FLOAT"),
}


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
        check_result_names(checked, ATTRIBUTES)
        with object_mode(context, checked, push=False), current_mesh(checked) as mesh:
            if not len(mesh.polygons):
                raise ObjectError(f"{checked.name} has no faces to check.")
            matrix = np.array(checked.matrix_world)
            places = positions(mesh) @ matrix[:3, :3].T + matrix[:3, 3]
            corners = fetch(mesh.loops, "vertex_index", 1, np.int32)
            begin = fetch(mesh.polygons, "loop_start", 1, np.int32)
            self._signature = mesh_signature(mesh)
        self._checked = checked.name_full
        start = np.append(begin, len(corners))

        def work(
            job: retopology.Job, guide: core.Guide, progress: core.Progress
        ) -> core.TopologyCheck:
            guidance, _ = retopology.plan(job, guide, progress.part("Planning poles", 0.0, 0.6))
            part = progress.part("Comparing", 0.6, 1.0)
            return core.check_topology(places, corners, start, guide, guidance.poles, part)

        return retopology.gather(context, surface, work, steered=True)

    def done(
        self, context: bpy.types.Context, job: retopology.Job, found: core.TopologyCheck
    ) -> str:
        checked = targets.named(self._checked)
        if checked is None:
            raise ObjectError(f"{self._checked} is no longer there. Check again.")
        pole = np.zeros(len(found.distance), np.int32)
        pole[found.irregular] = np.where(found.pole >= 0, 1, 2)
        values = {
            "umbilics_check_pole": pole,
            "umbilics_check_distance": found.distance,
            "umbilics_check_angle": found.angle,
        }
        with object_mode(context, checked), all_or_nothing() as transaction:
            if mesh_signature(checked.data) != self._signature:
                raise ObjectError(f"{checked.name} was changed meanwhile. Check again.")
            transaction.keep_attributes(checked.data, tuple(ATTRIBUTES))
            transaction.keep_properties(checked, "umbilics_check")
            write_attributes(checked.data, values, ATTRIBUTES)
            topology.store(checked, job.object_name, found)
        return f"{'; '.join(topology.sentences(checked.umbilics_check))}."


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
