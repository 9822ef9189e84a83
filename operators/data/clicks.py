"""The last click in a list, kept with the window manager: a list does not tell double clicks."""

from __future__ import annotations

import time

import bpy
from bpy.props import IntProperty, StringProperty

from ..base import property_groups

# Milliseconds are counted round and round, within Blender's whole numbers.
_ROUND = 1 << 30


class UMBILICS_PG_click(bpy.types.PropertyGroup):
    """What was clicked last, and when."""

    what: StringProperty()
    when: IntProperty(description="In milliseconds")


def is_second(context: bpy.types.Context, what: str) -> bool:
    """Note a click; whether it makes a double click with the one before."""
    last = context.window_manager.umbilics_click
    now = int(1000.0 * time.monotonic()) % _ROUND
    pause = context.preferences.inputs.mouse_double_click_time
    second = last.what == what and (now - last.when) % _ROUND < pause
    last.what, last.when = what, now
    return second


register, unregister = property_groups.factory(
    (UMBILICS_PG_click,), (bpy.types.WindowManager, "umbilics_click", UMBILICS_PG_click)
)
