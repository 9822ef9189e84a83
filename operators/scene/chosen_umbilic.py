"""What the operators on one umbilic of the list share."""

from __future__ import annotations

import bpy

from ..base import changes
from ..base.translation import reported
from ..data import record, summary
from . import filters, selection, targets

NOTHING_CHOSEN = "Click an umbilic in the list first."

# Its object, the record of that and the row among the candidates.
Chosen = tuple[bpy.types.Object, record.Record, int]


def _found(context: bpy.types.Context) -> Chosen | None:
    obj = selection.shown(context)
    kept = record.of(obj)
    if kept is None or not 0 <= obj.umbilics.active < len(obj.umbilics.items):
        return None
    return obj, kept, obj.umbilics.items[obj.umbilics.active].row


def chosen(context: bpy.types.Context) -> Chosen:
    """The umbilic that is active in the list of the active object, where `is_chosen`."""
    found = _found(context)
    assert found is not None, NOTHING_CHOSEN
    return found


def is_chosen(cls: type[bpy.types.Operator], context: bpy.types.Context) -> bool:
    """For `poll`: whether an umbilic is chosen; explains itself if none is."""
    if _found(context) is None:
        cls.poll_message_set(reported(NOTHING_CHOSEN))
        return False
    return True


def can_be_changed(cls: type[bpy.types.Operator], context: bpy.types.Context) -> bool:
    """For `poll`: as `is_chosen`, and the results are of this file."""
    if not is_chosen(cls, context):
        return False
    if not targets.is_local(selection.shown(context)):
        cls.poll_message_set(reported("These results are linked from another file."))
        return False
    return True


def toggle(context: bpy.types.Context, name: str) -> None:
    """Put the chosen umbilic into the list `name`, "pinned" or "deleted", or take it out."""
    obj, _, row = chosen(context)
    rows = set(summary.rows_of(getattr(obj.umbilics, name))) ^ {row}
    filters.put_rows(context, obj, name, summary.text_of(rows))
    changes.notify("view", context)
