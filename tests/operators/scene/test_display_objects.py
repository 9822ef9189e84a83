"""Objects of ours that show a map: never taken for the user's work, and never the user's."""

import sys

import bpy
import pytest
from scene_building import add_ellipsoid, census, empties


@pytest.fixture
def shown():
    """A subdivided ellipsoid and the object beside it that shows its map."""
    obj = add_ellipsoid(subdivisions=3)
    obj.modifiers.new("Subdivision", "SUBSURF").levels = 2
    bpy.context.view_layer.update()
    bpy.ops.umbilics.detect()
    bpy.ops.umbilics.show_map()
    return obj, display_of(obj)


def display_of(obj):
    (display,) = (child for child in obj.children if child.type == "MESH")
    return display


def activate(obj):
    for other in bpy.context.view_layer.objects:
        other.select_set(other == obj)
    bpy.context.view_layer.objects.active = obj


def test_it_lies_just_above_the_object_and_is_neither_clicked_nor_rendered(shown):
    obj, display = shown
    assert bpy.context.view_layer.objects.active == obj
    assert display.hide_select
    assert display.hide_render
    assert display.data.color_attributes.active_color.name == "umbilics_map"
    assert display.matrix_world == obj.matrix_world
    surface = display.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    above = [
        (seen.co - at.co).dot(at.normal)
        for seen, at in zip(surface.vertices, display.data.vertices, strict=True)
    ]
    assert 0.0 < min(above) <= max(above) < 0.01


def test_hide_map_removes_it(shown):
    obj, _ = shown
    assert bpy.ops.umbilics.hide_map() == {"FINISHED"}
    assert [child for child in obj.children if child.type == "MESH"] == []
    assert obj.umbilics.mesh is not None


def test_hide_map_leaves_no_reference_to_what_it_removed(shown):
    """Removed while Blender's own list of objects is walked through, an object would be let go of
    twice, and Blender end some time later."""
    _, display = shown
    before = sys.getrefcount(display)
    assert bpy.ops.umbilics.hide_map() == {"FINISHED"}
    # Blender's own reference is gone, once.
    assert sys.getrefcount(display) == before - 1


def test_another_map_and_another_detection_use_the_same_one(shown):
    obj, _ = shown
    bpy.context.scene.umbilics_display.map = "k1"
    assert bpy.ops.umbilics.detect() == {"FINISHED"}
    assert display_of(obj).data == obj.umbilics.mesh
    assert "umbilics_map" in obj.umbilics.mesh.color_attributes


def test_detect_on_it_stands_for_its_source(shown):
    obj, display = shown
    stamp = obj.umbilics.stamp
    activate(display)
    assert bpy.ops.umbilics.detect() == {"FINISHED"}
    assert obj.umbilics.stamp != stamp
    assert len(empties(obj)) == 4


def test_in_edit_mode_it_is_the_users_own(shown):
    obj, display = shown
    before = obj.umbilics.stamp
    activate(display)
    bpy.ops.object.mode_set(mode="EDIT")
    assert bpy.ops.umbilics.detect() == {"FINISHED"}
    assert display.mode == "EDIT"
    bpy.ops.object.mode_set(mode="OBJECT")
    assert display.umbilics.detected
    assert obj.umbilics.stamp == before


def raised(display):
    for vertex in display.data.vertices:
        vertex.co.z += 5.0
    display.data.update()


def painted(display):
    display.data.materials.append(bpy.data.materials.new("Mine"))


def renamed(display):
    display.name = "Mine"


def modified(display):
    display.modifiers.new("Mine", "DECIMATE")


def unparented(display):
    display.parent = None


@pytest.mark.parametrize("work", [raised, painted, renamed, modified, unparented])
@pytest.mark.parametrize("then", ["detect", "hide_map", "clear"])
def test_what_the_user_worked_on_is_the_users(shown, work, then):
    _, display = shown
    work(display)
    bpy.context.view_layer.update()
    kept = [vertex.co[:] for vertex in display.data.vertices]
    assert getattr(bpy.ops.umbilics, then)() == {"FINISHED"}
    assert display.name in bpy.context.view_layer.objects
    assert [vertex.co[:] for vertex in display.data.vertices] == kept
    assert not display.hide_get()
    # Detected on the edited one itself, it is analysed as it is.
    activate(display)
    display.hide_select = False
    assert bpy.ops.umbilics.detect() == {"FINISHED"}
    assert display.umbilics.detected


@pytest.mark.parametrize("linked", [False, True])
def test_a_duplicate_is_the_users(shown, linked):
    obj, display = shown
    twin = display.copy()
    if not linked:
        twin.data = display.data.copy()
    bpy.context.scene.collection.objects.link(twin)
    twin.name = "My sculpt"
    for then in ("hide_map", "clear"):
        assert getattr(bpy.ops.umbilics, then)() == {"FINISHED"}
        assert twin.name in bpy.context.view_layer.objects
        assert len(twin.data.vertices) > 3 * len(obj.data.vertices)


def test_shift_d_with_all_selected_is_complete_and_clear_takes_each_its_own(shown):
    obj, _ = shown
    bpy.ops.umbilics.hide_map()
    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.object.duplicate()
    twin = next(o for o in bpy.data.objects if o.type == "MESH" and o != obj)
    assert len(empties(twin)) == len(empties(obj)) == 4
    activate(twin)
    assert bpy.ops.umbilics.clear() == {"FINISHED"}
    assert not empties(twin)
    assert len(empties(obj)) == 4
    assert "umbilics_k1" in obj.umbilics.mesh.attributes
    activate(obj)
    assert bpy.ops.umbilics.clear() == {"FINISHED"}
    assert census()["objects"] == sorted([obj.name, twin.name])
    assert not [mesh for mesh in bpy.data.meshes if mesh.name.startswith("Umbilics of")]
