"""Blender's dashed lines from objects to their parents, off while there are results.

They run from the origin of a mesh to each of its umbilics and hide the surface. The switch is the
view's own: where it was on it is turned off once, and back on when the last result is gone. Who
turns it on meanwhile keeps it on. It is remembered with the screen, which is no part of undo.
"""

from __future__ import annotations

import bpy
from bpy.app.handlers import persistent

from ...base import app_handlers
from .. import orphans
from ..transaction import Transaction, all_or_nothing

# On a screen: the places of the views whose lines are off because of us.
_TAG = "umbilics_dashed_lines"


def settle(transaction: Transaction) -> None:
    """At its end bring all views in line with whether the file has results; in a window only."""
    if not bpy.app.background:
        transaction.at_end(
            lambda: _turn(bool(orphans.with_results(transaction.going)), transaction)
        )


def _turn(has_results: bool, transaction: Transaction) -> None:
    for screen in bpy.data.screens:
        views = {
            str(place): area.spaces.active.overlay
            for place, area in enumerate(screen.areas)
            if area.type == "VIEW_3D"
        }
        if has_results != (_TAG in screen):
            transaction.keep_custom(screen, (_TAG,))
            for one in views.values():
                transaction.keep(one, "show_relationship_lines")
        if has_results and _TAG not in screen:
            on = [place for place, one in views.items() if one.show_relationship_lines]
            screen[_TAG] = " ".join(on)
            for place in on:
                views[place].show_relationship_lines = False
        elif not has_results and _TAG in screen:
            for place in views.keys() & set(str(screen[_TAG]).split()):
                views[place].show_relationship_lines = True
            del screen[_TAG]


@persistent
def _after_undo(*_: object) -> None:
    with all_or_nothing() as transaction:
        settle(transaction)


_HANDLERS = (("undo_post", _after_undo), ("redo_post", _after_undo))


def register() -> None:
    app_handlers.add(_HANDLERS)


def unregister() -> None:
    app_handlers.remove(_HANDLERS)
