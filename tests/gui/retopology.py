"""A plan, its field, guides and files beside a living window; run inside Blender's window.

Everything that is found goes into the JSON file named last on the command line, the pictures
beside it. tests/gui/test_retopology.py reads them.
"""

import shutil
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import bpy
import numpy as np
from hands import (
    LostEventError,
    View,
    file_browsers,
    insist_on_value,
    open_tab,
    pixels,
    play,
    point,
    press,
    until,
)
from stage import Report, clear_scene, monkey, part, running, settled

# The code of the key, as names are taken for others with Ctrl and Alt.
F9 = "75"
# Where the first row of what it opens has its value, from where the mouse was; left of it may be
# a switch.
FIRST_VALUE = (265, 51)

report = Report(Path(sys.argv[-1]))
found = report.found
view = View()


def look(name):
    return pixels(report.picture(name))[60:, :900]


def start(operator, **arguments):
    """As a click on its button would."""
    with view.inside():
        return getattr(bpy.ops.umbilics, operator)("INVOKE_DEFAULT", **arguments)


def alike(one, two):
    return float((np.abs(one - two).max(axis=2) < 0.02).mean())


def scenario():
    display = bpy.context.scene.umbilics_display
    yield from open_tab(view)
    overlay = view.space.overlay
    overlay.show_floor = overlay.show_axis_x = overlay.show_axis_y = False
    obj = monkey(view, 3)
    point(*view.middle())
    yield 1.0
    bare = look("bare")
    start("guide")
    yield from settled()
    found["poles"] = len(obj.umbilics_plan.poles)
    # A plan needs no detection of its own; without one only the crosses are drawn, which it shows.
    found["field_of_the_plan"] = display.field
    display.field = "PRINCIPAL"
    for child in obj.children:
        child.hide_set(True)
    yield from settled()
    found["alike_principal"] = alike(bare, look("principal"))
    display.field = "CROSS"
    yield from settled()
    crosses = look("crosses")
    found["alike_crosses"] = alike(bare, crosses)
    view.space.region_3d.view_distance *= 0.4
    yield from settled()
    look("crosses_near")
    view.space.region_3d.view_distance /= 0.4
    for child in obj.children:
        child.hide_set(False)
    display.overlay = False
    start("draw_guides")
    yield from settled()
    look("guides")
    found["guides"] = [child.type for child in obj.children if "umbilics_valence" not in child]
    display.overlay = True
    yield from files(obj)
    yield from adjusted()


def adjusted():
    """Adjust Last Operation by F9 and a number, and then Ctrl Z, for a plan and for quads."""
    clear_scene(view)
    with view.inside():
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=4)
        bpy.context.object.scale = (1.5, 1.2, 1.0)
        # So that there is a number to adjust.
        bpy.context.scene.umbilics_guidance.smoothness_auto = False
        bpy.ops.ed.undo_push(message="ellipsoid")

    def ellipsoid():
        return bpy.data.objects["Icosphere"]

    def state():
        names = sorted(obj.name for obj in bpy.data.objects if obj.type == "MESH")
        sizes = [len(bpy.data.objects[name].data.polygons) for name in names]
        plan = ellipsoid().umbilics_plan
        stale = part("operators.scene.staleness").plan_reasons(bpy.context, ellipsoid())
        faces = dict(zip(names, sizes, strict=True))
        return {"faces": faces, "poles": len(plan.poles), "stale": stale}

    def holds(group, name, value):
        return abs(getattr(getattr(bpy.context.scene, group), name) - value) < 1e-6

    for operator, *wanted in (
        ("guide", "umbilics_guidance", "smoothness", 0.9),
        ("remesh_to_quads", "umbilics_remesh", "quads", 300),
    ):
        start(operator)
        yield from settled()
        found[operator] = [state()]
        yield from popup()
        x, y = view.middle()
        place = x + FIRST_VALUE[0], y + FIRST_VALUE[1]
        yield from insist_on_value(lambda wanted=wanted: holds(*wanted), place, wanted[-1])
        found[operator].append(state())
        report.picture(f"adjusted_{operator}")
        press("Escape")
        yield from settled()
        point(*view.middle())
        press("ctrl+z")
        yield from until(lambda before=found[operator][-1]: state() != before, 20.0)
        found[operator].append(state())
        # For the next one.
        press("ctrl+shift+z")
        yield from until(lambda after=found[operator][1]: state() == after, 20.0)


def popup():
    """Press F9 until there is something dark below the mouse."""
    x, y = view.middle()

    def is_open():
        seen = pixels(report.picture("popup"))[y + 8 : y + 40, x + 20 : x + 120]
        return float(np.median(seen)) < 0.15

    for _ in range(4):
        point(x, y)
        press(F9)
        yield 0.4
        yield from until(is_open, 3.0)
        if is_open():
            return
    raise LostEventError


def confirm_the_file_browser():
    (window, area) = file_browsers()[0]
    with bpy.context.temp_override(window=window, area=area):
        bpy.ops.file.execute()


def files(obj):
    """The window lives while files are written: its timers tick."""
    folder = report.folder / "files"
    # What is there from an earlier play would not be overwritten; and the file browser leaves a
    # folder that does not exist for another one.
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    monkey(view, 3)
    ticks = []

    def tick():
        ticks.append(running() is not None)
        return 0.02

    start("export_field", filepath=str(folder / "thing.obj"), rawfield=True, sing=True)
    yield from until(lambda: bool(file_browsers()))
    confirm_the_file_browser()
    yield 0.1
    found["export_runs_beside"] = running() is not None
    bpy.app.timers.register(tick)
    while running() is not None:
        yield 0.05
    bpy.app.timers.unregister(tick)
    found["ticks_while_exporting"] = sum(ticks)
    found["files"] = sorted(path.name for path in folder.iterdir())
    yield 0.5


play(report.of(scenario))
