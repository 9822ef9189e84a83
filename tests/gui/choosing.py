"""A plan in view, and glyphs chosen by mouse; run inside Blender's window.

What is found goes into the JSON file named last on the command line, the pictures beside it.
tests/gui/test_choosing.py reads them.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import bpy
from bpy_extras import view3d_utils
from hands import View, click, insist, open_tab, play, point
from stage import Report, part, settled

report = Report(Path(sys.argv[-1]))
found = report.found
view = View()


def ellipsoid():
    with view.inside():
        bpy.ops.object.select_all(action="SELECT")
        bpy.ops.object.delete()
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=5)
        obj = bpy.context.object
        obj.scale = (3.0, 2.0, 1.0)
        bpy.ops.object.transform_apply(scale=True)
        bpy.ops.object.shade_smooth()
        bpy.ops.view3d.view_axis(type="TOP")
        bpy.ops.view3d.view_selected()
        bpy.ops.ed.undo_push(message="ellipsoid")
    return obj


def on_screen(place):
    """Screen pixels of a place in the world."""
    region = view.region("WINDOW")
    at = view3d_utils.location_3d_to_region_2d(region, view.space.region_3d, place)
    return round(region.x + at.x), round(view.window.height - region.y - at.y)


def shown(obj):
    """Places and rows of the umbilics that face the viewer, by the number in the list."""
    kept = part("operators.data.record").of(obj)
    candidates = kept.detection.candidates
    rows = [item.row for item in obj.umbilics.items]
    return {row: candidates.position[row] for row in rows if candidates.normal[row, 2] > 0.3}


def scenario():
    display = bpy.context.scene.umbilics_display
    yield from open_tab(view)
    obj = ellipsoid()
    found["dashed_before"] = view.space.overlay.show_relationship_lines
    with view.inside():
        bpy.ops.umbilics.detect("INVOKE_DEFAULT")
    yield from settled()
    found["dashed_with_results"] = view.space.overlay.show_relationship_lines
    display.empties = False
    yield 1.0
    for row, place in shown(obj).items():
        yield from insist(lambda row=row: obj.umbilics.active_row == row, on_screen(place))
        active = obj.umbilics.active
        found.setdefault("picked", []).append([row, obj.umbilics.active_row, active])
        found.setdefault("kept_active", []).append(bpy.context.view_layer.objects.active == obj)
    report.picture("picked")
    click(*on_screen((0.0, 0.0, 1.0)))
    yield 1.0
    found["beside"] = bpy.context.view_layer.objects.active == obj
    display.empties = True
    with view.inside():
        bpy.ops.umbilics.guide("INVOKE_DEFAULT")
    yield from settled()
    found["field"] = display.field
    found["types"] = sorted(
        {child.empty_display_type for child in obj.children if "umbilics_valence" in child}
    )
    display.numbers = True
    point(*view.middle())
    yield 1.0
    report.picture("plan")
    poles = [child for child in obj.children if "umbilics_valence" in child]
    pole = next(one for one in poles if one.matrix_world.translation.z > 0.2)
    plan = obj.umbilics_plan
    yield from insist(lambda: plan.active >= 0, on_screen(pole.matrix_world.translation))
    chosen = plan.poles[plan.active].name if plan.active >= 0 else ""
    found["pole"] = [pole.name, chosen, pole.select_get()]
    with view.inside():
        bpy.ops.umbilics.lines("INVOKE_DEFAULT")
    yield from settled()
    display.directions = False
    yield 1.0
    report.picture("lines")
    found["lines_render"] = [child.hide_render for child in obj.children if child.type == "CURVE"]
    with view.inside():
        bpy.context.view_layer.objects.active = obj
        bpy.ops.umbilics.clear()
    yield 0.5
    found["dashed_after"] = view.space.overlay.show_relationship_lines


play(report.of(scenario))
