"""The pictures of docs/guide.md, taken inside Blender's window; tools/take_screenshots runs it.

blender --python tools/guide_in_window.py -- FOLDER ZIP
"""

import subprocess
import sys
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(REPOSITORY / "tests" / "gui"))

import bpy  # noqa: E402
import numpy as np  # noqa: E402
from hands import View, click, drag, move_window, open_tab, picture, play, point  # noqa: E402
from mathutils import Euler, Vector  # noqa: E402

FOLDER, ZIP = Path(sys.argv[-2]), Path(sys.argv[-1])
view = View()


def shot(name, left=0, top=0, right=1600, bottom=900):
    """The screen, or a part of it, in colours enough for an interface and a shaded surface."""
    path = FOLDER / f"{name}.png"
    picture(path)
    crop = f"{right - left}x{bottom - top}+{left}+{top}"
    command = ["convert", path, "-crop", crop, "+repage", "+dither", "-posterize", "64"]
    packed = ["-strip", "-define", "png:compression-level=9", "-define", "png:compression-filter=5"]
    subprocess.run([*command, *packed, f"PNG24:{path}"], check=True)


def empty():
    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.object.delete()


def look_from(x, z, distance, target=(0.0, 0.0, 0.0)):
    region = view.space.region_3d
    region.view_perspective = "PERSP"
    region.view_rotation = Euler((np.radians(x), 0.0, np.radians(z))).to_quaternion()
    region.view_distance = distance
    region.view_location = target


def monkey():
    with view.inside():
        empty()
        bpy.ops.mesh.primitive_monkey_add(size=4.0)
        obj = bpy.context.object
        obj.modifiers.new("Subdivision", "SUBSURF").levels = 3
        bpy.ops.object.modifier_apply(modifier="Subdivision")
        bpy.ops.object.shade_smooth()
    return obj


def sphere_like(name, shape, noise=0.0, subdivisions=7):
    """An icosphere with its radius, or its points, given by a function of the unit points."""
    with view.inside():
        empty()
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=subdivisions, radius=1.0)
        obj = bpy.context.object
        obj.name = name
        points = np.empty(3 * len(obj.data.vertices), np.float32)
        obj.data.vertices.foreach_get("co", points)
        points = points.reshape(-1, 3)
        points /= np.linalg.norm(points, axis=1, keepdims=True)
        points = shape(points)
        if noise:
            points = points + noise * np.random.default_rng(4).standard_normal(points.shape)
        obj.data.vertices.foreach_set("co", points.astype(np.float32).ravel())
        obj.data.update()
        bpy.ops.object.shade_smooth()
    return obj


def detect():
    with view.inside():
        bpy.ops.umbilics.detect()


def settled():
    """Until the overlay has all its strokes."""
    painter = sys.modules["bl_ext.user_default.umbilics.ui.overlay.painter"]
    yield 1.0
    while painter.is_waiting():
        yield 0.3
    yield 1.0


def tidy():
    """A view with nothing in it that does not help."""
    overlay = view.space.overlay
    overlay.show_floor = overlay.show_axis_x = overlay.show_axis_y = False
    overlay.show_cursor = overlay.show_text = overlay.show_object_origins = False
    overlay.show_outline_selected = False
    look = bpy.context.preferences.addons["bl_ext.user_default.umbilics"].preferences
    look.glyph_size, look.stroke_width = 17.0, 2.0
    overlay.show_extras = False
    shading = view.space.shading
    shading.light = "MATCAP"
    shading.studio_light = "ceramic_dark.exr"
    shading.show_cavity = True


def scenario():
    yield from install()
    yield from open_tab(view)
    tidy()
    yield from first()
    yield from reading()
    yield from maps()
    yield from scan()


def install():
    bpy.ops.screen.userpref_show(section="EXTENSIONS")
    yield 1.0
    move_window("Preferences", 300, 120)
    yield 1.5
    shot("guide/install", 300, 120, 1176, 694)
    with bpy.context.temp_override(window=bpy.context.window_manager.windows[-1]):
        if len(bpy.context.window_manager.windows) > 1:
            bpy.ops.wm.window_close()
    yield 0.5


def first():
    monkey()
    view.space.overlay.show_extras = False
    look_from(78, 24, 7.6, (0.0, 0.0, -0.05))
    yield 1.0
    shot("guide/before", 0, 28, 1320, 820)
    click(*view.in_sidebar(0.5, 120))
    yield 12.0
    bpy.context.scene.umbilics_display.strength = 0.95
    point(*view.middle())
    yield from settled()
    shot("guide/detected", 0, 28, 1320, 820)
    shot("../images/panel", 0, 28, 1320, 820)


def reading():
    """A lemon and a star from above."""
    bpy.context.scene.umbilics_display.empties = False
    bpy.context.scene.umbilics.persistence_auto = True

    def lemons(points):
        return points * (3.0, 2.0, 1.0)

    def stars(points):
        x, y, z = points.T
        return points * (1.0 + 0.12 * (x**3 - 3 * x * y**2) + 0.1 * z**3)[:, None] * 2.0

    for name, shape in (("lemon", lemons), ("star", stars)):
        sphere_like(name.capitalize(), shape)
        detect()
        yield from close_up(name)
        shot(f"guide/{name}", 357, 120, 957, 720)


def close_up(kind):
    """The most persistent umbilic of a kind in the middle of the view, seen from above."""
    mine = bpy.context.object.umbilics
    code = ("star", "lemon", "monstar").index(kind)
    place = next(row for row, item in enumerate(mine.items) if item.kind == code)
    mine.active = place
    region = view.space.region_3d
    region.view_perspective = "PERSP"
    kept = sys.modules["bl_ext.user_default.umbilics.operators.record"]
    position, normal = kept.place_now(
        bpy.context.object, kept.of(bpy.context.object), mine.items[place].row
    )
    region.view_location = position
    region.view_rotation = Vector(normal).to_track_quat("Z", "Y")
    region.view_distance = 1.4
    # Without the ring that marks it in the view.
    mine.active_row = -1
    yield from settled()


def maps():
    bpy.context.scene.umbilics_display.directions = False
    monkey()
    detect()
    look_from(78, 24, 7.6, (0.0, 0.0, -0.05))
    display = bpy.context.scene.umbilics_display
    display.strength = 0.95
    view.space.shading.light = "STUDIO"
    for name in ("gap", "gauss"):
        display.map = name
        with view.inside():
            bpy.ops.umbilics.show_map()
        yield from settled()
        shot(f"guide/map_{name}", 60, 90, 1010, 820)
    with view.inside():
        bpy.ops.umbilics.hide_map()
    tidy()
    display.directions = True


def scan():
    def ellipsoid(points):
        return points * (3.0, 2.0, 1.5)

    sphere_like("Scan", ellipsoid, noise=0.0005)
    group = bpy.context.scene.umbilics
    group.persistence_auto, group.persistence, group.regions = False, 0.0, False
    group.scale_auto, group.scale = False, 3.0
    detect()
    look_from(84, 78, 8.5)
    yield from settled()
    shot("guide/scan_all", 0, 28, 1320, 820)
    yield from drag(view.in_sidebar(0.47, 210), view.in_sidebar(0.9, 210))
    yield from settled()
    shot("guide/scan_thinned", 0, 28, 1320, 820)


play(scenario)
