"""What a new user does in the first hour, by mouse and keys; run inside Blender's window.

Everything that is found goes into the JSON file named last on the command line, the pictures
beside it. tests/gui/test_window.py reads them.
"""

import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import bpy
from hands import (
    PATIENCE,
    View,
    click,
    draw_smoothly,
    insist,
    insist_on_drag,
    open_tab,
    pixels,
    play,
    point,
    press,
    until,
)
from stage import (
    DETECT,
    FIRST_ROW,
    NAME,
    ROW,
    SHOW_MAP,
    STRENGTH,
    Report,
    bring_in_sight,
    in_tab,
    monkey,
    press_detect,
    running,
    settled,
)

report = Report(Path(sys.argv[-1]))
found = report.found
view = View()


def yellow(path):
    """Pixels of the 3D view in the colour of lemons."""
    region = view.region("WINDOW")
    top = view.window.height - region.y - region.height
    seen = pixels(path)[top + 60 : top + region.height, region.x : region.x + 900]
    return int(((seen[..., 0] > 0.9) & (seen[..., 1] > 0.72) & (seen[..., 2] < 0.2)).sum())


def state():
    """All that a detection could change."""
    return {
        "objects": sorted(obj.name for obj in bpy.data.objects),
        "collections": sorted(item.name for item in bpy.data.collections),
        "images": sorted(item.name for item in bpy.data.images),
        "attributes": {m.name: sorted(a.name for a in m.attributes) for m in bpy.data.meshes},
        "properties": {obj.name: sorted(obj.keys()) for obj in bpy.data.objects},
        "hidden": [obj.name for obj in bpy.context.view_layer.objects if obj.hide_get()],
        "detected": [obj.name for obj in bpy.data.objects if obj.umbilics.detected],
        "handlers": {
            name: len(getattr(bpy.app.handlers, name))
            for name in ("depsgraph_update_post", "undo_post", "redo_post", "load_post")
        },
    }


def shown():
    return len(bpy.data.objects["Suzanne"].umbilics.items)


def scenario():
    region = view.region("UI")
    found["sidebar"] = [region.x, region.y, region.width, region.height, view.window.height]
    yield from open_tab(view)
    yield from escape()
    yield from detection()
    yield from slider()
    yield from undo_and_redo()
    yield from listed()
    yield from mapped()
    yield from reload()
    yield from disabled()


def escape():
    """Esc at several moments, with two objects, one of which would get a copy for its results."""
    first = monkey(view, 4)
    with view.inside():
        bpy.ops.mesh.primitive_monkey_add(size=2.0, location=(4.0, 0.0, 0.0))
        bpy.context.object.modifiers.new("Subdivision", "SUBSURF").levels = 4
        first.select_set(True)
        bpy.context.scene.umbilics_display.source = "EVALUATED"
    yield 3.0
    found["escapes"] = []
    for moment in (0.0, 0.3, 0.5, 0.7):
        before = state()
        click(*view.in_sidebar(0.5, DETECT))
        end = time.monotonic() + PATIENCE
        while running() is None and time.monotonic() < end:
            yield 0.05
        run = running()
        found["detect_button_starts_a_run"] = run is not None
        point(*view.middle())
        while run is not None and not run.finished and run.fraction < moment:
            yield 0.02
        reached = run.stage if run else ""
        press("Escape")
        yield from settled(0.6)
        cancelled = bool(run and run.cancelled)
        found["escapes"].append([moment, reached, cancelled, state() == before])
        yield 0.5
    bpy.context.scene.umbilics_display.source = "BASE"


def detection():
    monkey(view, 2)
    yield 0.5
    yield from press_detect(view)
    found["detected"] = bpy.context.object.umbilics.detected
    found["candidates"] = bpy.context.object.umbilics.candidates
    found["glyph_pixels"] = yellow(report.picture("detected"))


def slider():
    before = shown()
    left = in_tab(view, 0.45, STRENGTH)
    right = in_tab(view, 0.93, STRENGTH)
    display = bpy.context.scene.umbilics_display
    strength = found["strength_before"] = display.strength
    found["shown_before"] = before
    yield from insist_on_drag(lambda: display.strength > strength, left, right)
    yield from until(lambda: shown() < before, 30.0)
    report.picture("dragged")
    found["strength_after"] = display.strength
    found["shown_after"] = shown()


def undo_and_redo():
    point(*view.middle())
    thinned = shown()
    press("ctrl+z")
    yield from until(lambda: shown() != thinned, 30.0)
    found["shown_after_undo"] = shown()
    press("ctrl+z")
    yield from until(lambda: not bpy.data.objects["Suzanne"].umbilics.detected, 30.0)
    found["detected_after_two_undos"] = bpy.data.objects["Suzanne"].umbilics.detected
    press("ctrl+shift+z")
    yield from until(lambda: shown() == found["shown_before"], 30.0)
    press("ctrl+shift+z")
    yield from until(lambda: shown() == thinned, 30.0)
    found["shown_after_redo"] = shown()


def listed():
    mine = bpy.data.objects["Suzanne"].umbilics

    def selected():
        row = mine.items[mine.active].row
        return any(o.get("umbilics_row") == row and o.select_get() for o in bpy.data.objects)

    yield from insist(selected, in_tab(view, 0.3, FIRST_ROW + ROW))
    found["list_click_selects"] = selected()
    distance = view.space.region_3d.view_distance

    def framed():
        return view.space.region_3d.view_distance < distance

    yield from insist(framed, in_tab(view, 0.3, FIRST_ROW), count=2)
    found["double_click_frames"] = framed()
    report.picture("framed")
    with view.inside():
        bpy.ops.view3d.view_axis(type="FRONT")
        bpy.ops.view3d.view_all()


def mapped():
    before = view.space.shading.color_type, view.space.shading.type
    found["shading_before"] = before
    mesh = bpy.data.objects["Suzanne"].data
    with view.inside():
        bpy.ops.view3d.view_all()
    yield from bring_in_sight(view, SHOW_MAP[1])
    yield from insist(lambda: "umbilics_map" in mesh.color_attributes, in_tab(view, *SHOW_MAP))
    found["map_by_button"] = "umbilics_map" in mesh.color_attributes
    found["shading_with_map"] = view.space.shading.color_type
    report.picture("map")
    if found["map_by_button"]:
        with view.inside():
            bpy.ops.umbilics.hide_map()
    yield 0.3
    found["shading_after"] = view.space.shading.color_type, view.space.shading.type


def reload():
    path = str(report.folder / "saved.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    found["saved_shown"] = shown()
    point(*view.middle())
    press("ctrl+s")
    yield 0.5
    bpy.ops.wm.open_mainfile(filepath=path)
    yield 1.0
    found["reloaded_shown"] = shown()
    bpy.context.scene.umbilics_display.strength = 0.0
    yield 0.5
    found["reloaded_all"] = shown()
    found["reloaded_pixels"] = yellow(report.picture("reloaded"))
    draw_smoothly(True)
    view.area.tag_redraw()
    yield 1.0
    found["smooth_pixels"] = yellow(report.picture("smooth"))
    draw_smoothly(False)
    yield 0.5


def disabled():
    bpy.ops.preferences.addon_disable(module=NAME)
    yield 0.6
    found["disabled_pixels"] = yellow(report.picture("disabled"))
    ours = [name for name in dir(bpy.types) if name.startswith("UMBILICS_")]
    found["residue"] = ours + [
        handler.__module__
        for name in ("depsgraph_update_post", "undo_post", "redo_post", "load_post")
        for handler in getattr(bpy.app.handlers, name)
        if handler.__module__.startswith(NAME)
    ]
    bpy.ops.preferences.addon_enable(module=NAME)
    yield 0.6
    found["enabled_pixels"] = yellow(report.picture("enabled"))


play(report.of(scenario))
