"""How the window of a Blender with the installed extension keeps up with a large mesh.

    tools/window --python benchmarks/window_speed_in_blender.py -- LEVEL REPORT.json

The mesh is an ellipsoid with a little noise, so that there are many umbilics to filter. Times are
those of Blender's own loop: a timer that is due every few milliseconds sees each time how long it
was kept waiting, and a draw handler sees when the 3D view was drawn.
"""

import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "gui"))

import bpy
import numpy as np
from hands import View, play
from mathutils import Quaternion
from stage import Report, clear_scene, part, running

AXES, NOISE = (3.0, 2.0, 1.0), 1e-4
TICK = 0.005
FRAMES, STEPS = 6, 12
AWAY = 1000.0
STEP = Quaternion((0.0, 0.0, 1.0), 0.05)

view = View()
drawn = []
report = Report(Path(sys.argv[-1]))
found = report.found


def ellipsoid(level):
    """Blender's icosphere (whose levels count from 1), stretched, with noise along its normals."""
    clear_scene(view)
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=level + 1, radius=1.0)
    obj = bpy.context.object
    position = obj.data.attributes["position"].data
    points = np.empty(3 * len(position), np.float32)
    position.foreach_get("vector", points)
    points = points.reshape(-1, 3)
    bumps = 1.0 + NOISE * np.random.default_rng(1).standard_normal(len(points))
    points *= np.float32(AXES) * bumps[:, None].astype(np.float32)
    position.foreach_set("vector", points.ravel())
    obj.data.update()
    found["triangles"] = len(obj.data.polygons)
    return obj


def look(away):
    """At the mesh, or past it."""
    region = view.space.region_3d
    region.view_location = (AWAY, 0.0, 0.0) if away else (0.0, 0.0, 0.0)
    region.view_distance = 9.0


def waits(busy):
    """Let Blender run on while `busy()`; how long each round of its loop took, and its draws."""
    times, start = [time.perf_counter()], len(drawn)
    while busy():
        yield TICK
        times.append(time.perf_counter())
    return np.diff(times), len(drawn) - start


def settled():
    """Until nothing has been drawn for a while."""
    count = -1
    while count != len(drawn):
        count = len(drawn)
        yield 3.0


def detection(name, away):
    """Longest round of the loop while detecting, and the one in which results are written."""
    look(away)
    yield from settled()
    begin = time.perf_counter()
    with view.inside():
        bpy.ops.umbilics.detect("INVOKE_DEFAULT")
    reading = time.perf_counter() - begin
    rounds, draws = yield from waits(lambda: running() is not None)
    # The last round is the one that ends the run and writes.
    found[f"detect_{name}"] = {
        "seconds": time.perf_counter() - begin,
        "reading": reading,
        "longest": float(rounds[:-1].max()),
        "writing": float(rounds[-1]),
        "draws": draws,
    }
    yield from settled()


def frames(count, change):
    """Seconds from a change until Blender has drawn the 3D view after it, the median."""
    seconds = []
    for number in range(count):
        before, begin = len(drawn), time.perf_counter()
        change(number)
        view.area.tag_redraw()
        while len(drawn) == before:
            yield 0.001
        seconds.append(time.perf_counter() - begin)
    return float(np.median(seconds[1:]))


def turn(number):
    view.space.region_3d.view_rotation = view.space.region_3d.view_rotation @ STEP


def scenario():
    display = bpy.context.scene.umbilics_display
    group = bpy.context.scene.umbilics
    bpy.types.SpaceView3D.draw_handler_add(
        lambda: drawn.append(time.perf_counter()), (), "WINDOW", "POST_PIXEL"
    )
    # A reach that leaves some of the noise in, for thousands of umbilics to filter.
    group.scale_auto, group.scale, group.regions = False, 2.0, False
    obj = ellipsoid(int(sys.argv[-2]))
    view.space.show_region_ui = True
    yield 2.0
    view.region("UI").active_panel_category = "Umbilics"
    yield 2.0
    yield from detection("away", away=True)
    yield from detection("seen", away=False)
    found["candidates"] = obj.umbilics.candidates
    group.persistence_auto = False
    # Part of the work is done when the overlay is drawn next.
    painter = part("ui.overlay.painter")
    original, built = painter._drawn_umbilics, []

    def timed(*arguments):
        begin = time.perf_counter()
        try:
            return original(*arguments)
        finally:
            if built:
                built[-1] += time.perf_counter() - begin

    painter._drawn_umbilics = timed
    strengths = np.linspace(0.3, 1.0, STEPS)
    work, shown = [], []

    def drag(number):
        built.append(0.0)
        begin = time.perf_counter()
        display.strength = float(strengths[number])
        work.append(time.perf_counter() - begin)
        shown.append(len(obj.umbilics.items) + obj.umbilics.hidden_items)

    for name, away, overlay in (
        ("seen, no overlay", False, False),
        ("seen, overlay", False, True),
        ("away, no overlay", True, False),
        ("away, overlay", True, True),
    ):
        display.strength, display.overlay = 0.3, overlay
        look(away)
        yield from settled()
        turning = yield from frames(FRAMES, turn)
        work.clear()
        shown.clear()
        built.clear()
        dragging = yield from frames(STEPS, drag)
        found[name] = {
            "orbit": turning,
            "drag": dragging,
            "filtering": list(work),
            "building": list(built),
            "shown": list(shown),
        }


play(report.of(scenario), smooth=True)
