"""Pins and deletions stay with their umbilics when the mesh is detected again."""

from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from scene_building import add_ellipsoid, empties


def place_of(addon, obj, row):
    return addon.operators.data.record.place_now(obj, addon.operators.data.record.of(obj), row)[0]


def rows_of(addon, text):
    return addon.operators.data.summary.rows_of(text)


def choose(obj, place):
    """Make the umbilic nearest a place the active one; its row."""
    found = min(
        range(len(obj.umbilics.items)),
        key=lambda item: np.linalg.norm(_translation(obj, item) - place),
    )
    obj.umbilics.active = found
    return obj.umbilics.items[found].row


def _translation(obj, item):
    row = obj.umbilics.items[item].row
    empty = next(e for e in empties(obj) if e["umbilics_row"] == row)
    return np.array(empty.matrix_world.translation)


@pytest.fixture
def obj():
    """A detected ellipsoid, one of whose umbilics is pinned and another deleted."""
    made = add_ellipsoid(subdivisions=4)
    bpy.ops.umbilics.detect()
    bpy.context.view_layer.update()
    choose(made, (2.0, 0.0, 0.8))
    bpy.ops.umbilics.pin()
    choose(made, (-2.0, 0.0, -0.8))
    bpy.ops.umbilics.delete_umbilic()
    assert len(empties(made)) == 3
    return made


def kept(addon, obj):
    """World places of the pinned and of the deleted umbilic."""
    (pinned,) = rows_of(addon, obj.umbilics.pinned)
    (deleted,) = rows_of(addon, obj.umbilics.deleted)
    return place_of(addon, obj, pinned), place_of(addon, obj, deleted)


def test_detected_again_with_other_settings(addon, obj):
    before = kept(addon, obj)
    group = bpy.context.scene.umbilics
    group.scale_auto, group.scale = False, 3.0
    assert bpy.ops.umbilics.detect() == {"FINISHED"}
    after = kept(addon, obj)
    for old, new in zip(before, after, strict=True):
        assert np.linalg.norm(old - new) < 0.3
    assert len(empties(obj)) == 3


def test_after_the_mesh_was_subdivided_and_the_object_moved_and_scaled(addon, obj):
    before = kept(addon, obj)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.subdivide(smoothness=1.0)
    bpy.ops.object.mode_set(mode="OBJECT")
    obj.location, obj.scale = (5.0, 0.0, 1.0), (2.0, 2.0, 2.0)
    bpy.ops.umbilics.detect()
    for old, new in zip(before, kept(addon, obj), strict=True):
        assert np.linalg.norm(2.0 * old + (5.0, 0.0, 1.0) - new) < 1.0


def test_on_the_copy_that_holds_the_results_of_modifiers(addon):
    source = add_ellipsoid(subdivisions=3)
    source.modifiers.new("Subdivision", "SUBSURF")
    bpy.context.scene.umbilics_display.source = "EVALUATED"
    bpy.ops.umbilics.detect()
    copy = bpy.context.object
    bpy.context.view_layer.update()
    choose(copy, (2.0, 0.0, 0.8))
    bpy.ops.umbilics.pin()
    (row,) = rows_of(addon, copy.umbilics.pinned)
    before = place_of(addon, copy, row)
    source.modifiers[0].levels = 2
    bpy.ops.umbilics.detect()
    (row,) = rows_of(addon, bpy.context.object.umbilics.pinned)
    assert np.linalg.norm(place_of(addon, bpy.context.object, row) - before) < 0.3


def test_no_umbilic_stands_for_two(addon, obj):
    """Of two deletions at one place the nearer one is kept, and the other is told of."""
    record, by_hand = addon.operators.data.record, addon.operators.data.pins
    now = record.of(obj)
    pinned = rows_of(addon, obj.umbilics.pinned)
    assert by_hand.carry_over(obj, (pinned, pinned), now, now) == 0
    assert rows_of(addon, obj.umbilics.pinned) == rows_of(addon, obj.umbilics.deleted) == pinned
    everything = list(range(len(now.detection.candidates)))
    assert by_hand.carry_over(obj, (everything, []), now, now) == 0
    assert rows_of(addon, obj.umbilics.pinned) == everything


class _Candidates:
    """On the x-axis, all lemons."""

    def __init__(self, places):
        self.position = np.multiply.outer(places, (1.0, 0.0, 0.0))
        self.index = np.full(len(places), 0.5)

    def __len__(self):
        return len(self.index)


def test_the_nearer_of_two_has_the_only_counterpart(addon):
    """Two umbilics have become one: it is the one of the two that lay nearer."""

    def record(*places):
        count = len(places)
        detection = SimpleNamespace(candidates=_Candidates(np.array(places)))
        return SimpleNamespace(detection=detection, matrix=np.eye(4), edge=np.ones(count))

    before, after = record(0.0, 1.0, 20.0), record(0.7)
    counterparts = addon.operators.data.pins.counterparts
    assert counterparts(([0, 1], []), before, after) == (([0], []), 1)
    assert counterparts(([0], [1]), before, after) == (([], [0]), 1)
    # Too far away, and one that another file's record does not have.
    assert counterparts(([2], [9]), before, after) == (([], []), 1)


def test_what_has_no_counterpart_is_told_of(addon, obj):
    engine, core = addon.operators.jobs.detect, addon.core
    points = np.array([vertex.co for vertex in obj.data.vertices])
    obj.data.vertices.foreach_set("co", points[:, (1, 2, 0)].astype(np.float32).ravel())
    obj.data.update()
    inputs = engine.gather(obj, core.Settings())
    assert engine.write(bpy.context, inputs, engine.results_of(inputs, engine.compute(inputs))) == 2
    assert obj.umbilics.pinned == obj.umbilics.deleted == ""
    assert len(empties(obj)) == 4
    words = addon.operators.base.words
    assert "2 pinned or deleted" in words.pins_lost(2)


def test_clear_forgets_them(addon, obj):
    bpy.ops.umbilics.clear()
    bpy.ops.umbilics.detect()
    assert obj.umbilics.pinned == obj.umbilics.deleted == ""
    assert len(empties(obj)) == 4
