"""How 3D views were shaded before a map was shown, so that they can be put back.

It is kept with the screen, by the place of the area among the screen's areas: a screen is no
part of undo, and the way back is still known after the file was saved and opened again.
"""

from __future__ import annotations

import json

import bpy

_TAG = "umbilics_shading"
_KEPT = ("type", "color_type", "light")


def show_attributes(screen: bpy.types.Screen, area: bpy.types.Area) -> None:
    """Solid view with the colours of the active attribute."""
    shading = area.spaces.active.shading
    known = _known(screen)
    known.setdefault(_place(screen, area), {name: getattr(shading, name) for name in _KEPT})
    screen[_TAG] = json.dumps(known)
    shading.type = "SOLID"
    shading.color_type = "VERTEX"


def put_back(screen: bpy.types.Screen, area: bpy.types.Area) -> bool:
    """Shade the view as it was; False if it was not changed."""
    known = _known(screen)
    before = known.pop(_place(screen, area), None)
    if before is None:
        return False
    shading = area.spaces.active.shading
    # The colour and light of Solid view can be set in Solid view only.
    shading.type = "SOLID"
    shading.light = before["light"]
    shading.color_type = before["color_type"]
    shading.type = before["type"]
    if known:
        screen[_TAG] = json.dumps(known)
    else:
        del screen[_TAG]
    return True


def is_changed(screen: bpy.types.Screen, area: bpy.types.Area) -> bool:
    """Whether the view shows attributes because of us."""
    return _place(screen, area) in _known(screen)


def _known(screen: bpy.types.Screen) -> dict[str, dict[str, str]]:
    return json.loads(screen.get(_TAG, "{}"))


def _place(screen: bpy.types.Screen, area: bpy.types.Area) -> str:
    return str(next(place for place, other in enumerate(screen.areas) if other == area))
