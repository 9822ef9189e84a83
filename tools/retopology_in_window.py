"""Pictures of docs/retopology.md that only a window can give; tools/retopology_pictures.py runs it.

blender --python tools/retopology_in_window.py -- FOLDER
"""

import sys
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(REPOSITORY / "tests" / "gui"), str(REPOSITORY / "tools")]

import bpy  # noqa: E402
from hands import View, click, open_tab, play, point  # noqa: E402
from shot import shot  # noqa: E402
from stage import NAME, monkey, settled  # noqa: E402

FOLDER = Path(sys.argv[-1])
# Headers of sub-panels in pixels below the top of the tab, each once those before it are folded:
# Filters, Map and Overlay are folded, Retopology is opened.
HEADERS = (134, 185, 211, 237)
view = View()


def scenario():
    yield from open_tab(view)
    monkey(view, 3)
    with view.inside():
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
    shot(FOLDER / "retopology-field.png", 0, 28, 1320, 820)


play(scenario)
