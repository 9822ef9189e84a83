"""List, empties, pole table and view speak of one umbilic or pole by one number."""

import bpy
import numpy as np
import pytest
from scene_building import add_ellipsoid, empties, poles


@pytest.fixture
def planned():
    """An ellipsoid with its four lemons and eight poles; only the detection is of it."""
    obj = add_ellipsoid(subdivisions=4)
    bpy.ops.umbilics.detect()
    bpy.ops.umbilics.guide()
    return obj


def click(obj):
    """What a click in the view does to an object."""
    for other in bpy.context.selected_objects:
        other.select_set(False)
    obj.select_set(True)
    bpy.context.view_layer.objects.active = obj
    bpy.context.view_layer.update()


def test_one_number_in_list_empties_and_pole_table(planned):
    numbers = {item.row: item.number for item in planned.umbilics.items}
    assert sorted(numbers.values()) == [1, 2, 3, 4]
    for empty in empties(planned):
        number = numbers[empty["umbilics_row"]]
        assert (empty["umbilics_number"], empty.name) == (number, f"Lemon {number}")
    places = {empty.name: np.array(empty.matrix_world.translation) for empty in empties(planned)}
    for item in planned.umbilics_plan.poles:
        pole = bpy.data.objects[item.name]
        assert item.origin == f"Lemon {pole['umbilics_number']}"
        near = min(places, key=lambda name: np.linalg.norm(places[name] - pole.location))
        assert near == item.origin


def test_no_filter_numbers_anew(planned, addon):
    kept = addon.operators.data.record.of(planned)
    before = kept.numbers.copy()
    assert sorted(before) == list(range(1, len(before) + 1))
    gone = planned.umbilics.items[0]
    number = gone.number
    planned.umbilics.active = 0
    bpy.ops.umbilics.delete_umbilic()
    assert sorted(item.number for item in planned.umbilics.items) == sorted({1, 2, 3, 4} - {number})
    bpy.ops.umbilics.guide()
    origins = {item.origin for item in planned.umbilics_plan.poles}
    assert origins - {"Field"} <= {f"Lemon {left}" for left in {1, 2, 3, 4} - {number}}


def test_the_most_persistent_come_first_and_what_the_border_spoils_last(addon):
    candidates = addon.core.detect(*bumpy_disc(addon)).candidates
    order = np.argsort(addon.core.numbers(candidates))
    border = candidates.at_border[order]
    assert border.any() and not border.all()
    assert (np.diff(border.astype(int)) >= 0).all()
    inner = candidates.select(order[~border])
    kept = inner.resolved | ~np.isfinite(inner.persistence)
    assert (np.diff(kept.astype(int)) <= 0).all()
    for some in (inner.persistence[kept], inner.persistence[~kept]):
        known = some[~np.isnan(some)]
        assert (known[:-1] >= known[1:]).all()


def bumpy_disc(addon):
    """Vertices and triangles of an open, rough square."""
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=40, y_subdivisions=40)
    mesh = bpy.context.object.data
    mesh.calc_loop_triangles()
    places = np.array([vertex.co for vertex in mesh.vertices])
    x, y = places[:, 0], places[:, 1]
    noise = np.random.default_rng(2).normal(size=len(places))
    places[:, 2] = 0.2 * np.sin(5 * x) * np.cos(4 * y) + 0.002 * noise
    return places, np.array([triangle.vertices for triangle in mesh.loop_triangles])


def test_a_click_on_an_umbilic_selects_its_row_and_keeps_the_panel(planned, addon):
    shown = addon.operators.scene.selection.shown
    for empty in empties(planned):
        click(empty)
        mine = planned.umbilics
        assert mine.items[mine.active].row == empty["umbilics_row"]
        assert shown(bpy.context) == planned
        assert addon.ui.list_panel.UMBILICS_PT_list.poll(bpy.context)
        assert bpy.ops.umbilics.detect.poll() and bpy.ops.umbilics.pin.poll()


def test_a_click_on_a_pole_selects_its_row_and_keeps_the_panel(planned, addon):
    for pole in poles(planned):
        click(pole)
        plan = planned.umbilics_plan
        assert plan.poles[plan.active].name == pole.name
        assert addon.operators.scene.selection.shown(bpy.context) == planned
        assert bpy.ops.umbilics.guide.poll()


def test_a_click_on_a_row_selects_that_one_alone(planned):
    click(empties(planned)[0])
    for place, item in enumerate(planned.umbilics.items):
        planned.umbilics.active = place
        bpy.context.view_layer.update()
        chosen = [empty["umbilics_row"] for empty in empties(planned) if empty.select_get()]
        assert chosen == [item.row]
        assert planned.umbilics.active == place
    for place, item in enumerate(planned.umbilics_plan.poles):
        planned.umbilics_plan.active = place
        bpy.context.view_layer.update()
        assert [pole.name for pole in poles(planned) if pole.select_get()] == [item.name]
        assert planned.umbilics_plan.active == place


def test_an_empty_that_was_taken_from_its_mesh_is_an_object_as_any_other(planned, addon):
    free = empties(planned)[0]
    free.parent = None
    click(free)
    assert addon.operators.scene.selection.shown(bpy.context) == free
    assert not bpy.ops.umbilics.detect.poll()


def test_detection_from_an_umbilic_is_that_of_its_mesh(planned):
    planned.umbilics.active = 2
    click(empties(planned)[0])
    assert bpy.ops.umbilics.detect() == {"FINISHED"}
    assert len(empties(planned)) == 4
    assert bpy.ops.umbilics.clear() == {"FINISHED"}
    assert not planned.umbilics.detected and not planned.children
