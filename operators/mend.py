"""Operator: do what a detection's verdict advises, and detect again."""

import math
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass

import bmesh
import bpy
import numpy as np
from bpy.props import EnumProperty

from .. import core
from .base import app_handlers, verdict
from .data import record
from .jobs import detect, refusals
from .jobs.modal import DetectionOperator, Message, possible
from .mesh.fetch import fetch
from .mesh.fingerprint import mesh_signature
from .mesh.read import positions
from .scene import homes, selection, targets
from .scene.modes import object_mode
from .scene.transaction import Transaction

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


# What was mended for the detection that runs, to be taken back if that comes to nothing; none once
# an undo or a file has made its data another's.
_mended: list[Transaction] = []


class UMBILICS_OT_mend(DetectionOperator, bpy.types.Operator):
    bl_idname = "umbilics.mend"
    bl_label = "Mend and Detect"
    bl_description = "Do what the last detection's verdict advises, and detect again"

    way: EnumProperty(
        name="Way",
        items=[(way, label, _TEXTS[way]) for way, label in verdict.LABELS.items()],
    )
    again = True

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        obj = selection.active(context)
        reason = refusals.why_not(obj, with_modifiers=True)
        if not reason and not targets.is_own(obj):
            reason = f"{obj.name} is linked from another file: change it there."
        return possible(cls, reason)

    def execute(self, context: bpy.types.Context) -> set[str]:
        with _taken_back_on_error():
            return _ended(super().execute(context))

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        with _taken_back_on_error():
            return super().invoke(context, event)

    def jobs(
        self, context: bpy.types.Context
    ) -> tuple[list[detect.Inputs], list[core.UmbilicsError]]:
        transaction = Transaction(ExitStack())
        _mended[:] = [transaction]
        _WAYS[self.way](context, selection.active(context), transaction)
        context.view_layer.update()
        jobs, refused = super().jobs(context)
        if not jobs:
            raise refused[0]
        return jobs, refused

    def put(
        self,
        context: bpy.types.Context,
        job: detect.Inputs,
        found: detect.Results,
        whole: Transaction | None,
    ) -> list[Message]:
        # What was mended and what was found then are a whole.
        whole = whole or next(iter(_mended), None)
        return super().put(context, job, found, whole)

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        with _taken_back_on_error():
            return _ended(super().modal(context, event))

    def unwritten(self, context: bpy.types.Context) -> None:
        _take_back()


def _ended(result: set[str]) -> set[str]:
    """Keep what was mended, once the detection has come to its end and it was not taken back."""
    if not result & {"RUNNING_MODAL", "PASS_THROUGH"}:
        for transaction in _mended:
            transaction.finish()
        _mended.clear()
    return result


def _take_back() -> None:
    while _mended:
        _mended.pop().take_back()


@contextmanager
def _taken_back_on_error() -> Iterator[None]:
    try:
        yield
    except BaseException:
        _take_back()
        raise


@bpy.app.handlers.persistent
def _forget(*_: object) -> None:
    _mended.clear()


# Meanwhile the user goes on working: what is taken back is found again by its names.


def _subdivide(context: bpy.types.Context, obj: bpy.types.Object, transaction: Transaction) -> None:
    display = context.scene.umbilics_display
    modifier = next((m for m in reversed(obj.modifiers) if m.type == "SUBSURF"), None)
    if modifier is None:
        modifier = obj.modifiers.new("Subdivision", "SUBSURF")
        transaction.on_failure(_remove_modifier, obj.name_full, modifier.name)
        modifier.levels = _levels_for(obj.data)
    else:
        before = modifier.levels, modifier.show_viewport
        transaction.on_failure(_put_levels_back, obj.name_full, modifier.name, *before)
        modifier.levels += 1
    modifier.show_viewport = True
    transaction.keep(display, "source")
    display.source = "EVALUATED"


def _remove_modifier(full_name: str, name: str) -> None:
    modifier = _modifier(full_name, name)
    if modifier is not None:
        modifier.id_data.modifiers.remove(modifier)


def _put_levels_back(full_name: str, name: str, levels: int, shown: bool) -> None:
    modifier = _modifier(full_name, name)
    if modifier is not None:
        modifier.levels, modifier.show_viewport = levels, shown


def _modifier(full_name: str, name: str) -> bpy.types.SubsurfModifier | None:
    obj = targets.named(full_name)
    found = None if obj is None else obj.modifiers.get(name)
    return found if found is not None and found.type == "SUBSURF" else None


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
        before = Before(work.copy(), [fetch(part, "select", 1, bool) for part in _parts(obj.data)])
        transaction.on_failure(before.put_back, context, obj.name_full)
        transaction.at_end(before.mesh.free)
        try:
            reach = _SAME * float(abs(positions(obj.data)).max(initial=0.0))
            bmesh.ops.remove_doubles(work, verts=work.verts, dist=reach)
            work.to_mesh(obj.data)
        finally:
            work.free()
        obj.data.update()
        before.after = mesh_signature(obj.data)


@dataclass
class Before:
    """A mesh before it was merged, what was selected of it, and what tells the merged one from
    another that the user has made of it meanwhile; nothing while it is merged."""

    mesh: bmesh.types.BMesh
    selected: list[np.ndarray]
    after: str = ""

    def put_back(self, context: bpy.types.Context, full_name: str) -> None:
        obj = targets.named(full_name)
        if obj is None:
            return
        with object_mode(context, obj, push=False):
            if not self.after or self.after == mesh_signature(obj.data):
                self.mesh.to_mesh(obj.data)
                # Before Blender 5.0 a BMesh also selects all corners of faces that are selected.
                for part, wanted in zip(_parts(obj.data), self.selected, strict=True):
                    if not np.array_equal(fetch(part, "select", 1, bool), wanted):
                        part.foreach_set("select", wanted)
                obj.data.update()
        self.mesh.free()


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


_HANDLERS = tuple((name, _forget) for name in ("undo_post", "redo_post", "load_post"))


def register() -> None:
    bpy.utils.register_class(UMBILICS_OT_mend)
    app_handlers.add(_HANDLERS)


def unregister() -> None:
    app_handlers.remove(_HANDLERS)
    bpy.utils.unregister_class(UMBILICS_OT_mend)
