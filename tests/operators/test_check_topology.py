"""Check Topology in Blender: numbers and attributes on the user's mesh, nothing on the surface."""

import bpy
import pytest
from scene_building import add_ellipsoid


@pytest.fixture
def pair():
    surface = add_ellipsoid((1.5, 1.0, 0.7), subdivisions=4)
    bpy.ops.umbilics.remesh_to_quads(quads=300, relaxation=5, hide_original=False)
    return surface, bpy.context.view_layer.objects.active


def test_our_own_quads_have_all_poles(pair):
    surface, quads = pair
    quads.umbilics_check.surface = surface
    assert bpy.ops.umbilics.check_topology() == {"FINISHED"}
    kept = quads.umbilics_check
    assert (kept.matched, kept.missing, kept.extra) == (8, 0, 0)
    assert kept.quads == kept.faces == len(quads.data.polygons)
    assert 0.0 <= kept.angle < 5.0 and kept.edges < 0.1
    poles = [item.value for item in quads.data.attributes["umbilics_check_pole"].data]
    assert poles.count(1) == 8 and poles.count(2) == 0
    assert not any(name.startswith("umbilics") for name in surface.data.attributes.keys())  # noqa: SIM118


def test_without_a_surface_it_says_how_to_choose_one(pair):
    with pytest.raises(RuntimeError, match="Choose the surface"):
        bpy.ops.umbilics.check_topology()


def test_the_other_selected_mesh_is_the_surface(pair):
    surface, quads = pair
    surface.select_set(True)
    assert bpy.ops.umbilics.check_topology() == {"FINISHED"}
    assert quads.umbilics_check.against == surface.name


def test_in_edit_mode_it_checks_what_is_edited(pair):
    surface, quads = pair
    quads.umbilics_check.surface = surface
    bpy.ops.object.mode_set(mode="EDIT")
    assert bpy.ops.umbilics.check_topology() == {"FINISHED"}
    assert quads.mode == "EDIT" and quads.umbilics_check.matched == 8


def test_a_new_mesh_sticks_to_the_surface():
    surface = add_ellipsoid(subdivisions=3)
    assert bpy.ops.umbilics.new_retopology() == {"FINISHED"}
    made = bpy.context.view_layer.objects.active
    assert made is not surface and made.mode == "EDIT" and not made.data.polygons
    assert [modifier.target for modifier in made.modifiers] == [surface]
    assert made.umbilics_check.surface == surface
    bpy.ops.object.mode_set(mode="OBJECT")
