"""Check Topology in Blender: numbers and attributes on the user's mesh, nothing on the surface."""

import dataclasses
import importlib

import bpy
import mathutils
import numpy as np
import pytest
from scene_building import add_ellipsoid, values


@pytest.fixture(scope="module")
def remeshed_once():
    """`core.remesh`, which answers with the first quads again."""
    remesh, made = importlib.import_module("bl_ext.user_default.umbilics").core.remesh, []

    def remeshed(*given, **named):
        if not made:
            made.append(remesh(*given, **named))
        return made[0]

    return remeshed


@pytest.fixture
def pair(addon, monkeypatch, remeshed_once):
    surface = add_ellipsoid((1.5, 1.0, 0.7), subdivisions=4)
    with monkeypatch.context() as patch:
        patch.setattr(addon.core, "remesh", remeshed_once)
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
    pair[1].umbilics_check.surface = None
    with pytest.raises(RuntimeError, match="Choose the surface"):
        bpy.ops.umbilics.check_topology()


def test_the_other_selected_mesh_is_the_surface(pair):
    surface, quads = pair
    quads.umbilics_check.surface = None
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


def marks(obj):
    """States and valences in the table of a check."""
    kept = obj.umbilics_check
    return [(("matched", "extra", "missing")[mark.state], mark.valence) for mark in kept.marks]


def test_what_was_remeshed_is_checked_at_once(pair):
    surface, quads = pair
    kept = quads.umbilics_check
    assert (kept.checked, kept.against, kept.surface) == (True, surface.name, surface)
    assert (kept.matched, kept.missing, kept.extra) == (8, 0, 0)
    assert 0.3 < kept.jacobian <= 1.0
    assert marks(quads) == [("matched", 3)] * 8
    places = {tuple(mark.place) for mark in kept.marks}
    valence = values(quads, "umbilics_valence")
    assert places == {tuple(quads.data.vertices[row].co) for row in np.flatnonzero(valence)}
    both = values(quads, "umbilics_check_angle") - values(quads, "umbilics_angle")
    assert np.median(np.abs(both)) < 1.0


def test_missing_and_extra_ones_are_in_the_table_first(pair):
    _, quads = pair
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="DESELECT")
    bpy.ops.object.mode_set(mode="OBJECT")
    valence = values(quads, "umbilics_valence")
    # A corner of the cube becomes another shape: its quads are cut into triangles.
    corner = int(np.flatnonzero(valence)[0])
    for polygon in quads.data.polygons:
        polygon.select = corner in polygon.vertices
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.quads_convert_to_tris()
    bpy.ops.object.mode_set(mode="OBJECT")
    assert bpy.ops.umbilics.check_topology() == {"FINISHED"}
    kept = quads.umbilics_check
    assert kept.quads == kept.faces - 6
    states = [state for state, _ in marks(quads)]
    assert states == sorted(states, key=("missing", "extra", "matched").index)
    assert states.count("matched") == kept.matched
    assert states.count("missing") == kept.missing
    assert states.count("extra") == kept.extra > 0
    assert kept.matched + kept.missing == 8


def test_an_edited_mesh_makes_its_check_old(addon, pair):
    is_old = addon.operators.scene.retopology.checks.is_old
    _, quads = pair
    assert not is_old(bpy.context, quads)
    quads.data.vertices[0].co.x += 0.1
    quads.data.update()
    bpy.context.view_layer.update()
    assert is_old(bpy.context, quads)
    bpy.ops.umbilics.check_topology()
    assert not is_old(bpy.context, quads)


def edit(surface, _quads):
    surface.data.vertices[0].co *= 1.01
    surface.data.update()


def keep_others(surface, _quads):
    bpy.context.view_layer.objects.active = surface
    bpy.ops.umbilics.detect()
    bpy.context.scene.umbilics.at_most = 2


def move_a_pole(surface, quads):
    bpy.context.view_layer.objects.active = surface
    bpy.ops.umbilics.guide()
    pole = next(child for child in surface.children if "umbilics_valence" in child)
    pole.location.x += 0.1
    bpy.context.view_layer.objects.active = quads


def set_otherwise(_surface, _quads):
    group = bpy.context.scene.umbilics_guidance
    group.smoothness_auto, group.smoothness = False, 0.7


def move_apart(_surface, quads):
    quads.location.x += 0.01


def move_both(surface, quads):
    surface.location.x = quads.location.x = 3.0
    surface.rotation_euler.z = quads.rotation_euler.z = 1.0


def select_it(surface, _quads):
    surface.select_set(True)


def delete(surface, _quads):
    bpy.data.objects.remove(surface)


# What is done one after the other, with a new check after each that makes the last one old; what
# only a new plan hangs on makes none old that is of the plan of the quads.
OF_A_NEW_PLAN = (move_a_pole, set_otherwise)
WORKS = (
    (select_it, ""),
    (move_both, ""),
    (edit, "Ellipsoid: The mesh was edited or deformed: vertices were moved."),
    (keep_others, "Ellipsoid: Other umbilics are kept."),
    (move_a_pole, "Poles were moved, added or deleted by hand."),
    (set_otherwise, "Ellipsoid: Changed since: Smoothness."),
    (move_apart, "The mesh and the surface were moved apart."),
    (delete, "Ellipsoid was deleted or renamed."),
)


@pytest.mark.parametrize("own", [True, False])
def test_a_check_is_old_when_the_surface_or_its_plan_is_another(addon, pair, own):
    surface, quads = pair

    def reasons():
        bpy.context.view_layer.update()
        return " ".join(addon.operators.scene.staleness.check_reasons(bpy.context, quads))

    assert reasons() == ""
    quads.umbilics_check.own_plan = own
    if not own:
        assert reasons() == "Changed since: Plan of the Quads."
        assert bpy.ops.umbilics.check_topology() == {"FINISHED"}
        assert reasons() == ""
    for work, words in WORKS:
        work(surface, quads)
        words = "" if own and work in OF_A_NEW_PLAN else words
        assert reasons() == words, work
        if words and work is not delete:
            bpy.context.view_layer.objects.active = quads
            assert bpy.ops.umbilics.check_topology() == {"FINISHED"}
            assert reasons() == "", work


def test_marks_stand_where_they_belong_however_the_object_is_turned(addon, monkeypatch):
    """Those of missing poles too, of which there are two here."""
    surface = add_ellipsoid((1.5, 1.0, 0.7), subdivisions=4)
    surface.location, surface.rotation_euler = (5.0, -3.0, 2.0), (1.5, 0.4, 0.0)
    surface.scale = (2.0, 1.0, 1.0)
    real, gone = addon.core.check_quads, np.arange(2)

    def without_two(*arguments):
        found = real(*arguments)
        return dataclasses.replace(found, missing=gone)

    monkeypatch.setattr(addon.core, "check_quads", without_two)
    bpy.ops.umbilics.remesh_to_quads(quads=300, relaxation=5, hide_original=False)
    quads = bpy.context.view_layer.objects.active
    assert addon.operators.scene.staleness.check_reasons(bpy.context, quads) == []
    for mark in quads.umbilics_check.marks:
        place = quads.matrix_world @ mathutils.Vector(mark.place)
        _, nearest, _, _ = surface.closest_point_on_mesh(surface.matrix_world.inverted() @ place)
        assert (surface.matrix_world @ nearest - place).length < 0.02


def test_clear_takes_a_check_and_leaves_the_quads(pair):
    surface, quads = pair
    own = [name for name in quads.data.attributes.keys() if "check" not in name]  # noqa: SIM118
    assert bpy.ops.umbilics.clear() == {"FINISHED"}
    assert not quads.umbilics_check.checked and quads.umbilics_check.surface == surface
    assert quads.data.attributes.keys() == own
    assert bpy.ops.umbilics.check_topology() == {"FINISHED"}
    assert bpy.ops.umbilics.clear_file() == {"FINISHED"}
    assert not quads.umbilics_check.checked


def test_what_is_seen_is_checked(addon, pair):
    """Half of a mesh under a Mirror modifier is checked as a whole one."""
    surface, _ = pair
    bpy.ops.object.select_all(action="DESELECT")
    bpy.context.view_layer.objects.active = surface
    surface.select_set(True)
    bpy.ops.umbilics.remesh_to_quads(quads=300, relaxation=5, symmetry="x", hide_original=False)
    quads = bpy.context.view_layer.objects.active
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.bisect(plane_co=(0, 0, 0), plane_no=(1, 0, 0), clear_outer=True)
    bpy.ops.object.mode_set(mode="OBJECT")
    quads.modifiers.new("Mirror", "MIRROR")
    for source, matched in (("EVALUATED", 8), ("BASE", 4)):
        bpy.context.scene.umbilics_display.source = source
        assert bpy.ops.umbilics.check_topology() == {"FINISHED"}
        assert quads.umbilics_check.matched == matched
        assert not addon.operators.scene.retopology.checks.is_old(bpy.context, quads)
    # Values of the whole have no place on the half; those of the half have.
    assert len(values(quads, "umbilics_check_angle")) == len(quads.data.polygons)


def test_the_map_is_dark_where_quads_follow_and_goes_without_a_trace(addon, pair):
    _, quads = pair
    before = [layer.name for layer in quads.data.color_attributes]
    assert bpy.ops.umbilics.show_check() == {"FINISHED"}
    layer = quads.data.color_attributes["umbilics_map"]
    colours = np.empty(4 * len(layer.data), np.float32)
    layer.data.foreach_get("color_srgb", colours)
    light = colours.reshape(-1, 4)[::4, :3].sum(axis=1)
    angle = values(quads, "umbilics_check_angle")
    order = np.argsort(angle)
    assert (np.diff(light[order]) > -0.03).all() and light[order[-1]] > light[order[0]]
    legend = addon.operators.scene.view.maps.legend(bpy.context.scene, quads)
    assert (legend.low, legend.high) == (0.0, 45.0)
    assert bpy.ops.umbilics.hide_map() == {"FINISHED"}
    assert [layer.name for layer in quads.data.color_attributes] == before


def test_marks_of_a_check_have_a_shape_each(addon, pair):
    _, quads = pair
    shapes = addon.operators.scene.view.facing_shapes
    kept = quads.umbilics_check
    kept.marks[0].state, kept.marks[1].state = 1, 2
    upright = np.eye(3)[:2]
    drawn = shapes.shapes_of_check(bpy.context, quads, upright, False)
    # A rim, a polygon and a number for each of three states.
    assert len({tuple(shape.colour[0]) for shape in drawn}) >= 5
    assert len(drawn) == 9
    faint = shapes.shapes_of_check(bpy.context, quads, upright, True)
    assert max(shape.colour[:, 3].max() for shape in faint) < 0.5

    def widest():
        found = shapes.shapes_of_check(bpy.context, quads, upright, False)
        return max(shape.reach.max() for shape in found)

    before = widest()
    kept.active = 0
    assert widest() > 1.3 * before


def bumpy():
    """A surface whose plan, smoothed by itself, has other poles than few and smooth quads."""
    surface = add_ellipsoid((1.5, 1.0, 0.7), subdivisions=4)
    for vertex in surface.data.vertices:
        x, y, z = vertex.co
        vertex.co *= 1.0 + 0.08 * np.sin(4.0 * x + 1.0) * np.cos(5.0 * y) * np.sin(4.0 * z + 2.0)
    surface.data.update()
    return surface


def test_our_quads_are_compared_with_the_plan_that_they_were_made_from():
    surface = bumpy()
    bpy.ops.umbilics.remesh_to_quads(quads=300, smoothness=1.0, relaxation=5, hide_original=False)
    quads = bpy.context.view_layer.objects.active

    def told():
        kept = quads.umbilics_check
        return kept.matched, kept.missing, kept.extra

    def counts():
        assert bpy.ops.umbilics.check_topology() == {"FINISHED"}
        return told()

    first = told()
    assert first[0] >= 8 and first[1:] == (0, 0)
    assert counts() == first
    # They go with the surface.
    for obj in (surface, quads):
        obj.location, obj.rotation_euler, obj.scale = (5.0, -3.0, 2.0), (1.5, 0.4, 0.0), (2.0,) * 3
    for obj in (surface, quads):
        with bpy.context.temp_override(selected_editable_objects=[obj], object=obj):
            bpy.ops.object.transform_apply()
    assert counts() == first
    # Clear takes the check, not what the next one is of.
    assert bpy.ops.umbilics.clear() == {"FINISHED"}
    assert counts() == first
    quads.umbilics_check.own_plan = False
    other = counts()
    assert other[1] + other[2] > 0
    quads.umbilics_check.own_plan = True
    assert counts() == first
    # On other faces they have no place.
    bpy.context.view_layer.objects.active = surface
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.subdivide()
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.context.view_layer.objects.active = quads
    with pytest.raises(RuntimeError, match="has other faces than when these quads were made of it"):
        bpy.ops.umbilics.check_topology()
    quads.umbilics_check.own_plan = False
    assert bpy.ops.umbilics.check_topology() == {"FINISHED"}


@pytest.mark.parametrize("text", ["no", "[]", "[1, [2], [[1, 0, 0]], [3]]", "[9, [2], [1], [3]]"])
def test_a_plan_of_quads_that_cannot_be_read_is_none(pair, text):
    _, quads = pair
    quads.umbilics_check.planned = text
    assert bpy.ops.umbilics.check_topology() == {"FINISHED"}
    assert not quads.umbilics_check.by_own_plan and quads.umbilics_check.matched == 8
