"""The cross field as the overlay draws it."""

import bpy
import numpy as np
import pytest
from scene_building import add_ellipsoid, moved, values


@pytest.fixture
def planned():
    obj = add_ellipsoid(subdivisions=4)
    bpy.ops.umbilics.guide()
    return obj


def test_every_vertex_has_a_cross_of_full_weight(addon, planned):
    fields = addon.operators.scene.view.direction_fields
    found = addon.operators.drawing.strokes.arranged(*fields.read_cross(planned))
    assert len(found.places) == len(planned.data.vertices)
    assert (found.weight == 1.0).all()
    stored = values(planned, "umbilics_cross")
    row = np.linalg.norm(
        np.array([vertex.co for vertex in planned.data.vertices]) - found.places[5], axis=1
    ).argmin()
    assert found.d1[5] == pytest.approx(stored[row], abs=1e-6)
    assert np.abs(np.einsum("ij,ij->i", found.d1, found.d2)).max() < 1e-5


def test_arms_are_at_right_angles_under_a_stretched_object(addon):
    obj = add_ellipsoid((1.0, 1.0, 1.0), subdivisions=4)
    obj.matrix_world = moved(scale=(3.0, 2.0, 1.0))
    bpy.context.view_layer.update()
    bpy.ops.umbilics.guide()
    _, d1, d2, _ = addon.operators.scene.view.direction_fields.read_cross(obj)
    matrix = np.array(obj.matrix_world)[:3, :3]
    one, two = d1 @ matrix.T, d2 @ matrix.T
    cosine = np.einsum("ij,ij->i", one, two)
    cosine /= np.linalg.norm(one, axis=1) * np.linalg.norm(two, axis=1)
    assert np.abs(cosine).max() < 1e-3


def test_without_a_plan_there_is_nothing_to_draw(addon):
    obj = add_ellipsoid(subdivisions=4)
    bpy.ops.umbilics.detect()
    assert addon.operators.scene.view.direction_fields.read_cross(obj) is None
    assert not addon.operators.scene.staleness.plan_is_edited(bpy.context, obj)


def test_an_edited_mesh_has_no_crosses_and_the_plan_says_so(addon, planned):
    edited = addon.operators.scene.staleness.plan_is_edited
    assert not edited(bpy.context, planned)
    planned.data.vertices[0].co *= 1.5
    planned.data.update()
    bpy.context.view_layer.update()
    assert edited(bpy.context, planned)
    bpy.ops.umbilics.guide()
    assert not edited(bpy.context, planned)


def test_a_new_plan_is_drawn_anew(planned):
    before = planned.umbilics_plan.stamp
    group = bpy.context.scene.umbilics_guidance
    group.smoothness_auto, group.smoothness = False, 0.2
    bpy.ops.umbilics.guide()
    assert planned.umbilics_plan.stamp not in ("", before)
    bpy.ops.umbilics.clear()
    assert planned.umbilics_plan.stamp == ""


def test_glyphs_are_smaller_where_most_would_lie_on_one_another(addon):
    gap = addon.operators.drawing.poles.usual_gap
    grid = np.stack(np.meshgrid(*3 * [np.arange(4.0)]), axis=-1).reshape(-1, 3)
    assert gap(grid) == 1.0
    # A few that are far off, or near together, change nothing.
    assert gap(np.vstack([grid, [(90.0, 0, 0), (0.1, 0, 0)]])) == 1.0
    assert gap(grid[:1]) == gap(grid[:0]) == np.inf
