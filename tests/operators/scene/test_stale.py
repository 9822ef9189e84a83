"""Results that no longer belong to the mesh or the settings are known to."""

import bpy
import pytest
from scene_building import add_ellipsoid, empties


@pytest.fixture
def reasons(addon):
    def ask(obj):
        bpy.context.view_layer.update()
        return " ".join(addon.operators.scene.staleness.reasons(bpy.context, obj))

    return ask


def detected():
    obj = add_ellipsoid(subdivisions=3)
    bpy.ops.umbilics.detect()
    return obj


def test_edited_mesh_until_it_is_detected_again(reasons):
    obj = detected()
    assert reasons(obj) == ""
    obj.data.vertices[0].co.x += 0.1
    obj.data.update()
    assert "edited" in reasons(obj)
    bpy.ops.umbilics.detect()
    assert reasons(obj) == ""


def test_scaled_but_not_moved_object(reasons):
    obj = detected()
    obj.location, obj.rotation_euler = (1.0, 2.0, 3.0), (0.3, 0.2, 0.1)
    assert reasons(obj) == ""
    obj.scale = (1.0, 1.0, 2.0)
    assert "scaled" in reasons(obj)


def test_changed_settings_are_named(reasons):
    obj = detected()
    group = bpy.context.scene.umbilics
    group.crease_angle_auto, group.crease_angle = False, 1.0
    assert "Crease Angle" in reasons(obj)
    group.property_unset("crease_angle")
    group.property_unset("crease_angle_auto")
    assert reasons(obj) == ""
    group.charts = "uv"
    assert reasons(obj) == "", "method S reads no charts"
    group.scale_auto, group.scale = False, 3.0
    assert "Scale" in reasons(obj)
    for curvature in ("normals", "given"):
        group.curvature = curvature
        assert "Scale" not in reasons(obj), "only jets have one"


def test_filters_are_no_reason_to_detect_again(addon, reasons):
    first, second = detected(), detected()
    bpy.context.scene.umbilics.opening = 2
    assert reasons(second) == reasons(first) == ""
    stale = addon.operators.scene.staleness
    assert stale.filters_differ(bpy.context, first)
    assert not stale.filters_differ(bpy.context, second)
    bpy.context.scene.umbilics.opening = 5
    assert "Opening" in reasons(second)
    bpy.ops.umbilics.detect()
    assert not stale.filters_differ(bpy.context, second)
    bpy.context.scene.umbilics["at_most"] = 2
    assert stale.filters_differ(bpy.context, second)


def test_colours_of_a_map_are_no_edit(reasons):
    obj = detected()
    assert reasons(obj) == ""
    bpy.ops.umbilics.show_map()
    assert reasons(obj) == ""


def with_modifier(kind):
    obj = add_ellipsoid(subdivisions=3)
    obj.modifiers.new("Modifier", kind)
    return obj


def test_modifier_that_keeps_the_vertices_gives_results_on_the_base(reasons):
    obj = with_modifier("SMOOTH")
    assert bpy.ops.umbilics.detect() == {"FINISHED"}
    assert bpy.context.object == obj
    assert "umbilics_k1" in obj.data.attributes
    assert reasons(obj) == ""
    obj.modifiers[0].factor = 1.0
    assert "edited" in reasons(obj)


def test_selected_objects_are_all_analysed_and_what_cannot_be_is_left_out():
    first = add_ellipsoid(subdivisions=3, name="First")
    bad = bpy.data.objects.new("Bad", bpy.data.meshes.new("Bad"))
    bpy.context.scene.collection.objects.link(bad)
    second = add_ellipsoid(subdivisions=3, name="Second")
    for obj in (first, bad):
        obj.select_set(True)
    assert bpy.ops.umbilics.detect() == {"FINISHED"}
    assert len(empties(first)) == len(empties(second)) == 4
    assert not bad.umbilics.detected


def test_a_changed_uv_map_counts_where_it_is_read(reasons):
    obj = add_ellipsoid(subdivisions=3)
    group = bpy.context.scene.umbilics
    for parametrization, told in (("uv", True), ("conformal", False)):
        group.parametrization = parametrization
        bpy.ops.umbilics.detect()
        assert reasons(obj) == ""
        obj.data.uv_layers.active.uv[0].vector.x += 0.1
        assert ("UV map was changed" in reasons(obj)) == told


@pytest.mark.parametrize("detected_first", [True, False])
def test_a_plan_alone_knows_what_of_the_object_it_was_made_of(addon, detected_first):
    obj = add_ellipsoid(subdivisions=3)
    if detected_first:
        bpy.ops.umbilics.detect()
    bpy.ops.umbilics.guide()
    why = addon.operators.scene.staleness.plan_reasons
    assert why(bpy.context, obj) == []
    display = bpy.context.scene.umbilics_display
    display.source = "BASE" if display.source == "EVALUATED" else "EVALUATED"
    # With a detection it is that which is out of date.
    assert bool(why(bpy.context, obj)) != detected_first
