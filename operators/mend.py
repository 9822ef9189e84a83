"""Operator: do what a detection's verdict advises, and detect again."""

import math

import bmesh
import bpy
import numpy as np
from bpy.props import EnumProperty

from .. import core
from .base import verdict
from .base.translation import reported
from .data import record
from .jobs import refusals
from .jobs.modal import possible
from .mesh.fetch import fetch
from .mesh.read import positions
from .scene import homes, selection, targets
from .scene.modes import object_mode
from .scene.transaction import Transaction, all_or_nothing

# By so much the neighbourhoods grow where noise is as strong as the shape.
_WIDER = 1.5
# Vertices this close, in parts of the largest coordinate, are one: single precision's rounding.
_SAME = 1e-6
# A new modifier makes so many faces, or its most levels: what is too coarse with two levels (cube,
# cone), three (cylinder) or one (Suzanne) is not with these. Chosen on them; held on Spot's cage,
# and on a torso, a sword and MakeHuman's base (one level).
_FINE, _LEVELS = 5000, (1, 4)
_TEXTS = {
    verdict.SUBDIVIDE: "Add a Subdivision Surface modifier, or a level to the one that is there",
    verdict.CREASES: "Fit no curvature across edges sharper than 30°",
    verdict.MERGE: "Join vertices that lie in the same place, so that the faces around them meet",
    verdict.SMOOTH: "Fit curvature over neighbourhoods half as wide again",
}


class UMBILICS_OT_mend(bpy.types.Operator):
    bl_idname = "umbilics.mend"
    bl_label = "Mend and Detect"
    bl_description = "Do what the last detection's verdict advises, and detect again"
    bl_options = {"REGISTER", "UNDO"}

    way: EnumProperty(
        name="Way",
        items=[(way, label, _TEXTS[way]) for way, label in verdict.LABELS.items()],
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        obj = selection.active(context)
        reason = refusals.why_not(obj, with_modifiers=True)
        if not reason and not targets.is_own(obj):
            reason = f"{obj.name} is linked from another file: change it there."
        return possible(cls, reason)

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = selection.active(context)
        how = "EXEC_DEFAULT" if bpy.app.background else "INVOKE_DEFAULT"
        try:
            # What was mended for a detection that fails is taken back.
            with all_or_nothing() as transaction:
                _WAYS[self.way](context, obj, transaction)
                detected = bpy.ops.umbilics.detect(how, again=True)
                if detected == {"CANCELLED"}:
                    transaction.take_back()
        except RuntimeError as error:
            # What the detection reports as an error comes as an exception.
            self.report({"ERROR"}, reported(str(error).strip().removeprefix("Error: ")))
            return {"CANCELLED"}
        return {"CANCELLED"} if detected == {"CANCELLED"} else {"FINISHED"}


def _subdivide(context: bpy.types.Context, obj: bpy.types.Object, transaction: Transaction) -> None:
    display = context.scene.umbilics_display
    modifier = next((m for m in reversed(obj.modifiers) if m.type == "SUBSURF"), None)
    if modifier is None:
        modifier = obj.modifiers.new("Subdivision", "SUBSURF")
        transaction.on_failure(obj.modifiers.remove, modifier)
        modifier.levels = _levels_for(obj.data)
    else:
        transaction.keep(modifier, "levels", "show_viewport")
        modifier.levels += 1
    modifier.show_viewport = True
    transaction.keep(display, "source")
    display.source = "EVALUATED"


def _levels_for(mesh: bpy.types.Mesh) -> int:
    """Levels that make enough faces: the first makes one of each corner, each other four of one."""
    fewest, most = _LEVELS
    wanted = math.log(_FINE / max(len(mesh.loops), 1), 4.0)
    return min(max(math.ceil(wanted) + 1, fewest), most)


def _set_creases(
    context: bpy.types.Context, _obj: bpy.types.Object, transaction: Transaction
) -> None:
    settings = context.scene.umbilics
    transaction.keep(settings, "crease_angle_auto", "crease_angle")
    settings.crease_angle_auto, settings.crease_angle = False, math.radians(core.SHARP)


def _merge(context: bpy.types.Context, obj: bpy.types.Object, transaction: Transaction) -> None:
    with object_mode(context, obj, push=False):
        work = bmesh.new()
        work.from_mesh(obj.data)
        before = work.copy()
        selected = [fetch(part, "select", 1, bool) for part in _parts(obj.data)]
        transaction.on_failure(_put_back, context, obj, before, selected)
        transaction.at_end(before.free)
        try:
            reach = _SAME * float(abs(positions(obj.data)).max(initial=0.0))
            bmesh.ops.remove_doubles(work, verts=work.verts, dist=reach)
            work.to_mesh(obj.data)
        finally:
            work.free()
        obj.data.update()


def _put_back(
    context: bpy.types.Context,
    obj: bpy.types.Object,
    before: bmesh.types.BMesh,
    selected: list[np.ndarray],
) -> None:
    with object_mode(context, obj, push=False):
        before.to_mesh(obj.data)
        before.free()
        # Before Blender 5.0 a BMesh also selects all corners of faces that are selected.
        for part, wanted in zip(_parts(obj.data), selected, strict=True):
            if not np.array_equal(fetch(part, "select", 1, bool), wanted):
                part.foreach_set("select", wanted)
        obj.data.update()


def _parts(mesh: bpy.types.Mesh) -> tuple[bpy.types.bpy_prop_collection, ...]:
    return mesh.vertices, mesh.edges, mesh.polygons


def _widen(context: bpy.types.Context, obj: bpy.types.Object, transaction: Transaction) -> None:
    settings, kept = context.scene.umbilics, record.of(homes.owner_of(obj))
    rings = settings.scale
    if kept is not None and len(kept.edge) and (edge := float(np.median(kept.edge))) > 0.0:
        rings = kept.detection.scale / edge
    transaction.keep(settings, "scale_auto", "scale_unit", "scale")
    settings.scale_auto, settings.scale_unit = False, "rings"
    settings.scale = math.ceil(_WIDER * rings)


_WAYS = {
    verdict.SUBDIVIDE: _subdivide,
    verdict.CREASES: _set_creases,
    verdict.MERGE: _merge,
    verdict.SMOOTH: _widen,
}


register, unregister = bpy.utils.register_classes_factory((UMBILICS_OT_mend,))
