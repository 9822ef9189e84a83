"""Pictures of docs/retopology.md that only a window can give; tools/retopology_pictures.py runs it.

blender --python tools/retopology_in_window.py -- FOLDER
"""

import subprocess
import sys
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(REPOSITORY / "tests" / "gui"))

import bpy  # noqa: E402
from hands import View, click, open_tab, picture, play, point  # noqa: E402

FOLDER = Path(sys.argv[-1])
NAME = "bl_ext.user_default.umbilics"
# Headers of sub-panels in pixels below the top of the tab, each once those before it are folded:
# Filters, Map and Overlay are folded, Retopology is opened.
HEADERS = (180, 231, 257, 283)
view = View()


def shot(name, left, top, right, bottom):
    path = FOLDER / f"{name}.png"
    picture(path)
    crop = f"{right - left}x{bottom - top}+{left}+{top}"
    command = ["convert", path, "-crop", crop, "+repage", "+dither", "-posterize", "64"]
    packed = ["-strip", "-define", "png:compression-level=9", "-define", "png:compression-filter=5"]
    subprocess.run([*command, *packed, f"PNG24:{path}"], check=True)


def settled():
    painter = sys.modules[f"{NAME}.ui.overlay.painter"]
    yield 1.0
    while sys.modules[f"{NAME}.operators.running"].current() or painter.is_waiting():
        yield 0.3
    yield 1.0


def scenario():
    yield from open_tab(view)
    with view.inside():
        bpy.ops.object.select_all(action="SELECT")
        bpy.ops.object.delete()
        bpy.ops.mesh.primitive_monkey_add(size=4.0)
        bpy.context.object.modifiers.new("Subdivision", "SUBSURF").levels = 3
        bpy.ops.object.modifier_apply(modifier="Subdivision")
        bpy.ops.object.shade_smooth()
        bpy.ops.view3d.view_axis(type="FRONT")
        bpy.ops.view3d.view_selected()
        bpy.ops.umbilics.guide()
    bpy.context.preferences.addons[NAME].preferences.stroke_width = 2.0
    overlay = view.space.overlay
    overlay.show_floor = overlay.show_axis_x = overlay.show_axis_y = False
    overlay.show_cursor = overlay.show_text = overlay.show_outline_selected = False
    view.space.region_3d.view_distance *= 0.62
    bpy.context.scene.umbilics_display.field = "CROSS"
    view.space.shading.light = "MATCAP"
    view.space.shading.studio_light = "ceramic_dark.exr"
    yield 1.0
    for header in HEADERS:
        click(*view.in_sidebar(0.4, header))
        yield 1.5
    point(*view.middle())
    yield from settled()
    shot("retopology-field", 0, 28, 1320, 820)


play(scenario)
