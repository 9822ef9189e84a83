"""Pictures of docs/retopology.md that only a window can give; tools/retopology_pictures.py runs it.

blender --python tools/retopology_in_window.py -- FOLDER [SPOT]

The pictures of quads show Spot; without its file they stay as they are.
"""

import sys
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(REPOSITORY / name) for name in ("tests/gui", "tests", "tools")]

import bpy  # noqa: E402
from hands import View, click, open_tab, play, point  # noqa: E402
from mesh_files import read_mesh  # noqa: E402
from shot import shot  # noqa: E402
from stage import NAME, clear_scene, monkey, settled  # noqa: E402

FOLDER, *SPOT = map(Path, sys.argv[sys.argv.index("--") + 1 :])
VIEW = (0, 28, 1020, 812)
QUADS = 1500
# Headers of sub-panels in pixels below the top of the tab, each once those before it are folded:
# Filters, Map and Overlay are folded, Retopology is opened.
HEADERS = (162, 213, 239, 265)
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
    if SPOT:
        yield from quads(*SPOT)


def quads(path):
    """Layout, quads with the marks of their check, and the map of its angles."""
    clear_scene(view)
    vertices, triangles = read_mesh(path)
    with view.inside():
        mesh = bpy.data.meshes.new("Spot")
        mesh.from_pydata(vertices[:, [0, 2, 1]] * (1, -1, 1), [], triangles.tolist())
        obj = bpy.data.objects.new("Spot", mesh)
        bpy.context.collection.objects.link(obj)
        bpy.context.view_layer.objects.active = obj
        obj.select_set(True)
        bpy.ops.object.shade_smooth()
        bpy.ops.view3d.view_axis(type="RIGHT")
        bpy.ops.view3d.view_selected()
        bpy.ops.umbilics.preview_layout(quads=QUADS)
    yield from settled()
    shot(FOLDER / "retopology-layout.png", *VIEW)
    with view.inside():
        bpy.ops.umbilics.clear()
        bpy.ops.umbilics.remesh_to_quads(quads=QUADS)
        # A plan that others could have been made from shows all kinds of marks.
        bpy.context.object.umbilics_check.own_plan = False
        bpy.ops.umbilics.check_topology()
        view.space.overlay.show_wireframes = True
    yield from settled()
    shot(FOLDER / "retopology-quads.png", *VIEW)
    with view.inside():
        bpy.ops.umbilics.show_check()
    yield from settled()
    shot(FOLDER / "retopology-check.png", *VIEW)


play(scenario, smooth=True)
