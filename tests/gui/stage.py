"""What the scenarios stand on besides the hands: the add-on, meshes, and what they have found.

A scenario runs inside Blender's window. Its finds go into the JSON file that is named last on the
command line, its pictures beside it.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType

import bpy
from hands import PATIENCE, LostEventError, View, click, insist, picture

NAME = "bl_ext.user_default.umbilics"
# Where things are in the tab after a detection, in pixels below its top, if the verdict under
# Detect takes two lines and has no button; else see `in_tab`.
DETECT, STRENGTH, FIRST_ROW, ROW = 100, 246, 538, 21
# The verdict's button.
REMEDY = 178
# In parts of its width and in pixels below its top.
SHOW_MAP = 0.75, 705
# Heights of a line and of a button of the verdict.
_LINE, _BUTTON = 15, 29


def part(name: str) -> ModuleType:
    """A module of the installed add-on, such as "operators.jobs.worker"."""
    return sys.modules[f"{NAME}.{name}"]


def in_tab(view: View, x: float, y: float) -> tuple[int, int]:
    """Screen pixels of a place below the verdict on the active object's results."""
    found = bpy.context.view_layer.objects.active.umbilics
    judged = part("operators.base.verdict").verdict(found)
    width = view.region("UI").width / bpy.context.preferences.system.ui_scale
    texts = (f"{judged.found}: {judged.trust}", found.analysed)
    lines = sum(len(part("ui.parts").broken(text, width)) for text in texts)
    # How far the tab has been scrolled: its own height at the top of the region, 0 or less.
    region = view.region("UI")
    scrolled = region.view2d.region_to_view(0, region.height)[1]
    pushed = _LINE * (lines - 2) + (_BUTTON if judged.remedy else 0)
    return view.in_sidebar(x, y + pushed + scrolled)


def bring_in_sight(view: View, y: float) -> Iterator[float]:
    """Turn the mouse wheel over the tab until a place there is not below its end."""
    for _ in range(20):
        region = view.region("UI")
        if in_tab(view, 0.5, y)[1] < view.window.height - region.y - 2 * ROW:
            return
        # Near the top: over the list, the wheel would turn the list.
        click(*view.in_sidebar(0.1, 60), button=5)
        yield 1.2
    raise LostEventError("the tab does not scroll")


def running():
    """The detection or plan that is being computed, or None."""
    return part("operators.jobs.worker").current()


def press_detect(view: View) -> Iterator[float]:
    """Click on Detect, until a detection has begun, and wait for its end."""
    obj = bpy.context.view_layer.objects.active
    before = obj.umbilics.stamp
    yield from insist(
        lambda: running() is not None or obj.umbilics.stamp != before, view.in_sidebar(0.5, DETECT)
    )
    yield from settled()


def settled(pause: float = 0.5, limit: float = PATIENCE) -> Iterator[float]:
    """Until nothing is computed and the overlay has all its strokes."""
    end = time.monotonic() + limit
    yield pause
    while running() is not None or part("ui.overlay.painter").is_waiting():
        assert time.monotonic() < end, "the window does not come to rest"
        yield 0.1
    yield pause


def clear_scene(view: View) -> None:
    with view.inside():
        bpy.ops.object.select_all(action="SELECT")
        bpy.ops.object.delete()


def monkey(view: View, levels: int) -> bpy.types.Object:
    """Blender's monkey alone in the scene, subdivided and smooth, seen from the front."""
    clear_scene(view)
    with view.inside():
        bpy.ops.mesh.primitive_monkey_add(size=4.0)
        obj = bpy.context.object
        obj.modifiers.new("Subdivision", "SUBSURF").levels = levels
        bpy.ops.object.modifier_apply(modifier="Subdivision")
        bpy.ops.object.shade_smooth()
        bpy.ops.view3d.view_axis(type="FRONT")
        bpy.ops.view3d.view_selected()
        bpy.ops.ed.undo_push(message="monkey")
    return obj


class Report:
    """What a scenario has found, by name, and its pictures."""

    def __init__(self, path: Path) -> None:
        self.found = {}
        self._path = path

    @property
    def folder(self) -> Path:
        return self._path.parent

    def picture(self, name: str) -> Path:
        """The whole screen as it is now, beside the report."""
        path = self.folder / f"{name}.png"
        picture(path)
        return path

    def of(self, scenario: Callable[[], Iterator[float]]) -> Callable[[], Iterator[float]]:
        """The scenario, whose finds are written down however it ends."""

        def told() -> Iterator[float]:
            try:
                yield from scenario()
            finally:
                self._path.write_text(json.dumps(self.found, indent=1))

        return told
