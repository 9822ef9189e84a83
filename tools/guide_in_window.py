"""The pictures of docs/guide.md, taken inside Blender's window; tools/take_screenshots runs it.

blender --python tools/guide_in_window.py -- FOLDER ZIP [MESH]

It begins without the extension, which is installed as a user does. MESH is the scan of the guide's
first chapters; without it their pictures stay as they are.
"""

import sys
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(REPOSITORY / "tests" / "gui"), str(REPOSITORY / "tools")]

import bpy  # noqa: E402
import numpy as np  # noqa: E402
from hands import View, click, drag, open_tab, play, point  # noqa: E402
from mathutils import Euler, Vector  # noqa: E402
from new_user import NewUser  # noqa: E402
from shot import shot  # noqa: E402
from stage import FIRST_ROW, NAME, ROW, STRENGTH, clear_scene, in_tab, monkey, part, settled  # noqa: E402

FOLDER, ZIP, *MESH = map(Path, sys.argv[sys.argv.index("--") + 1 :])
# The preferences on the screen, and the 3D view with its sidebar.
PREFERENCES, VIEW = (300, 120, 1176, 694), (0, 28, 1320, 820)
view = View()


def look_from(x, z, distance, target=(0.0, 0.0, 0.0)):
    region = view.space.region_3d
    region.view_perspective = "PERSP"
    region.view_rotation = Euler((np.radians(x), 0.0, np.radians(z))).to_quaternion()
    region.view_distance = distance
    region.view_location = target


def sphere_like(name, shape, noise=0.0, subdivisions=7):
    """An icosphere with its radius, or its points, given by a function of the unit points."""
    clear_scene(view)
    with view.inside():
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


def tidy():
    """A view with nothing in it that does not help."""
    overlay = view.space.overlay
    overlay.show_floor = overlay.show_axis_x = overlay.show_axis_y = False
    overlay.show_cursor = overlay.show_text = overlay.show_object_origins = False
    overlay.show_outline_selected = overlay.show_relationship_lines = False
    look = bpy.context.preferences.addons[NAME].preferences
    look.glyph_size, look.stroke_width = 17.0, 2.0
    overlay.show_extras = False
    shading = view.space.shading
    shading.light = "MATCAP"
    shading.studio_light = "ceramic_dark.exr"
    shading.show_cavity = True


def scenario():
    user = NewUser(of_path, {})
    yield from user.install(ZIP)
    if MESH:
        yield from user.import_mesh(MESH[0])
        yield from scanned(user)
    yield from open_tab(view)
    tidy()
    yield from panel()
    yield from reading()
    yield from maps()
    yield from scan()


def picture(name, *place):
    shot(FOLDER / f"{name}.png", *place)


# What is shown of the new user's path.
PATH = {
    "install_from_disk": PREFERENCES,
    "installed": PREFERENCES,
    "before": VIEW,
    "detected": VIEW,
    "thinned": VIEW,
    "map": VIEW,
}


def of_path(name):
    if name in PATH:
        picture(f"guide/{name}", *PATH[name])


def scanned(user):
    """The path from the button to the map and back, with a scan."""
    tidy()
    with view.inside():
        bpy.ops.object.shade_smooth()
    obj = user.mesh
    middle = sum((obj.matrix_world @ Vector(corner) for corner in obj.bound_box), Vector()) / 8.0
    look_from(80, 14, 2.05 * max(obj.dimensions), middle + Vector((0.02, 0.0, -0.002)))
    yield from user.detect()
    yield from user.thin_out()
    yield from framed(user)
    look_from(80, 14, 2.05 * max(obj.dimensions), middle + Vector((0.02, 0.0, -0.002)))
    view.space.shading.light = "STUDIO"
    # The colours are the subject here.
    bpy.context.scene.umbilics_display.directions = False
    yield from user.show_map()
    yield from user.undo_all()
    bpy.context.scene.umbilics_display.directions = True


def framed(user):
    """Double click the first row of the list whose umbilic is on this side."""
    kept = part("operators.data.record")
    obj, items = user.mesh, user.mesh.umbilics.items
    towards = view.space.region_3d.view_rotation @ Vector((0.0, 0.0, 1.0))
    rows = [item.row for item in sorted(items, key=lambda item: -item.persistence)[:5]]
    normals = [Vector(kept.place_now(obj, kept.of(obj), row)[1]) for row in rows]
    place = next((at for at, normal in enumerate(normals) if towards.dot(normal) > 0.5), 0)
    click(*in_tab(view, 0.3, FIRST_ROW + place * ROW), count=2)
    yield 2.0
    point(*view.middle())
    yield from settled()
    picture("guide/chosen", *VIEW)


def panel():
    """The picture of the README."""
    monkey(view, 3)
    look_from(78, 24, 7.6, (0.0, 0.0, -0.05))
    yield 1.0
    detect()
    bpy.context.scene.umbilics_display.strength = 0.95
    point(*view.middle())
    yield from settled()
    picture("../images/panel", *VIEW)


def reading():
    """A lemon and a star from above."""
    bpy.context.scene.umbilics_display.empties = False
    bpy.context.scene.umbilics.persistence_auto = True

    def lemons(points):
        return points * (3.0, 2.0, 1.0)

    def stars(points):
        x, y, z = points.T
        return points * (1.0 + 0.12 * (x**3 - 3 * x * y**2) + 0.1 * z**3)[:, None] * 2.0

    # A corner of the gizmo would stick into the square that is cut out.
    view.space.show_gizmo = False
    for name, shape in (("lemon", lemons), ("star", stars)):
        sphere_like(name.capitalize(), shape)
        detect()
        yield from close_up(name)
        picture(f"guide/{name}", 357, 120, 957, 720)
    view.space.show_gizmo = True


def close_up(kind):
    """The most persistent umbilic of a kind in the middle of the view, seen from above."""
    mine = bpy.context.object.umbilics
    code = ("star", "lemon", "monstar").index(kind)
    place = next(row for row, item in enumerate(mine.items) if item.kind == code)
    mine.active = place
    region = view.space.region_3d
    region.view_perspective = "PERSP"
    kept = part("operators.data.record")
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
    monkey(view, 3)
    detect()
    look_from(78, 24, 7.6, (0.0, 0.0, -0.05))
    display = bpy.context.scene.umbilics_display
    display.strength = 0.95
    view.space.shading.light = "STUDIO"
    for name in ("k1", "gauss"):
        display.map = name
        with view.inside():
            bpy.ops.umbilics.show_map()
        yield from settled()
        picture(f"guide/map_{name}", 60, 90, 1030, 806)
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
    picture("guide/scan_all", *VIEW)
    yield from drag(in_tab(view, 0.45, STRENGTH), in_tab(view, 1.12, STRENGTH))
    point(*view.middle())
    yield from settled()
    picture("guide/scan_thinned", *VIEW)


play(scenario, smooth=True)
