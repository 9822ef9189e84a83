"""The overlay in every sort of 3D view, the search and the manual; run inside Blender's window.

Whether a glyph is seen is looked up in a picture of the screen, where Blender itself projects the
umbilic to. What is found goes into the JSON file named last on the command line.
"""

import sys
import webbrowser
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import bpy
import numpy as np
from bpy_extras.view3d_utils import location_3d_to_region_2d
from hands import (
    LostEventError,
    View,
    arrange_windows,
    click,
    open_tab,
    pixels,
    place_in,
    play,
    point,
    press,
    until,
    write,
)
from mathutils import Euler, Vector
from stage import DETECT, Report, clear_scene, part, settled

# The code of the key: its name is taken for another one with Ctrl and Alt.
F3 = "69"
# Where Online Manual is in a button's menu, from where the mouse was.
MANUAL = (-80, 23)
# A glyph covers this many pixels around its place, and at least this part of them.
AROUND, COVERED = 3, 0.6
# Below this cosine a glyph is seen from the side, as a line, and is not looked for.
ASLANT = 0.3
# What is behind is not looked for where a glyph in front is as close as this, in pixels.
APART = 18
report = Report(Path(sys.argv[-1]))
found = report.found
view = View()


def ellipsoid(name, place):
    with view.inside():
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=5, location=place)
        obj = bpy.context.object
        obj.name = name
        obj.scale = (3.0, 2.0, 1.0)
        # So that two umbilics face the viewer from the front, the top and the right alike.
        obj.rotation_euler = Vector((1.0, -1.0, 0.8)).to_track_quat("Z", "X").to_euler()
        bpy.ops.object.shade_smooth()
        bpy.ops.umbilics.detect()
    return obj


def umbilics(name):
    """World places and normals of the object's umbilics."""
    obj = bpy.data.objects[name]
    record = part("operators.data.record")
    kept = record.of(obj)
    rows = [item.row for item in obj.umbilics.items]
    return [tuple(map(Vector, record.place_now(obj, kept, row))) for row in rows]


def is_yellow(image, x, y):
    part = image[y - AROUND : y + AROUND + 1, x - AROUND : x + AROUND + 1]
    mask = (part[..., 0] > 0.9) & (part[..., 1] > 0.7) & (part[..., 2] < 0.25)
    return mask.size > 0 and mask.mean() >= COVERED


def look(name, window, objects=("First",)):
    """For each region of the window's 3D view: glyphs that are seen of those in front, and of
    those that the surface hides."""
    image = pixels(report.picture(name))
    seen = []
    for region in (r for r in window.area.regions if r.type == "WINDOW"):
        counts = {"front": 0, "front_seen": 0, "behind": 0, "behind_seen": 0}
        left, top = place_in(window.window, region.x, window.window.height - region.y)
        sides = projected(region, objects)
        for side, places in sides.items():
            for x, y in places:
                others = () if side == "front" else sides["front"]
                if any(np.hypot(x - a, y - b) < APART for a, b in others):
                    continue
                counts[side] += 1
                counts[f"{side}_seen"] += bool(is_yellow(image, left + int(x), top - int(y)))
        seen.append(counts)
    found[name] = seen


def projected(region, objects):
    """Pixels in the region of the umbilics in front and of those behind."""
    sides = {"front": [], "behind": []}
    for place, normal in (item for name in objects for item in umbilics(name)):
        flat = location_3d_to_region_2d(region, region.data, place)
        towards = region.data.view_rotation @ Vector((0.0, 0.0, 1.0))
        if region.data.is_perspective:
            towards = region.data.view_matrix.inverted().translation - place
        facing = normal.dot(towards.normalized())
        if abs(facing) >= ASLANT:
            sides["front" if facing > 0.0 else "behind"].append(flat)
    return sides


def scenario():
    clear_scene(view)
    display = bpy.context.scene.umbilics_display
    display.empties = display.directions = display.rays = False
    ellipsoid("Second", (0.0, 9.0, 0.0))
    ellipsoid("First", (0.0, 0.0, 0.0))
    region = view.space.region_3d
    region.view_rotation = Euler((1.0, 0.1, 0.6)).to_quaternion()
    region.view_location, region.view_distance = (0.0, 0.0, 0.0), 14.0
    view.space.overlay.show_relationship_lines = False
    yield 2.0
    yield from shadings()
    yield from local()
    yield from quad()
    yield from searched()
    yield from manual()
    yield from windows()


def keys(*names):
    point(*view.middle())
    press(*names)
    yield from settled()


def shadings():
    look("solid", view)
    yield from keys("alt+z")
    found["xray_on"] = view.space.shading.show_xray
    look("xray", view)
    yield from keys("alt+z")
    look("xray_off", view)


def local():
    """Alone, the first object is seen with its glyphs, and the other one's are gone."""
    with view.inside():
        bpy.ops.view3d.view_all()
    yield 1.0
    look("both", view, ("First", "Second"))
    yield from keys("slash")
    found["local"] = view.space.local_view is not None
    look("local_first", view, ("First",))
    look("local_second", view, ("Second",))
    yield from keys("slash")
    look("global", view, ("First", "Second"))


def quad():
    yield from keys("ctrl+alt+q")
    look("quad", view)
    yield from keys("alt+z")
    look("quad_xray", view)
    yield from keys("alt+z")
    yield from keys("ctrl+alt+q")
    found["regions_after_quad"] = len([r for r in view.area.regions if r.type == "WINDOW"])


def searched():
    """F3 and the word; Return runs what is on top."""
    obj = bpy.data.objects["First"]
    yield from keys(F3)
    write("umbilic")
    yield 1.0
    report.picture("search")
    press("Escape", "Escape")
    yield 1.0
    before = obj.umbilics.stamp
    yield from keys(F3)
    write("detect umbilics")
    yield 1.0
    press("Return")
    yield from until(lambda: obj.umbilics.stamp != before)
    found["search_detects"] = obj.umbilics.stamp != before
    yield 1.0


def manual():
    """Right click on a button, Online Manual; and what a number of the statistics opens."""
    opened = []
    webbrowser.open = lambda url, *_, **__: opened.append(url)
    yield from open_tab(view)
    place = view.in_sidebar(0.5, DETECT)
    click(*place, button=3)
    yield 1.0
    report.picture("menu")
    click(place[0] + MANUAL[0], place[1] + MANUAL[1])
    yield from until(lambda: bool(opened), 10.0)
    if not opened:
        raise LostEventError("Online Manual was not chosen")
    found["manual"] = list(opened)
    opened.clear()
    with view.inside():
        bpy.ops.umbilics.explain(number="noise")
    yield 1.0
    found["explained"] = list(opened)
    view.space.show_region_ui = False
    yield 0.5


def windows():
    """Beside each other, each with a view of its own from another side."""
    bpy.ops.wm.window_new_main()
    yield 2.0
    arrange_windows()
    yield 3.0
    other = View(1)
    region = other.space.region_3d
    region.view_rotation = Vector((-1.0, 1.0, -0.4)).to_track_quat("Z", "Y")
    for each in (view, other):
        each.space.region_3d.view_location = (0.0, 0.0, 0.0)
        each.space.region_3d.view_distance = 20.0
        each.area.tag_redraw()
    yield 2.0
    look("window_first", view)
    look("window_second", other)
    # A change in one is seen in both.
    bpy.context.scene.umbilics_display.glyphs = False
    yield 2.0
    look("window_first_off", view)
    look("window_second_off", other)
    bpy.context.scene.umbilics_display.glyphs = True
    with bpy.context.temp_override(window=other.window):
        bpy.ops.wm.window_close()
    yield 1.0
    look("window_closed", view)


play(report.of(scenario))
