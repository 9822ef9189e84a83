"""One umbilic or pole is chosen at a time: in list or table, among the objects, and in the view.

A row that is clicked selects its empty, and a second click soon after brings it into view; an
empty that is clicked makes its row the active one. `choose` and `choose_pole` do the same for
whoever found it otherwise.
"""

from __future__ import annotations

import bpy
from bpy.app.handlers import persistent

from ..base import app_handlers, changes
from ..data import clicks, plans
from ..data.belonging import mesh_behind
from . import empties, selection, targets
from .retopology import guidance_objects
from .view import framing

NONE = -1


def choose(context: bpy.types.Context, obj: bpy.types.Object, row: int) -> None:
    """Make a candidate of an object the active one of its list, and select its empty."""
    mine = obj.umbilics
    rows = [item.row for item in mine.items]
    with changes.silence("active"):
        mine.active = rows.index(row) if row in rows else NONE
    mine.active_row = row
    _select(context, obj, empties.empties_of(obj), "umbilics_row", row)
    changes.notify("view", context)


def choose_pole(context: bpy.types.Context, obj: bpy.types.Object, name: str) -> None:
    """Make the pole whose empty has that name the active one of its table, and select it."""
    with changes.silence("pole"):
        obj.umbilics_plan.active = plans.index_of(obj, bpy.data.objects[name])
    _select(context, obj, guidance_objects.parts_of(obj, guidance_objects.POLES), "", name)
    changes.notify("view", context)


def _select(
    context: bpy.types.Context,
    obj: bpy.types.Object,
    among: list[bpy.types.Object],
    key: str,
    wanted: int | str,
) -> None:
    """Select that one of the empties whose property `key`, or whose name, is the wanted."""
    layer = context.view_layer
    if obj.mode != "OBJECT":
        return
    chosen = None
    for empty in among:
        if empty.name not in layer.objects:
            continue
        is_wanted = (empty.get(key) if key else empty.name) == wanted
        chosen = empty if is_wanted else chosen
        if empty.select_get() != is_wanted:
            empty.select_set(is_wanted)
    # With another one of ours active the next look at it would choose that again.
    if mesh_behind(layer.objects.active) == obj and layer.objects.active != obj:
        layer.objects.active = chosen or obj


def _row_chosen(context: bpy.types.Context) -> None:
    obj = selection.shown(context)
    if obj is None or not 0 <= obj.umbilics.active < len(obj.umbilics.items):
        return
    row = obj.umbilics.items[obj.umbilics.active].row
    if clicks.is_second(context, f"{obj.name_full} {row}"):
        framing.frame(context, obj, row)
    choose(context, obj, row)


def _pole_chosen(context: bpy.types.Context) -> None:
    obj = selection.shown(context)
    if obj is None or not 0 <= obj.umbilics_plan.active < len(obj.umbilics_plan.poles):
        return
    empty = plans.empty_of(obj.umbilics_plan.poles[obj.umbilics_plan.active])
    if empty is None:
        return
    if clicks.is_second(context, f"{obj.name_full} pole {empty.name}"):
        framing.frame_pole(context, empty)
    choose_pole(context, obj, empty.name)


def _mark_chosen(context: bpy.types.Context) -> None:
    obj = context.view_layer.objects.active
    if obj is None or not 0 <= obj.umbilics_check.active < len(obj.umbilics_check.marks):
        return
    number = obj.umbilics_check.active
    if clicks.is_second(context, f"{obj.name_full} mark {number}"):
        framing.frame_mark(context, obj, number)
    changes.notify("view", context)


@persistent
def _looked_at(_scene: bpy.types.Scene, _depsgraph: bpy.types.Depsgraph) -> None:
    """The active object may be another one: if it is an empty of ours, so is its row."""
    clicked = bpy.context.view_layer.objects.active
    obj = mesh_behind(clicked)
    if obj is None or obj == clicked or not targets.is_local(obj) or not clicked.select_get():
        return
    if empties.EMPTY_TAG in clicked:
        row = clicked.get("umbilics_row", NONE)
        is_other = obj.umbilics.detected and row != obj.umbilics.active_row
    elif clicked.get(guidance_objects.TAG) == guidance_objects.POLES:
        place = plans.index_of(obj, clicked)
        is_other = place not in (obj.umbilics_plan.active, NONE)
    else:
        return
    if is_other and empties.EMPTY_TAG in clicked:
        choose(bpy.context, obj, row)
    elif is_other:
        choose_pole(bpy.context, obj, clicked.name)


_HANDLERS = (("depsgraph_update_post", _looked_at),)


def register() -> None:
    changes.listen("active", _row_chosen)
    changes.listen("pole", _pole_chosen)
    changes.listen("mark", _mark_chosen)
    app_handlers.add(_HANDLERS)


def unregister() -> None:
    app_handlers.remove(_HANDLERS)
    changes.forget("mark", _mark_chosen)
    changes.forget("pole", _pole_chosen)
    changes.forget("active", _row_chosen)
