"""A Shift+D copy is complete, or clean: with its empties all is its own, without it says so."""

import bpy
import pytest
from scene_building import add_ellipsoid, empties, poles


@pytest.fixture
def original():
    obj = add_ellipsoid(subdivisions=4)
    bpy.ops.umbilics.detect()
    bpy.ops.umbilics.guide()
    return obj


def copied(obj, with_children):
    for other in bpy.context.view_layer.objects:
        other.select_set(other == obj or (with_children and other.parent == obj))
    bpy.context.view_layer.objects.active = obj
    bpy.ops.object.duplicate()
    bpy.context.view_layer.update()
    return bpy.context.view_layer.objects.active


def test_a_copy_with_its_poles_has_a_table_of_its_own(addon, original):
    plans, by_hand = addon.operators.data.plans, addon.operators.scene.retopology.by_hand
    copy = copied(original, with_children=True)
    assert (len(poles(copy)), len(empties(copy))) == (8, 4)
    assert not by_hand.is_changed(copy) and not by_hand.is_changed(original)
    assert {plans.empty_of(pole) for pole in copy.umbilics_plan.poles} == set(poles(copy))
    copy.umbilics_plan.active = 3
    chosen = plans.empty_of(copy.umbilics_plan.poles[3])
    assert chosen.parent == copy and chosen.select_get()
    poles(copy)[0].location.x += 1.0
    assert by_hand.is_changed(copy) and not by_hand.is_changed(original)
    bpy.ops.umbilics.clear()
    assert not copy.children and len(poles(original)) == 8 and original.umbilics.detected


def test_a_copy_of_the_mesh_alone_is_planned_anew(addon, original):
    by_hand = addon.operators.scene.retopology.by_hand
    copy = copied(original, with_children=False)
    assert not poles(copy) and not by_hand.is_steered(copy)
    assert len(copy.umbilics.items) == 4
    assert bpy.ops.umbilics.guide() == {"FINISHED"}
    assert len(poles(copy)) == 8 and len(poles(original)) == 8
    bpy.context.scene.umbilics.persistence_auto = False
    assert len(empties(copy)) == 4


def test_deleting_the_original_leaves_the_copy_whole(addon, original):
    copy = copied(original, with_children=True)
    for obj in [*original.children, original]:
        bpy.data.objects.remove(obj)
    bpy.context.view_layer.objects.active = copy
    copy.select_set(True)
    bpy.ops.umbilics.clear_file()
    assert not copy.umbilics.detected and not copy.children


def test_undo_goes_through_detection_plan_and_lines(original):
    name = original.name
    bpy.ops.ed.undo_push(message="planned")
    bpy.ops.umbilics.lines()
    bpy.ops.ed.undo_push(message="lines")
    bpy.ops.umbilics.clear()
    bpy.ops.ed.undo_push(message="cleared")

    def state():
        obj = bpy.data.objects[name]
        lines = [child for child in obj.children if child.type == "CURVE"]
        return obj.umbilics.detected, len(obj.umbilics_plan.poles), len(poles(obj)), len(lines)

    assert state() == (False, 0, 0, 0)
    bpy.ops.ed.undo()
    assert state() == (True, 8, 8, 2)
    bpy.ops.ed.undo()
    assert state() == (True, 8, 8, 0)
    bpy.ops.ed.redo()
    bpy.ops.ed.redo()
    assert state() == (False, 0, 0, 0)
