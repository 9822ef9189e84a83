"""Poles and strokes by hand steer the next plan, which says where they cannot hold."""

import bpy
import numpy as np
import pytest
from scene_building import add_ellipsoid, values


@pytest.fixture
def obj():
    return add_ellipsoid((1.5, 1.0, 0.7), subdivisions=4)


def poles(obj):
    bpy.context.view_layer.update()
    found = [child for child in obj.children if child.get("umbilics_guidance") == "poles"]
    return sorted(found, key=lambda pole: tuple(pole.matrix_world.translation))


def places(obj):
    return np.array([pole.matrix_world.translation for pole in poles(obj)])


def plan(**options):
    assert bpy.ops.umbilics.guide(**options) == {"FINISHED"}


def singular(obj):
    """(k, 3) middles of the faces that the field turns around, as often as it does."""
    index = values(obj, "umbilics_cross_index")
    centres = np.array([polygon.center for polygon in obj.data.polygons])
    return np.repeat(centres, np.rint(4 * np.abs(index)).astype(int), axis=0)


def test_a_moved_pole_bends_the_field_and_stays_until_it_is_freed(obj):
    plan()
    before = places(obj)
    moved = poles(obj)[0]
    moved.location.y += 0.3
    bpy.context.view_layer.update()
    wanted = np.array(moved.matrix_world.translation)
    plan()
    edge = 0.1
    for _ in range(2):
        assert np.linalg.norm(places(obj) - wanted, axis=1).min() < edge
        assert np.linalg.norm(singular(obj) - wanted, axis=1).min() < edge
        assert len(singular(obj)) == len(places(obj)) == 8
        assert obj.umbilics_plan.by_hand and not obj.umbilics_plan.warnings
        assert {pole.origin for pole in obj.umbilics_plan.poles} == {"By Hand"}
        # With other settings too.
        plan(smoothness_auto=False, smoothness=0.8)
    plan(by_hand=False, smoothness_auto=True)
    assert places(obj) == pytest.approx(before, abs=1e-5)
    assert not obj.umbilics_plan.by_hand


def test_an_added_and_a_deleted_pole_whose_sum_cannot_be_are_said(obj, capfd):
    plan()
    bpy.data.objects.remove(poles(obj)[0])
    plan()
    assert len(poles(obj)) == 7
    (said,) = obj.umbilics_plan.warnings.split("\n")
    assert "other poles than planned" in said
    assert said in capfd.readouterr().out
    bpy.context.scene.cursor.location = (3.0, 0.2, 0.1)
    bpy.context.view_layer.objects.active = obj
    assert bpy.ops.umbilics.add_pole(valence="3") == {"FINISHED"}
    bpy.context.view_layer.update()
    (new,) = bpy.context.selected_objects
    assert new["umbilics_valence"] == 3 and new.parent == obj
    place = np.array(new.matrix_world.translation) / (1.5, 1.0, 0.7)
    assert np.linalg.norm(place) == pytest.approx(1.0, abs=0.01)
    plan()
    assert len(poles(obj)) == 8 and not obj.umbilics_plan.warnings
    bpy.ops.umbilics.clear()
    assert not poles(obj)


def test_a_copy_of_a_pole_is_one_more_and_its_valence_counts(obj):
    plan()
    copy = poles(obj)[0].copy()
    poles(obj)[0].users_collection[0].objects.link(copy)
    copy.location.x *= 0.5
    copy["umbilics_valence"] = 5
    plan()
    assert len(poles(obj)) == 9
    assert sorted(pole["umbilics_valence"] for pole in poles(obj)) == [3] * 8 + [5]
    poles(obj)[0]["umbilics_valence"] = 7
    with pytest.raises(RuntimeError, match="a pole has 3 or 5"):
        plan()


def curve(points, kind="POLY", cyclic=False, parent=None):
    data = bpy.data.curves.new("Stroke", "CURVE")
    data.dimensions = "3D"
    data.bevel_depth = 0.05
    spline = data.splines.new(kind)
    held = spline.bezier_points if kind == "BEZIER" else spline.points
    held.add(len(points) - 1)
    for one, place in zip(held, points, strict=True):
        one.co = place if kind == "BEZIER" else (*place, 1.0)
        if kind == "BEZIER":
            one.handle_left_type = one.handle_right_type = "VECTOR"
    spline.use_cyclic_u = cyclic
    made = bpy.data.objects.new("Stroke", data)
    bpy.context.scene.collection.objects.link(made)
    return made


def slanted(count=40):
    """Points on the ellipsoid along a line that turns by 45 degrees against the lines of
    curvature at its middle, on the flank of +z."""
    along = np.linspace(-0.35, 0.35, count)
    x, y = along, along
    z = 0.7 * np.sqrt(1.0 - (x / 1.5) ** 2 - y**2)
    return np.column_stack([x, y, z])


def off(obj):
    """Degrees from the field at the vertex nearest to the top to the diagonal."""
    vertices = np.array([vertex.co for vertex in obj.data.vertices])
    near = np.linalg.norm(vertices - (0.0, 0.0, 0.7), axis=1).argmin()
    x, y, _ = values(obj, "umbilics_cross")[near]
    angle = np.degrees(np.arctan2(y, x)) - 45.0
    return abs((angle + 45.0) % 90.0 - 45.0)


def pencil(points):
    data = getattr(bpy.data, "grease_pencils_v3", bpy.data.grease_pencils).new("Pencil")
    layer = data.layers.new("Mine")
    key = layer.frames.new(1)
    if hasattr(key, "drawing"):
        key.drawing.add_strokes([len(points)])
        flat = np.asarray(points, np.float32).ravel()
        key.drawing.attributes["position"].data.foreach_set("vector", flat)
    else:
        stroke = key.strokes.new()
        stroke.points.add(len(points))
        stroke.points.foreach_set("co", np.asarray(points, np.float32).ravel())
    made = bpy.data.objects.new("Pencil", data)
    bpy.context.scene.collection.objects.link(made)
    return made


@pytest.mark.parametrize("draw", [curve, pencil])
def test_a_stroke_turns_the_field_and_the_plan_knows_when_it_is_another(addon, obj, draw):
    stale = addon.operators.scene.staleness.plan_reasons
    plan()
    assert off(obj) > 40.0
    group = bpy.context.scene.umbilics_guidance
    group.strokes = draw(slanted())
    assert stale(bpy.context, obj) == ["The guide strokes are others."]
    plan()
    assert off(obj) < 5.0
    assert stale(bpy.context, obj) == []
    group.influence = 0.2
    assert stale(bpy.context, obj)
    plan()
    group.strokes.location.x += 0.1
    bpy.context.view_layer.update()
    assert stale(bpy.context, obj)
    group.strokes = None
    plan()
    assert off(obj) > 40.0


def test_what_a_stroke_cannot_hold_is_said(obj):
    scene = bpy.context.scene
    scene.umbilics_guidance.strokes = curve(slanted() + np.array([0.0, 0.0, 50.0]))
    plan()
    # It is nearest to the top of the mesh, but its influence does not reach there.
    assert "too far from the surface" in obj.umbilics_plan.warnings
    scene.umbilics_guidance.strokes = pencil(np.zeros((0, 3)))
    with pytest.raises(RuntimeError, match="no stroke that could guide"):
        plan()


def test_points_of_every_kind_of_stroke(addon):
    drawn = addon.operators.scene.retopology.drawn
    square = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    scene = bpy.context.scene
    ring = curve(square, cyclic=True)
    ring.location = (0.0, 0.0, 2.0)
    both = curve(square, "BEZIER")
    spline = both.data.splines.new("POLY")
    spline.points.add(1)
    spline.points[1].co = (0.0, 0.0, 5.0, 1.0)
    bpy.context.view_layer.update()
    (line,) = drawn.polylines(ring, scene)
    assert line == pytest.approx(np.array([*square, square[0]]) + np.array([0, 0, 2]))
    one, two = drawn.polylines(both, scene)
    assert one[[0, -1]] == pytest.approx(np.array(square)[[0, -1]])
    assert two == pytest.approx(np.array([(0, 0, 0), (0, 0, 5)]))
    assert not bpy.data.objects.get("umbilics strokes")


def test_drawn_guides_are_no_strokes_but_what_is_drawn_over_them_is(addon):
    obj = add_ellipsoid(subdivisions=3)
    bpy.ops.umbilics.draw_guides()
    (guides,) = (child for child in obj.children if child.get("umbilics_guidance") == "guides")
    drawn = addon.operators.scene.retopology.drawn
    assert drawn.polylines(guides, bpy.context.scene) == []
    layer = guides.data.layers.new("Mine")
    key = layer.frames.new(1)
    if hasattr(key, "drawing"):
        key.drawing.add_strokes([2])
    else:
        key.strokes.new().points.add(2)
    assert len(drawn.polylines(guides, bpy.context.scene)) == 1
    layer.hide = True
    assert drawn.polylines(guides, bpy.context.scene) == []


def test_settings_of_a_step_can_be_adjusted_and_the_panel_follows(obj):
    group = bpy.context.scene.umbilics_guidance
    group.smoothness_auto, group.smoothness = False, 0.3
    plan()
    assert group.smoothness == pytest.approx(0.3)
    plan(smoothness=0.7)
    assert group.smoothness == pytest.approx(0.7)
    assert bpy.ops.umbilics.lines(spacing_auto=False, spacing=0.4) == {"FINISHED"}
    assert not group.spacing_auto and group.spacing == pytest.approx(0.4)
    with pytest.raises(TypeError):
        bpy.ops.umbilics.lines(smoothness=0.4)


def quad_poles(obj):
    """Places of the poles of the active quad mesh."""
    valence = values(obj, "umbilics_valence")
    points = np.array([vertex.co for vertex in obj.data.vertices])
    return points[valence > 0]


def remesh(**options):
    done = bpy.ops.umbilics.remesh_to_quads(quads=300, relaxation=5, hide_original=False, **options)
    assert done == {"FINISHED"}
    return bpy.context.view_layer.objects.active


def test_quads_have_the_poles_that_were_moved(obj):
    plan()
    moved = poles(obj)[0]
    moved.location.y += 0.35
    bpy.context.view_layer.update()
    wanted = np.array(moved.matrix_world.translation)
    made = remesh()
    assert np.linalg.norm(quad_poles(made) - wanted, axis=1).min() < 0.2
    kept = made.umbilics_check
    assert (kept.matched, kept.missing, kept.extra) == (8, 0, 0)


def test_the_layout_is_seen_before_the_quads_and_guides_once_it_is_chosen(obj):
    def layout():
        return [child for child in obj.children if child.get("umbilics_guidance") == "layout"]

    assert bpy.ops.umbilics.preview_layout(quads=300) == {"FINISHED"}
    (curve,) = layout()
    ends = np.array([spline.points[at].co[:3] for spline in curve.data.splines for at in (0, -1)])
    points = np.concatenate(
        [[point.co[:3] for point in spline.points] for spline in curve.data.splines]
    )
    level = ((points / np.array((1.5, 1.0, 0.7))) ** 2).sum(axis=1)
    assert np.abs(level - 1.0).max() < 0.05
    made = remesh()
    # Lines begin at the poles of the quads.
    for pole in quad_poles(made):
        assert np.linalg.norm(ends - pole, axis=1).min() < 0.3
    bpy.context.view_layer.objects.active = obj
    bpy.context.scene.umbilics_guidance.strokes = curve
    assert bpy.ops.umbilics.preview_layout(quads=300) == {"FINISHED"}
    # What was chosen may have been edited: it stays, and is the user's.
    assert "umbilics_guidance" not in curve and len(layout()) == 1
    bpy.ops.umbilics.clear()
    assert not layout() and curve.name in bpy.data.objects
