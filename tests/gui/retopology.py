"""A plan, its field, guides and files beside a living window; run inside Blender's window.

Everything that is found goes into the JSON file named last on the command line, the pictures
beside it. tests/gui/test_retopology.py reads them.
"""

import json
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import bpy
import numpy as np
from hands import View, open_tab, picture, pixels, play, point

REPORT = Path(sys.argv[-1])
NAME = "bl_ext.user_default.umbilics"
found = {}
view = View()


def look(name):
    picture(REPORT.parent / f"{name}.png")
    return pixels(REPORT.parent / f"{name}.png")[60:, :900]


def running():
    return sys.modules[f"{NAME}.operators.running"].current()


def done():
    """Until nothing is computed and the overlay has all its strokes."""
    painter = sys.modules[f"{NAME}.ui.overlay.painter"]
    yield 0.5
    while running() is not None or painter.is_waiting():
        yield 0.2
    yield 1.0


def start(operator, **arguments):
    """As a click on its button would."""
    with view.inside():
        return getattr(bpy.ops.umbilics, operator)("INVOKE_DEFAULT", **arguments)


def monkey(levels):
    with view.inside():
        bpy.ops.object.select_all(action="SELECT")
        bpy.ops.object.delete()
        bpy.ops.mesh.primitive_monkey_add(size=4.0)
        obj = bpy.context.object
        obj.modifiers.new("Subdivision", "SUBSURF").levels = levels
        bpy.ops.object.modifier_apply(modifier="Subdivision")
        bpy.ops.object.shade_smooth()
        bpy.ops.view3d.view_axis(type="FRONT")
        bpy.ops.view3d.view_selected()
    return obj


def alike(one, two):
    return float((np.abs(one - two).max(axis=2) < 0.02).mean())


def scenario():
    display = bpy.context.scene.umbilics_display
    yield from open_tab(view)
    overlay = view.space.overlay
    overlay.show_floor = overlay.show_axis_x = overlay.show_axis_y = False
    obj = monkey(3)
    point(*view.middle())
    yield 1.0
    bare = look("bare")
    start("guide")
    yield from done()
    found["poles"] = len(obj.umbilics_plan.poles)
    # A plan needs no detection of its own; without one only the crosses are drawn.
    for child in obj.children:
        child.hide_set(True)
    yield 0.5
    found["alike_principal"] = alike(bare, look("principal"))
    display.field = "CROSS"
    yield from done()
    crosses = look("crosses")
    found["alike_crosses"] = alike(bare, crosses)
    view.space.region_3d.view_distance *= 0.4
    yield from done()
    look("crosses_near")
    view.space.region_3d.view_distance /= 0.4
    for child in obj.children:
        child.hide_set(False)
    display.overlay = False
    start("draw_guides")
    yield from done()
    look("guides")
    found["guides"] = [child.type for child in obj.children if "umbilics_valence" not in child]
    display.overlay = True
    yield from files(obj)
    REPORT.write_text(json.dumps(found))


def confirm_the_file_browser():
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "FILE_BROWSER":
                with bpy.context.temp_override(window=window, area=area):
                    bpy.ops.file.execute()
                return
    raise AssertionError("no file browser opened")


def files(obj):
    """The window lives while files are written: its timers tick."""
    folder = REPORT.parent / "files"
    # The file browser leaves a folder that does not exist for another one.
    folder.mkdir(exist_ok=True)
    monkey(4)
    ticks = []

    def tick():
        ticks.append(time.monotonic())
        return 0.02

    start("export_field", filepath=str(folder / "thing.obj"), rawfield=True, sing=True)
    yield 2.0
    confirm_the_file_browser()
    yield 0.1
    found["export_runs_beside"] = running() is not None
    bpy.app.timers.register(tick)
    started = time.monotonic()
    while running() is not None:
        yield 0.05
    ended = time.monotonic()
    bpy.app.timers.unregister(tick)
    inside = [at for at in ticks if at < ended]
    found["export_seconds"] = ended - started
    found["export_longest_pause"] = float(np.diff(inside).max()) if len(inside) > 2 else 1e9
    found["files"] = sorted(path.name for path in folder.iterdir())
    yield 0.5


play(scenario)
