"""What can be changed after a detection acts at once, through undo, save and reload."""

import bpy
import numpy as np
import pytest
from scene_building import add_ellipsoid, census, empties


def noisy(subdivisions=4):
    """A detected ellipsoid with many umbilics that noise has made; all are shown."""
    obj = add_ellipsoid(subdivisions=subdivisions)
    points = np.array([vertex.co for vertex in obj.data.vertices])
    points += 0.02 * np.random.default_rng(3).standard_normal(points.shape)
    obj.data.vertices.foreach_set("co", points.astype(np.float32).ravel())
    obj.data.update()
    group = bpy.context.scene.umbilics
    group.scale_auto, group.scale = False, 2.0
    group.regions = False
    group.persistence_auto, group.persistence = False, 0.0
    assert bpy.ops.umbilics.detect() == {"FINISHED"}
    assert len(empties(obj)) > 20
    return obj


def rows(obj):
    return sorted(empty["umbilics_row"] for empty in empties(obj))


def test_persistence_thins_out_and_brings_back():
    obj = noisy()
    group, display = bpy.context.scene.umbilics, bpy.context.scene.umbilics_display
    everything = rows(obj)
    counts = []
    for strength in (0.3, 0.6, 0.9, 1.0):
        display.strength = strength
        assert display.strength == pytest.approx(strength, abs=1e-3)
        assert rows(obj) == sorted(item.row for item in obj.umbilics.items)
        assert obj.umbilics.index_sum == 2.0
        counts.append(len(empties(obj)))
    assert counts == sorted(counts, reverse=True)
    assert counts[-1] == 4
    group.persistence = 0.0
    assert rows(obj) == everything


def test_what_the_filters_give_is_what_a_detection_with_them_gives():
    obj = noisy()
    bpy.context.scene.umbilics_display.strength = 0.7
    bpy.context.scene.umbilics_display.opened = True
    filtered = rows(obj)
    bpy.ops.umbilics.detect()
    assert rows(obj) == filtered


def test_kinds_and_empties_are_a_matter_of_display():
    obj = noisy()
    display = bpy.context.scene.umbilics_display
    counts = obj.umbilics.lemon, obj.umbilics.star
    display.kinds = {"star"}
    assert {empty["umbilics_kind"] for empty in empties(obj)} == {"star"}
    assert (obj.umbilics.lemon, obj.umbilics.star) == counts
    display.empties = False
    assert not empties(obj)
    assert len(obj.umbilics.items) == counts[1]
    display.empties = True
    assert len(empties(obj)) == counts[1]


def test_only_the_most_persistent_get_empties(addon):
    obj = noisy()
    preferences = bpy.context.preferences.addons["bl_ext.user_default.umbilics"].preferences
    preferences.most_empties = 5
    try:
        bpy.ops.umbilics.apply_filters()
        found = empties(obj)
        assert len(found) == 5
        least = min(empty["umbilics_persistence"] for empty in found)
        others = {item.row: item.persistence for item in obj.umbilics.items}
        assert sum(value > 1.001 * least for value in others.values()) <= 5
    finally:
        preferences.property_unset("most_empties")


def test_after_save_and_reload_filters_act_and_the_slider_knows_its_range(tmp_path):
    name = noisy().name
    before = rows(bpy.data.objects[name])
    path = str(tmp_path / "kept.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    obj = bpy.data.objects[name]
    assert rows(obj) == before
    bpy.context.scene.umbilics_display.strength = 1.0
    assert len(rows(obj)) == 4


def test_undo_takes_a_filter_back():
    name = noisy().name
    before = rows(bpy.data.objects[name])
    bpy.ops.ed.undo_push(message="detected")
    bpy.context.scene.umbilics_display.strength = 1.0
    bpy.ops.ed.undo_push(message="filtered")
    assert len(rows(bpy.data.objects[name])) == 4
    bpy.ops.ed.undo()
    assert rows(bpy.data.objects[name]) == before
    assert len(bpy.data.objects[name].umbilics.items) == len(before)
    bpy.ops.ed.redo()
    assert len(rows(bpy.data.objects[name])) == 4


def test_switched_off_and_on_results_can_still_be_filtered(addon):
    obj = noisy()
    addon.unregister()
    addon.register()
    bpy.context.scene.umbilics_display.strength = 1.0
    assert len(rows(obj)) == 4


def test_a_copy_of_the_object_has_results_of_its_own():
    obj = noisy()
    twin = obj.copy()
    twin.data = obj.data.copy()
    bpy.context.scene.collection.objects.link(twin)
    obj.select_set(False)
    twin.select_set(True)
    bpy.context.view_layer.objects.active = twin
    before = rows(obj)
    bpy.context.scene.umbilics_display.strength = 1.0
    assert len(rows(twin)) == 4
    assert rows(obj) == before


def test_foreign_record_is_said_to_be_one(addon):
    obj = noisy()
    obj.umbilics.record, obj.umbilics.stamp = "bm90IGEgcmVjb3Jk", "other"
    stale = addon.operators.scene.staleness
    assert "another version" in stale.reasons(bpy.context, obj)[0]
    bpy.context.scene.umbilics.persistence = 1.0


def test_one_umbilic_is_deleted_restored_and_pinned():
    obj = noisy()
    bpy.context.scene.umbilics_display.strength = 1.0
    obj.umbilics.active = 1
    row = obj.umbilics.items[1].row
    assert [e["umbilics_row"] for e in empties(obj) if e.select_get()] == [row]
    bpy.ops.umbilics.delete_umbilic()
    assert row not in rows(obj)
    assert not obj.umbilics.balanced
    bpy.ops.umbilics.restore_deleted()
    assert row in rows(obj)
    bpy.context.scene.umbilics.persistence = 0.0
    most = obj.umbilics.items
    weak = min(range(len(most)), key=lambda place: most[place].persistence)
    obj.umbilics.active = weak
    row = most[weak].row
    bpy.ops.umbilics.pin()
    bpy.context.scene.umbilics_display.strength = 1.0
    assert row in rows(obj)


def test_clear_leaves_nothing_of_it():
    obj = add_ellipsoid(subdivisions=4)
    before = census()
    bpy.ops.umbilics.detect()
    bpy.ops.umbilics.show_map()
    assert bpy.ops.umbilics.clear() == {"FINISHED"}
    assert census() == before
    assert not len(obj.data.color_attributes)


def test_filters_act_in_edit_mode_and_undo_keeps_slider_list_and_empties_together():
    obj = noisy()
    name, before = obj.name, rows(obj)
    bpy.ops.ed.undo_push(message="detected")
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.ed.undo_push(message="edit mode")
    counts = {0.0: len(before)}
    for strength in (0.9, 1.0):
        bpy.context.scene.umbilics_display.strength = strength
        bpy.ops.ed.undo_push(message="filtered")
        counts[strength] = len(rows(obj))
    assert counts[1.0] == 4 < counts[0.9] < counts[0.0]
    assert obj.mode == "EDIT"
    modes = set()
    for step in (bpy.ops.ed.undo,) * 3 + (bpy.ops.ed.redo,) * 3:
        step()
        obj = bpy.data.objects[name]
        modes.add(obj.mode)
        assert rows(obj) == sorted(item.row for item in obj.umbilics.items)
        strength = bpy.context.scene.umbilics_display.strength
        assert len(rows(obj)) == counts[round(strength, 3)]
    assert modes == {"EDIT", "OBJECT"}
    assert len(rows(obj)) == 4


def test_kinds_chosen_in_edit_mode_are_there_when_it_is_left():
    obj = noisy()
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.context.scene.umbilics_display.kinds = {"star"}
    bpy.ops.object.mode_set(mode="OBJECT")
    assert {empty["umbilics_kind"] for empty in empties(obj)} == {"star"}


def test_what_the_opening_leaves_out_can_be_drawn_hollow(addon):
    obj = noisy()
    live, umbilics = addon.operators.scene.filters, addon.operators.scene.view.umbilic_shapes
    scene = bpy.context.scene
    scene.umbilics_display.dropped = True
    everything = live.shown_rows(obj, scene).tolist()
    assert not len(live.left_out_rows(obj, scene))
    scene.umbilics_display.opened = True
    shown, left_out = live.shown_rows(obj, scene), live.left_out_rows(obj, scene)
    assert 0 < len(left_out) < len(everything)
    assert sorted([*shown, *left_out]) == everything
    assert not set(left_out) & set(rows(obj))
    kinds = set(addon.operators.data.record.of(obj).detection.candidates.kind[left_out])
    scene.umbilics_display.dropped = False
    without = len(umbilics.shapes_of(bpy.context, obj, faint=False))
    scene.umbilics_display.dropped = True
    shapes = umbilics.shapes_of(bpy.context, obj, faint=False)
    assert len(shapes) == without + len(kinds)
    hollow = shapes[: len(kinds)]
    assert all((shape.colour[:, 3] < 1.0).all() for shape in hollow)
    scene.umbilics_display.kinds = {"star"}
    assert set(live.left_out_rows(obj, scene)) <= set(left_out)
    obj.umbilics.pinned = str(left_out[0])
    scene.umbilics_display.kinds = set(addon.core.KINDS)
    assert left_out[0] not in live.left_out_rows(obj, scene)


def test_the_overlay_is_drawn_anew_when_only_what_is_left_out_changes(addon):
    painter = addon.ui.overlay.painter
    obj, scene = noisy(), bpy.context.scene
    live, display = addon.operators.scene.filters, scene.umbilics_display
    display.empties, display.opened, display.dropped = False, True, True
    # Between these two levels only umbilics outside the opened part are dropped.
    candidates = addon.operators.data.record.of(obj).detection.candidates
    levels = np.unique(candidates.persistence[np.isfinite(candidates.persistence)])
    for level in levels:
        before = live.shown_rows(obj, scene), live.left_out_rows(obj, scene)
        signature = painter._signature(bpy.context, obj, False)
        scene.umbilics.persistence = float(np.nextafter(np.float32(level), np.float32(np.inf)))
        after = live.shown_rows(obj, scene), live.left_out_rows(obj, scene)
        if len(before[0]) == len(after[0]) and len(before[1]) != len(after[1]):
            assert painter._signature(bpy.context, obj, False) != signature
            return
    raise AssertionError("every step changes what is shown")


def test_slider_goes_on_from_the_automatic_choice_without_a_jump():
    obj = noisy()
    group, display = bpy.context.scene.umbilics, bpy.context.scene.umbilics_display
    group.persistence_auto = True
    automatic = len(rows(obj))
    assert 4 <= automatic < len(obj.umbilics.items) + obj.umbilics.candidates
    display.strength = display.strength
    assert not group.persistence_auto
    assert abs(len(rows(obj)) - automatic) <= 2


def test_the_sliders_place_under_auto_is_not_searched_at_every_drawing(addon, monkeypatch):
    noisy()
    bpy.context.scene.umbilics.persistence_auto = True
    before = bpy.context.scene.umbilics_display.strength

    def searched(*_):
        raise AssertionError("filtered again")

    monkeypatch.setattr(addon.core, "kept_rows", searched)
    assert bpy.context.scene.umbilics_display.strength == before > 0.0


def test_none_is_active_until_one_is_clicked_nor_when_it_is_filtered_out():
    obj = noisy()
    assert obj.umbilics.active == -1
    assert not bpy.ops.umbilics.pin.poll()
    weak = min(range(len(obj.umbilics.items)), key=lambda at: obj.umbilics.items[at].persistence)
    obj.umbilics.active = weak
    row = obj.umbilics.items[weak].row
    assert bpy.ops.umbilics.pin.poll()
    bpy.context.scene.umbilics_display.strength = 1.0
    assert obj.umbilics.active == -1
    bpy.context.scene.umbilics_display.strength = 0.0
    assert obj.umbilics.items[obj.umbilics.active].row == row
