"""What the overlay draws is found by its content, and nothing is drawn that means nothing."""

import bpy
import numpy as np
import pytest
from scene_building import add_ellipsoid, add_mesh, empties


@pytest.fixture
def detected():
    obj = add_ellipsoid(subdivisions=3)
    bpy.ops.umbilics.detect()
    return obj


def content(addon, obj, crosses=False):
    fields = addon.operators.scene.view.direction_fields
    read = fields.read_cross if crosses else fields.read_field
    return addon.ui.overlay.directions.content_of(obj, crosses, read)


def test_a_copy_has_the_same_strokes_and_an_edited_one_others(addon, detected):
    before = content(addon, detected)
    bpy.ops.object.duplicate()
    other = bpy.context.view_layer.objects.active
    assert other != detected and content(addon, other) == before
    other.data.attributes["umbilics_gap"].data[0].value += 1.0
    other.data.update()
    bpy.context.view_layer.update()
    assert content(addon, other) != before
    assert content(addon, detected) == before


def test_a_stretch_turns_the_crosses(addon, detected):
    bpy.ops.umbilics.guide()
    before = content(addon, detected, crosses=True)
    detected.scale = (1.0, 1.0, 2.0)
    bpy.context.view_layer.update()
    assert content(addon, detected, crosses=True) != before


def test_nothing_is_drawn_from_a_mesh_that_is_being_edited(addon, detected):
    arranged = addon.ui.overlay.directions._arranged
    assert arranged(bpy.context, detected, False) is not None
    bpy.ops.object.mode_set(mode="EDIT")
    assert arranged(bpy.context, detected, False) is None


def test_caches_forget_what_was_not_drawn_for_long(addon):
    kept = addon.ui.overlay.painter._Kept(2)
    made = [kept.of(key, lambda key=key: [key]) for key in "aba"]
    assert made[0] is made[2]
    kept.of("c", lambda: ["c"])
    assert kept.of("a", lambda: ["anew"]) == ["a"]
    assert kept.of("b", lambda: ["anew"]) == ["anew"]


@pytest.mark.parametrize("levels", [3, 4])
def test_a_sphere_has_no_strokes(addon, levels):
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=levels)
    bpy.ops.umbilics.detect()
    obj = bpy.context.object
    assert obj.umbilics.regions == 1
    fields, strokes = addon.operators.scene.view.direction_fields, addon.operators.drawing.strokes
    assert not strokes.arranged(*fields.read_field(obj)).weight.any()


def test_beside_a_region_strokes_are_as_sure_as_without_it(addon):
    """A capsule: its caps have no directions, its middle has."""
    obj = capsule()
    bpy.ops.umbilics.detect()
    assert obj.umbilics.regions >= 1
    fields, strokes = addon.operators.scene.view.direction_fields, addon.operators.drawing.strokes
    found = strokes.arranged(*fields.read_field(obj))
    height = np.abs(found.places[:, 2])
    assert not found.weight[height > 1.6].any()
    assert (found.weight[height < 0.8] > 0.9).all()


def capsule():
    """A tube two long and two wide between half spheres; its quads are nearly square."""
    angle = np.linspace(0.0, np.pi, 49)[1:-1]
    z, radius = np.cos(angle), np.sin(angle)
    top, side = z > 1e-9, np.linspace(1.0, -1.0, 33)
    z = np.concatenate([z[top] + 1.0, side, z[z < -1e-9] - 1.0])
    radius = np.concatenate([radius[top], np.ones(len(side)), radius[::-1][top][::-1]])
    around = 2.0 * np.pi * np.arange(96) / 96
    circle = np.column_stack([np.cos(around), np.sin(around), np.zeros(96)])
    rings = radius[:, None, None] * circle + z[:, None, None] * (0.0, 0.0, 1.0)
    number = np.arange(len(z) * 96).reshape(len(z), 96)
    here, after = number, np.roll(number, -1, axis=1)
    faces = np.stack([here[:-1], here[1:], after[1:], after[:-1]], axis=2).reshape(-1, 4).tolist()
    poles = len(z) * 96
    faces += [[poles, a, b] for a, b in zip(here[0], after[0], strict=True)]
    faces += [[poles + 1, b, a] for a, b in zip(here[-1], after[-1], strict=True)]
    return add_mesh([*rings.reshape(-1, 3), (0.0, 0.0, 2.0), (0.0, 0.0, -2.0)], faces)


def test_poles_and_numbers_are_drawn_where_they_are_seen(addon, detected):
    facing = addon.operators.scene.view.facing_shapes
    upright = np.eye(3)[:2]
    display = bpy.context.scene.umbilics_display
    assert facing.shapes_of_poles(bpy.context, detected, upright, False) == []
    bpy.ops.umbilics.guide()
    poles = [child for child in detected.children if "umbilics_valence" in child]
    places, valence = facing.pole_places(detected)
    assert len(places) == len(poles) == 8 and set(valence) == {3}
    poles[0].hide_set(True)
    assert len(facing.pole_places(detected)[0]) == 7
    shapes = facing.shapes_of_poles(bpy.context, detected, upright, False)
    assert shapes and all((shape.triangles < len(shape.centre)).all() for shape in shapes)
    # Without a choice nothing is numbered, with one it is, and all are on request.
    assert not len(facing.numbered_rows(bpy.context, detected))
    detected.umbilics.active = 1
    row = detected.umbilics.items[1].row
    assert facing.numbered_rows(bpy.context, detected).tolist() == [row]
    display.numbers = True
    assert len(facing.numbered_rows(bpy.context, detected)) == len(empties(detected)) == 4
    assert facing.shapes_of_numbers(bpy.context, detected, upright, False)


def test_every_digit_is_drawn_within_its_box(addon):
    figures = addon.operators.drawing.figures
    places = addon.operators.drawing.shapes.Places(*np.eye(3)[:, None].repeat(10, axis=1))
    how = figures.Writing(10.0, (1.0, 1.0, 1.0, 1.0), rim=False)
    shapes = figures.written(places, list(range(10)), how)
    assert len(shapes) == 10
    for shape in shapes:
        reach = np.abs(shape.reach[:, 2:])
        assert reach[:, 0].max() < 5.0 and 4.0 < reach[:, 1].max() < 7.0
    assert len({shape.reach.tobytes() for shape in shapes}) == 10


def test_the_line_of_a_digit_fades_on_both_sides_over_a_pixel(addon):
    figures = addon.operators.drawing.figures
    places = addon.operators.drawing.shapes.Places(*np.eye(3)[:, None])
    how = figures.Writing(10.0, (1.0, 1.0, 1.0, 0.8), rim=False)
    (shape,) = figures.written(places, [1], how)
    # The foot of the 1 stands at .04 of its height and is .15 of it wide.
    foot = shape.reach[:, 3] < -5.0
    away = np.abs(shape.reach[foot, 2] - 0.4)
    opacity = shape.colour[foot, 3]
    outer = away > 1.0
    assert outer.sum() == (~outer).sum() == 2
    assert np.allclose(away[outer], 0.75 + 0.5)
    assert np.allclose(away[~outer], 0.75 - 0.5)
    assert not opacity[outer].any() and np.allclose(opacity[~outer], 0.8)
