"""What is seen is analysed: a monkey under a Subdivision modifier, by mouse; run inside Blender's
window. What is found goes into the JSON file named last on the command line.
"""

import sys
import time
from contextlib import contextmanager
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
sys.path.insert(0, str(Path(__file__).parents[1] / "operators"))

import bpy
import numpy as np
from hands import View, click, insist, open_tab, pixels, play, point, press, until
from stage import REMEDY, Report, clear_scene, in_tab, monkey, part, press_detect, running, settled
from whole_state import differences, everything

report = Report(Path(sys.argv[-1]))
found = report.found
view = View()


def mended():
    """Detect on Blender's cube, and then what the verdict advises."""
    clear_scene(view)
    with view.inside():
        bpy.ops.mesh.primitive_cube_add()
        obj = bpy.context.object
        bpy.ops.ed.undo_push(message="cube")
    yield 1.0

    def judged():
        verdict = part("operators.base.verdict").verdict(obj.umbilics)
        return {"good": verdict.is_good, "remedy": verdict.remedy, "found": verdict.found}

    yield from press_detect(view)
    found["cube"] = judged()
    report.picture("cube")
    yield from insist(lambda: bool(obj.modifiers), in_tab(view, 0.5, REMEDY))
    yield from settled()
    found["modifiers"] = [modifier.type for modifier in obj.modifiers]
    found["mended"] = judged()
    report.picture("mended")
    point(*view.middle())
    press("ctrl+z")
    yield from until(lambda: not bpy.data.objects["Cube"].modifiers, 30.0)
    cube = bpy.data.objects["Cube"]
    found["undone"] = [len(cube.modifiers), cube.umbilics.detected, len(cube.umbilics.items)]


@contextmanager
def detections_that_wait(seconds):
    """Detections that begin no sooner, unless they are stopped: however fast the machine is."""
    core = part("core")
    detect = core.detect

    def later(vertices, triangles, settings, progress, **more):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            progress.ask()
            time.sleep(0.02)
        return detect(vertices, triangles, settings, progress, **more)

    core.detect = later
    try:
        yield
    finally:
        core.detect = detect


def stopped():
    """Esc, by the key, while what was mended is looked at again, and while quads are made."""
    monkey(view, 3)
    obj = bpy.context.object
    # So that merging has something to do.
    with view.inside():
        bpy.ops.object.duplicate()
        obj.select_set(True)
        bpy.ops.object.join()
        bpy.ops.ed.undo_push(message="doubled")
    yield 1.0
    ways = [("mend", {"way": way}) for way in ("SUBDIVIDE", "CREASES", "MERGE", "SMOOTH")]
    found["stopped"] = {}
    for name, given in (*ways, ("remesh_to_quads", {}), ("preview_layout", {}), ("guide", {})):
        before = everything()
        with detections_that_wait(20.0):
            with view.inside():
                getattr(bpy.ops.umbilics, name)("INVOKE_DEFAULT", **given)
            run = running()
            point(*view.middle())
            press("Escape")
            yield from settled()
        left = differences(before, everything())
        found["stopped"][" ".join((name, *given.values()))] = [bool(run and run.cancelled), left]


def cage():
    """Blender's monkey as it is modelled: few faces, and a modifier that makes it smooth."""
    clear_scene(view)
    with view.inside():
        bpy.ops.mesh.primitive_monkey_add(size=4.0)
        obj = bpy.context.object
        obj.modifiers.new("Subdivision", "SUBSURF").levels = 3
        bpy.ops.object.shade_smooth()
        bpy.ops.view3d.view_axis(type="FRONT")
        bpy.ops.view3d.view_selected()
        bpy.ops.ed.undo_push(message="monkey")
    return obj


def coloured(path):
    """Which part of the surface in the middle of the view is not grey."""
    # Where it was framed: in the middle of the whole region, what the sidebar covers included.
    region = view.region("WINDOW")
    x, y = region.x + region.width // 2, view.middle()[1]
    seen = pixels(path)[y - 40 : y + 40, x - 40 : x + 40]
    # By saturation: the dark end of a map, in the shade, is darker than the grey of the surface.
    return float((np.ptp(seen, axis=2) > 0.15 * seen.max(axis=2)).mean())


def state(obj):
    return {
        "active": bpy.context.view_layer.objects.active == obj,
        "hidden": obj.hide_get(),
        "mode": obj.mode,
        "vertices": len(obj.data.vertices),
        "umbilics": len(obj.umbilics.items),
    }


def scenario():
    yield from open_tab(view)
    view.space.overlay.show_cursor = False
    yield from mended()
    yield from stopped()
    obj = cage()
    yield 1.0
    yield from press_detect(view)
    found["detected"] = state(obj)
    found["analysed"] = obj.umbilics.analysed
    report.picture("detected")
    display = bpy.context.scene.umbilics_display
    display.overlay = display.empties = False
    yield 1.0
    found["grey"] = coloured(report.picture("grey"))
    # The colours of this map are none of them grey, as the one of flat places is.
    display.map = "gap"
    with view.inside():
        bpy.ops.umbilics.show_map()
        bpy.ops.ed.undo_push(message="map")
    yield 1.0
    found["mapped"] = coloured(report.picture("mapped"))
    display.overlay = display.empties = True
    click(*view.middle())
    yield 0.8
    found["clicked"] = bpy.context.view_layer.objects.active == obj
    point(*view.middle())
    press("Tab")
    yield 1.0
    yield from press_detect(view)
    found["edited"] = state(obj)
    report.picture("edited")


play(report.of(scenario))
