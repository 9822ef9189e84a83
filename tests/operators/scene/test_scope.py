"""A part of an object is analysed as if the rest were not there."""

import json

import bpy
import numpy as np
import pytest
from scene_building import add_ellipsoid, empties, values

# On the half x > 0 of the ellipsoid 3:2:1 there are two of its umbilics.
HALF = 2


def faces_right_of(obj, x=0.0):
    centres = np.array([face.center[:] for face in obj.data.polygons])
    return centres[:, 0] > x


def faces(obj):
    return obj.data.polygons


@pytest.fixture
def obj():
    """An ellipsoid of which the half x > 0 is shown, selected, and in a vertex group."""
    obj = add_ellipsoid(subdivisions=4)
    half = faces_right_of(obj)
    obj.data.polygons.foreach_set("select", half)
    obj.data.polygons.foreach_set("hide", ~half)
    group = obj.vertex_groups.new(name="right")
    corners = {v for face in obj.data.polygons if half[face.index] for v in face.vertices}
    group.add(sorted(corners), 1.0, "REPLACE")
    obj.data.update()
    return obj


def scope(kind, group=""):
    display = bpy.context.scene.umbilics_display
    display.scope, display.scope_group = kind, group


@pytest.mark.parametrize("kind", ["VISIBLE", "SELECTED", "GROUP"])
@pytest.mark.parametrize("source", ["BASE", "EVALUATED"])
@pytest.mark.parametrize("levels", [0, 1])
def test_only_the_part_is_analysed(obj, kind, source, levels):
    if levels:
        obj.modifiers.new("Subdivision", "SUBSURF").levels = levels
    bpy.context.scene.umbilics_display.source = source
    scope(kind, "right")
    assert bpy.ops.umbilics.detect() == {"FINISHED"}
    assert len(empties(obj)) == HALF
    assert all(empty.matrix_world.translation.x > 0.0 for empty in empties(obj))
    assert "left out" in obj.umbilics.analysed
    assert not obj.umbilics.closed


def test_values_stand_at_their_own_faces_and_vertices(obj):
    scope("GROUP", "right")
    bpy.ops.umbilics.detect()
    half = faces_right_of(obj)
    index = values(obj, "umbilics_index")
    assert sorted(index[half & (index != 0.0)]) == [0.5] * HALF
    assert not index[~half].any()
    inside = np.unique([face.vertices[:] for face in obj.data.polygons if half[face.index]])
    outside = np.setdiff1d(np.arange(len(obj.data.vertices)), inside)
    assert (values(obj, "umbilics_k1")[inside] > 0.0).all()
    assert not values(obj, "umbilics_k1")[outside].any()


def test_selected_faces_in_edit_mode(obj):
    obj.data.polygons.foreach_set("hide", [False] * len(obj.data.polygons))
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_mode(type="FACE")
    bpy.ops.mesh.select_all(action="DESELECT")
    bpy.ops.object.mode_set(mode="OBJECT")
    obj.data.polygons.foreach_set("select", faces_right_of(obj))
    bpy.ops.object.mode_set(mode="EDIT")
    scope("SELECTED")
    assert bpy.ops.umbilics.detect() == {"FINISHED"}
    bpy.ops.object.mode_set(mode="OBJECT")
    assert len(empties(obj)) == HALF
    assert (np.array([face.select for face in obj.data.polygons]) == faces_right_of(obj)).all()


def test_a_mirrored_modifier_mirrors_the_part(obj):
    obj.modifiers.new("Mirror", "MIRROR")
    scope("GROUP", "right")
    assert bpy.ops.umbilics.detect() == {"FINISHED"}
    assert len(empties(obj)) == 2 * HALF


@pytest.mark.parametrize(
    ("kind", "group", "words"),
    [
        ("SELECTED", "", "is selected. Select faces"),
        ("VISIBLE", "", "hidden. Show some"),
        ("GROUP", "", "has no vertex group."),
        ("GROUP", "gone", "has no vertex group gone"),
        ("GROUP", "empty", "lies in the vertex group empty"),
    ],
)
def test_a_part_without_faces_is_refused_in_words(kind, group, words):
    obj = add_ellipsoid(subdivisions=2)
    obj.vertex_groups.new(name="empty")
    count = len(obj.data.polygons)
    obj.data.polygons.foreach_set("select", [False] * count)
    obj.data.polygons.foreach_set("hide", [kind == "VISIBLE"] * count)
    scope(kind, group)
    with pytest.raises(RuntimeError, match=words):
        bpy.ops.umbilics.detect()
    assert not obj.umbilics.detected


def test_a_plan_keeps_to_the_part_that_was_analysed(obj):
    scope("GROUP", "right")
    bpy.ops.umbilics.detect()
    scope("WHOLE")
    assert bpy.ops.umbilics.guide() == {"FINISHED"}
    outside = ~np.array([all(obj.data.vertices[v].groups for v in f.vertices) for f in faces(obj)])
    assert not values(obj, "umbilics_cross_face")[outside].any()
    assert np.linalg.norm(values(obj, "umbilics_cross_face")[~outside], axis=1).min() > 0.9
    for lines in ("lines", "separatrices"):
        assert getattr(bpy.ops.umbilics, lines)() == {"FINISHED"}


@pytest.mark.parametrize("kind", ["VISIBLE", "SELECTED"])
@pytest.mark.parametrize("levels", [0, 1])
def test_what_was_selected_stays_the_part_until_the_next_detection(addon, obj, kind, levels):
    """Of a click on selected faces, the faces count, whatever is selected for other work later."""
    reasons = addon.operators.scene.staleness.plan_reasons
    if levels:
        obj.modifiers.new("Subdivision", "SUBSURF").levels = levels
    scope(kind)
    bpy.ops.umbilics.detect()
    half, other = faces_right_of(obj), faces_right_of(obj, 2.7)
    obj.data.polygons.foreach_set("select", other)
    obj.data.polygons.foreach_set("hide", ~other)
    obj.data.update()
    bpy.context.view_layer.update()
    assert addon.operators.scene.staleness.reasons(bpy.context, obj) == []
    scope("WHOLE")
    assert addon.operators.scene.staleness.reasons(bpy.context, obj) == ["Changed since: Scope."]
    assert bpy.ops.umbilics.guide() == {"FINISHED"}
    assert reasons(bpy.context, obj) == []
    home = obj.umbilics_plan.mesh or obj.data
    planned = np.array([one.vector for one in home.attributes["umbilics_cross_face"].data])
    inside = np.linalg.norm(planned, axis=1) > 0.5
    # A face becomes three under the first level.
    assert (inside == np.repeat(half, 3 if levels else 1)).all()
    scope(kind)
    assert bpy.ops.umbilics.detect(again=True) == {"FINISHED"}
    assert len(empties(obj)) == HALF
    bpy.ops.umbilics.detect()
    assert len(empties(obj)) < HALF
    scope("WHOLE")
    bpy.ops.umbilics.detect()
    assert "umbilics_scope" not in (obj.umbilics.mesh or obj.data).attributes


def test_a_plan_without_a_detection_says_when_another_part_is_wanted(addon):
    obj = add_ellipsoid(subdivisions=3)
    obj.vertex_groups.new(name="all").add(range(len(obj.data.vertices)), 1.0, "REPLACE")
    assert bpy.ops.umbilics.guide() == {"FINISHED"}
    reasons = addon.operators.scene.staleness.plan_reasons
    assert reasons(bpy.context, obj) == []
    scope("GROUP", "all")
    bpy.context.scene.umbilics_display.source = "BASE"
    assert reasons(bpy.context, obj) == ["Changed since: Source, Scope."]
    assert bpy.ops.umbilics.guide() == {"FINISHED"}
    assert reasons(bpy.context, obj) == []


def test_the_part_that_was_selected_goes_with_edits(obj):
    scope("SELECTED")
    bpy.ops.umbilics.detect()
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.reveal(select=False)
    bpy.ops.mesh.select_all(action="DESELECT")
    bpy.ops.object.mode_set(mode="OBJECT")
    far = faces_right_of(obj, 1.0)
    obj.data.polygons.foreach_set("select", ~far)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.delete(type="FACE")
    assert bpy.ops.umbilics.detect(again=True) == {"FINISHED"}
    bpy.ops.object.mode_set(mode="OBJECT")
    assert obj.umbilics.analysed.endswith("selected faces")
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.delete(type="FACE")
    bpy.ops.mesh.primitive_cube_add()
    with pytest.raises(RuntimeError, match="were analysed is left"):
        bpy.ops.umbilics.detect(again=True)
    bpy.ops.object.mode_set(mode="OBJECT")


@pytest.mark.usefixtures("here")
def test_the_command_takes_source_and_scope(run, obj, tmp_path):
    bpy.context.scene.frame_set(1)
    obj.modifiers.new("Subdivision", "SUBSURF")
    path, target = str(tmp_path / "half.blend"), tmp_path / "half.json"
    bpy.ops.wm.save_as_mainfile(filepath=path)
    found = {}
    for source in ("base", "evaluated"):
        words = ["--source", source, "--scope", "group", "--scope-group", "right"]
        assert run(path, "--json", str(target), *words) == 0
        (found[source],) = json.loads(target.read_text())["objects"]
        target.unlink()
        assert len(found[source]["umbilics"]) == HALF
    assert found["evaluated"]["vertices"] > 3 * found["base"]["vertices"]
    mesh = bpy.data.objects["Ellipsoid"].data
    mesh.calc_loop_triangles()
    for umbilic in found["base"]["umbilics"]:
        corners = mesh.loop_triangles[umbilic["triangle"]].vertices
        assert list(corners) == umbilic["triangle_vertices"]


@pytest.mark.parametrize("words", [["--scope", "group"], ["--scope-group", "right"]])
def test_the_command_wants_a_group_with_its_scope(run, words):
    assert run("x.obj", *words) == 2


@pytest.mark.usefixtures("here")
def test_the_command_leaves_out_what_cannot_be_seen(run, tmp_path):
    seen = add_ellipsoid(subdivisions=3, name="Seen")
    away = add_ellipsoid(subdivisions=3, name="Away")
    collection = bpy.data.collections.new("Away")
    bpy.context.scene.collection.children.link(collection)
    collection.objects.link(away)
    bpy.context.scene.collection.objects.unlink(away)
    bpy.context.view_layer.layer_collection.children["Away"].exclude = True
    path, target = str(tmp_path / "two.blend"), tmp_path / "two.json"
    bpy.ops.wm.save_as_mainfile(filepath=path)
    name = seen.name
    assert run(path, "--json", str(target)) == 0
    assert [entry["object"] for entry in json.loads(target.read_text())["objects"]] == [name]
