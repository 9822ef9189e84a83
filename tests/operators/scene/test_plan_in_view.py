"""How a plan is seen: colours in Solid view, nothing in renders, dashed lines off, crosses."""

import bpy
import pytest
from scene_building import add_ellipsoid


@pytest.fixture
def obj():
    return add_ellipsoid(subdivisions=4)


def parts(obj, kind):
    return [child for child in obj.children if child.get("umbilics_guidance") == kind]


def test_families_are_red_and_blue_in_solid_view(obj):
    bpy.ops.umbilics.lines()
    larger, smaller = sorted(parts(obj, "lines"), key=lambda one: one["umbilics_family"])
    for curve, strongest in ((larger, 0), (smaller, 2)):
        colour = curve.data.materials[0].diffuse_color[:3]
        assert max(range(3), key=lambda channel: colour[channel]) == strongest
        assert tuple(curve.color[:3]) == pytest.approx(tuple(colour))


def test_nothing_of_a_plan_is_rendered(obj):
    for make in ("guide", "lines", "separatrices", "ridges", "symmetry", "draw_guides"):
        getattr(bpy.ops.umbilics, make)()
    made = [child for child in obj.children if "umbilics_guidance" in child]
    assert {child["umbilics_guidance"] for child in made} >= {"poles", "lines", "guides", "mirror"}
    assert all(child.hide_render for child in made)
    assert not obj.hide_render


def test_materials_go_with_their_lines_and_one_of_the_users_stays(obj):
    bpy.ops.umbilics.lines()
    larger, smaller = parts(obj, "lines")
    larger.data.materials[0] = bpy.data.materials.new("Mine")
    ours = smaller.data.materials[0].name
    for _ in range(2):
        bpy.ops.umbilics.lines()
    assert len(bpy.data.materials) == 4
    bpy.ops.umbilics.clear()
    assert "Mine" in bpy.data.materials
    assert ours not in bpy.data.materials


def test_after_planning_the_strokes_show_the_cross_field(obj):
    display = bpy.context.scene.umbilics_display
    bpy.ops.umbilics.detect()
    assert display.field == "PRINCIPAL"
    bpy.ops.umbilics.guide()
    assert display.field == "CROSS"


def test_without_a_plan_that_fits_the_directions_are_drawn(addon, obj):
    has_crosses = addon.ui.overlay.directions._has_crosses
    bpy.ops.umbilics.detect()
    assert not has_crosses(bpy.context, obj)
    bpy.ops.umbilics.guide()
    assert has_crosses(bpy.context, obj)
    obj.data.vertices[0].co *= 1.1
    obj.data.update()
    bpy.context.view_layer.update()
    assert not has_crosses(bpy.context, obj)


def test_poles_show_their_shape_where_the_overlay_does_not(addon, obj):
    bpy.ops.umbilics.guide()
    shapes = addon.operators.scene.retopology.pole_shapes
    poles = parts(obj, "poles")
    sizes = [pole.empty_display_size for pole in poles]
    assert {pole.empty_display_type for pole in poles} == {"SPHERE"}
    shapes.dress_all(poles, True)
    assert {pole.empty_display_type for pole in poles} == {"PLAIN_AXES"}
    shapes.dress_all(poles, False)
    assert {pole.empty_display_type for pole in poles} == {"SPHERE"}
    assert [pole.empty_display_size for pole in poles] == pytest.approx(sizes)


def views():
    areas = [area for screen in bpy.data.screens for area in screen.areas]
    return [area.spaces.active.overlay for area in areas if area.type == "VIEW_3D"]


def dashed():
    return [view.show_relationship_lines for view in views()]


def test_dashed_lines_are_off_with_results_and_as_before_without(addon):
    bpy.ops.wm.read_homefile(use_factory_startup=True)
    scene, before = addon.operators.scene, dashed()
    if not any(before):
        pytest.skip("the start-up file of this Blender has no view with dashed lines")

    def turn(has_results):
        with scene.transaction.all_or_nothing() as transaction:
            scene.view.dashed_lines._turn(has_results, transaction)

    turn(True)
    assert not any(dashed())
    # Who turns them on has them on.
    mine = before.index(True)
    views()[mine].show_relationship_lines = True
    turn(True)
    assert dashed().count(True) == 1
    turn(False)
    assert dashed() == before
    # What was off before stays off.
    views()[mine].show_relationship_lines = False
    turn(True)
    turn(False)
    assert dashed().count(True) == before.count(True) - 1
