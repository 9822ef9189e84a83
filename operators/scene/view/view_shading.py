"""How 3D views were shaded before a map was shown, so that they can be put back.

It is kept with the screen, by the place of the area among the screen's areas: a screen is no
part of undo, and the way back is still known after the file was saved and opened again. An undo
that takes the last map away puts the views back, and its redo shows them coloured again.
"""

from __future__ import annotations

import json

import bpy
from bpy.app.handlers import persistent

from ...base import app_handlers
from ..transaction import Transaction, all_or_nothing
from . import maps

_TAG = "umbilics_shading"
# On a screen: the places of its views that an undo has put back.
_UNDONE = "umbilics_shading_undone"
_KEPT = ("type", "color_type", "light")


def show_attributes(
    screen: bpy.types.Screen, area: bpy.types.Area, transaction: Transaction
) -> None:
    """Solid view with the colours of the active attribute."""
    shading = area.spaces.active.shading
    _keep(screen, shading, transaction)
    known = _known(screen)
    known.setdefault(_place(screen, area), {name: getattr(shading, name) for name in _KEPT})
    screen[_TAG] = json.dumps(known)
    shading.type = "SOLID"
    shading.color_type = "VERTEX"


def put_back(screen: bpy.types.Screen, area: bpy.types.Area, transaction: Transaction) -> bool:
    """Shade the view as it was; False if it was not changed."""
    known = _known(screen)
    before = known.pop(_place(screen, area), None)
    if before is None:
        return False
    shading = area.spaces.active.shading
    _keep(screen, shading, transaction)
    _shade(shading, before)
    if known:
        screen[_TAG] = json.dumps(known)
    else:
        del screen[_TAG]
    return True


def _shade(shading: bpy.types.View3DShading, wanted: dict[str, str]) -> None:
    # The colour and light of Solid view can be set in Solid view only.
    shading.type = "SOLID"
    shading.light = wanted["light"]
    shading.color_type = wanted["color_type"]
    shading.type = wanted["type"]


def _keep(
    screen: bpy.types.Screen, shading: bpy.types.View3DShading, transaction: Transaction
) -> None:
    """Remember how a view is shaded, and what the screen says of its views."""
    transaction.keep_custom(screen, (_TAG, _UNDONE))
    transaction.on_failure(_shade, shading, {name: getattr(shading, name) for name in _KEPT})


def is_changed(screen: bpy.types.Screen, area: bpy.types.Area) -> bool:
    """Whether the view shows attributes because of us."""
    return _place(screen, area) in _known(screen)


def _known(screen: bpy.types.Screen) -> dict[str, dict[str, str]]:
    """How its views were shaded, by place; what is not of that form, in a damaged file, is
    nothing."""
    try:
        found = json.loads(screen.get(_TAG, "{}"))
    except (ValueError, TypeError, RecursionError):
        return {}
    if not isinstance(found, dict):
        return {}
    return {place: before for place, before in found.items() if _is_shading(before)}


def _is_shading(before: object) -> bool:
    allowed = bpy.types.View3DShading.bl_rna.properties
    return isinstance(before, dict) and all(
        isinstance(before.get(name), str)
        and before[name] in [item.identifier for item in allowed[name].enum_items_static]
        for name in _KEPT
    )


def _place(screen: bpy.types.Screen, area: bpy.types.Area) -> str:
    return str(next(place for place, other in enumerate(screen.areas) if other == area))


def areas() -> list[tuple[bpy.types.Screen, bpy.types.Area]]:
    """The 3D views that are open, with the screens that they are on."""
    return [
        (window.screen, area)
        for window in bpy.context.window_manager.windows
        for area in window.screen.areas
        if area.type == "VIEW_3D"
    ]


@persistent
def _after_undo(*_: object) -> None:
    if any(map(maps.is_shown_on, bpy.data.objects)):
        return
    with all_or_nothing() as transaction:
        for screen, area in areas():
            if put_back(screen, area, transaction):
                screen[_UNDONE] = f"{screen.get(_UNDONE, '')} {_place(screen, area)}"


@persistent
def _after_redo(*_: object) -> None:
    if not any(map(maps.is_shown_on, bpy.data.objects)):
        return
    with all_or_nothing() as transaction:
        for screen, area in areas():
            if _place(screen, area) in str(screen.get(_UNDONE, "")).split():
                show_attributes(screen, area, transaction)
        _forget_undone()


@persistent
def _after_load(*_: object) -> None:
    _forget_undone()


def _forget_undone() -> None:
    for screen in bpy.data.screens:
        if _UNDONE in screen:
            del screen[_UNDONE]


_HANDLERS = (("undo_post", _after_undo), ("redo_post", _after_redo), ("load_post", _after_load))


def register() -> None:
    app_handlers.add(_HANDLERS)


def unregister() -> None:
    app_handlers.remove(_HANDLERS)
