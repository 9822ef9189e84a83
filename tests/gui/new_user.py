"""The path of a new user, by mouse and keys, in a Blender that has no extension yet.

    blender --python new_user.py -- ZIP MESH REPORT.json

Installs the zip from the preferences, imports the mesh, detects, thins out, chooses in the list,
shows the gap and takes all of it back. What is found goes into the report, the pictures beside
it; tools/guide_in_window.py takes those of the guide in the same way.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import bpy
import numpy as np
from hands import (
    View,
    choose_file,
    click,
    focus,
    insist,
    insist_on_value,
    move_window,
    open_tab,
    place_in,
    play,
    point,
    press,
    until,
)
from stage import (
    FIRST_ROW,
    NAME,
    ROW,
    SHOW_MAP,
    STRENGTH,
    Report,
    bring_in_sight,
    in_tab,
    part,
    press_detect,
)

# Where things are in the preferences and on the screen, in pixels from the left and the top.
GET_EXTENSIONS, ARROW, INSTALL_FROM_DISK = (80, 195), (857, 18), (747, 140)
FILE, IMPORT, WAVEFRONT = (42, 13), (76, 311), (317, 331)

Shot = Callable[[str], object]


class NewUser:
    """The steps of the path. `shot` takes a picture, and `found` gathers what was seen."""

    def __init__(self, shot: Shot, found: dict) -> None:
        self.shot = shot
        self.found = found
        self.view = View()

    def install(self, zip_file: Path) -> Iterator[float]:
        """Preferences, Get Extensions, Install from Disk."""
        self.found["installed_before"] = NAME in bpy.context.preferences.addons
        point(*self.view.middle())
        yield 0.5
        press("ctrl+comma")
        yield 2.0
        move_window("Preferences", 300, 120)
        yield 1.5
        yield from until(lambda: len(bpy.context.window_manager.windows) > 1)
        window = bpy.context.window_manager.windows[-1]
        click(*place_in(window, *GET_EXTENSIONS))
        yield 1.5
        click(*place_in(window, *ARROW))
        yield 1.5
        self.shot("install_from_disk")
        click(*place_in(window, *INSTALL_FROM_DISK))
        yield from choose_file(zip_file)
        yield from until(lambda: NAME in bpy.context.preferences.addons)
        yield 1.0
        self.found["installed"] = NAME in bpy.context.preferences.addons
        self.shot("installed")
        with bpy.context.temp_override(window=window):
            bpy.ops.wm.window_close()
        yield 1.0
        focus("Blender")

    def import_mesh(self, path: Path) -> Iterator[float]:
        """Empty the scene; File, Import, Wavefront; and a look at all of it."""
        yield 0.5
        point(*self.view.middle())
        yield 0.5
        press("a")
        yield 0.5
        press("Delete")
        yield 0.5
        for place in (FILE, IMPORT, WAVEFRONT):
            click(*place)
            yield 1.5
        yield from choose_file(path)
        yield from until(lambda: any(obj.type == "MESH" for obj in bpy.data.objects))
        focus("Blender")
        point(*self.view.middle())
        yield 1.0
        press("KP_Decimal")
        yield 1.0
        self.found["imported"] = [obj.name for obj in bpy.data.objects if obj.type == "MESH"]

    @property
    def mesh(self) -> bpy.types.Object:
        return next(obj for obj in bpy.data.objects if obj.type == "MESH")

    @property
    def shown(self) -> int:
        return len(self.mesh.umbilics.items)

    def state(self) -> dict:
        """All that the path could leave behind."""
        return {
            "objects": sorted(obj.name for obj in bpy.data.objects),
            "collections": sorted(item.name for item in bpy.data.collections),
            "attributes": sorted(item.name for item in self.mesh.data.attributes),
            "properties": sorted([*self.mesh.keys(), *self.mesh.data.keys()]),
            "detected": self.mesh.umbilics.detected,
            "shading": [self.view.space.shading.type, self.view.space.shading.color_type],
        }

    def detect(self) -> Iterator[float]:
        """Press the button and wait."""
        yield from open_tab(self.view)
        self.found["before"] = self.state()
        self.shot("before")
        yield from press_detect(self.view)
        point(*self.view.middle())
        yield 1.0
        self.found["detected"] = self.shown
        self.shot("detected")

    def thin_out(self) -> Iterator[float]:
        """Type the Strength that leaves about half of the umbilics."""
        display = bpy.context.scene.umbilics_display
        kept = part("operators.data.record").of(self.mesh)
        # Sorted from the largest, those without one first.
        levels = np.sort(kept.detection.candidates.persistence)[::-1]
        level = float(levels[np.isnan(levels).sum() + self.shown // 2])
        value = part("operators.data.strength").strength_of(level, kept.top)
        yield from insist_on_value(
            lambda: abs(display.strength - value) < 1e-3, in_tab(self.view, 0.6, STRENGTH), value
        )
        point(*self.view.middle())
        yield 1.0
        self.found["thinned"] = self.shown
        self.shot("thinned")

    def choose(self) -> Iterator[float]:
        """Click a row of the list."""
        yield from insist(
            lambda: self.mesh.umbilics.active >= 0, in_tab(self.view, 0.3, FIRST_ROW + ROW)
        )
        chosen = [obj.name for obj in bpy.context.selected_objects if obj.type == "EMPTY"]
        self.found["chosen"] = chosen
        self.shot("chosen")

    def show_map(self) -> Iterator[float]:
        """Show the gap."""
        shown = self.mesh.data.color_attributes
        yield from bring_in_sight(self.view, SHOW_MAP[1])
        yield from insist(lambda: "umbilics_map" in shown, in_tab(self.view, *SHOW_MAP))
        point(*self.view.middle())
        yield 1.5
        self.found["map"] = "umbilics_map" in shown
        self.found["shading_with_map"] = self.view.space.shading.color_type
        self.shot("map")

    def undo_all(self) -> Iterator[float]:
        """Ctrl Z until nothing is left of it."""
        point(*self.view.middle())
        yield 0.5
        self.found["undo_steps"] = 0
        while self.mesh.umbilics.detected and self.found["undo_steps"] < 12:
            press("ctrl+z")
            yield 1.0
            self.found["undo_steps"] += 1
        self.found["after"] = self.state()
        self.shot("undone")


def main(zip_file: Path, mesh: Path, report: Report) -> None:
    user = NewUser(report.picture, report.found)

    def path():
        yield from user.install(zip_file)
        yield from user.import_mesh(mesh)
        yield from user.detect()
        yield from user.thin_out()
        yield from user.choose()
        yield from user.show_map()
        yield from user.undo_all()

    play(report.of(path))


if __name__ == "__main__":
    zip_file, mesh, path_of_report = map(Path, sys.argv[-3:])
    main(zip_file, mesh, Report(path_of_report))
