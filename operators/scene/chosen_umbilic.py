"""What the operators on one umbilic of the list share."""

from __future__ import annotations

import bpy

from ..base import changes
from ..data import record, summary
from . import filters, selection, targets

NOTHING_CHOSEN = "Click an umbilic in the list first."


def chosen_row(context: bpy.types.Context) -> int | None:
    """Row of the umbilic that is active in the list of the active object, if there is one."""
    obj = selection.shown(context)
    if record.of(obj) is None or not 0 <= obj.umbilics.active < len(obj.umbilics.items):
        return None
    return obj.umbilics.items[obj.umbilics.active].row


def is_chosen(cls: type[bpy.types.Operator], context: bpy.types.Context) -> bool:
    """For `poll`: whether an umbilic is chosen; explains itself if none is."""
    if chosen_row(context) is None:
        cls.poll_message_set(NOTHING_CHOSEN)
        return False
    return True


def can_be_changed(cls: type[bpy.types.Operator], context: bpy.types.Context) -> bool:
    """For `poll`: as `is_chosen`, and the results are of this file."""
    if not is_chosen(cls, context):
        return False
    if not targets.is_local(selection.shown(context)):
        cls.poll_message_set("These results are linked from another file.")
        return False
    return True


def toggle(context: bpy.types.Context, name: str, row: int) -> None:
    """Put a row into the object's list `name`, "pinned" or "deleted", or take it out."""
    obj = selection.shown(context)
    rows = set(summary.rows_of(getattr(obj.umbilics, name))) ^ {row}
    setattr(obj.umbilics, name, summary.text_of(rows))
    filters.apply(context, obj, filters.used_filters(obj))
    changes.notify("view", context)
