"""A file may come from anywhere: what cannot be read is said in words, and all else goes on."""

import base64
from functools import cache

import bpy
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scene_building import add_ellipsoid, empties


@pytest.fixture
def obj():
    made = add_ellipsoid(subdivisions=2)
    bpy.ops.umbilics.detect()
    bpy.ops.umbilics.guide()
    return made


@pytest.fixture
def record(addon):
    return addon.operators.data.record


def written(record, obj, text):
    """Put a text in the place of the record, with the stamp that belongs to it."""
    obj.umbilics.record = text
    obj.umbilics.stamp = record._digest(text)


def assert_everything_else_goes_on(addon, record, obj):
    """Panels, the overlay's shapes, staleness and the operators, with what is in the file now."""
    context, scene = bpy.context, addon.operators.scene
    record.of(obj)
    scene.staleness.reasons(context, obj)
    scene.staleness.plan_reasons(context, obj)
    scene.filters.shown_rows(obj, context.scene)
    scene.filters.left_out_rows(obj, context.scene)
    scene.view.umbilic_shapes.shapes_of(context, obj, False)
    scene.view.umbilic_shapes.crowds(context, obj, False)
    scene.view.maps.is_dark(obj)
    scene.retopology.guidance_objects.pole_sum(obj)
    assert context.scene.umbilics_display.strength >= 0.0
    for operator in ("pin", "delete_umbilic", "show_map", "hide_map", "guide", "clear", "detect"):
        getattr(bpy.ops.umbilics, operator).poll()
    for operator in ("apply_filters", "guide", "detect", "clear", "detect"):
        if getattr(bpy.ops.umbilics, operator).poll():
            assert getattr(bpy.ops.umbilics, operator)() == {"FINISHED"}, operator
    assert len(empties(obj)) == 4
    assert record.of(obj) is not None


def cut(packed):
    return packed[: len(packed) // 2]


def flipped(packed):
    at = len(packed) // 2
    return packed[:at] + bytes([packed[at] ^ 1]) + packed[at + 1 :]


def npy(_):
    return (
        b"\x93NUMPY\x01\x00v\x00{'descr': '<f8', 'fortran_order': False, 'shape': (1099511627776,)}"
    )


DAMAGES = {
    "nothing": lambda packed: b"",
    "cut": cut,
    "flipped": flipped,
    "a bare array": npy,
    "a zip": lambda packed: b"PK\x03\x04" + packed,
    "lengths beyond all": lambda packed: b"\xff" * 8 + packed[8:],
    "rows beyond all": lambda packed: packed[:28] + b"\xff" * 4 + packed[32:],
    "twice": lambda packed: packed + packed,
}


def test_a_damaged_record_is_said_in_words_and_all_else_goes_on(addon, record, obj):
    whole = base64.b64decode(obj.umbilics.record)
    texts = {what: base64.b64encode(damage(whole)).decode() for what, damage in DAMAGES.items()}
    for what, text in (*texts.items(), *((text, text) for text in ("é", "not base64!", "[" * 999))):
        written(record, obj, text)
        assert record.of(obj) is None, what
        assert addon.operators.scene.staleness.reasons(bpy.context, obj) == [record.UNREADABLE]
    assert_everything_else_goes_on(addon, record, obj)


def test_a_record_that_is_not_the_one_of_its_stamp(addon, record, obj):
    other = add_ellipsoid((2.0, 1.5, 1.0), subdivisions=2)
    bpy.ops.umbilics.detect()
    addon.operators.base.caches.RECORDS.clear()
    obj.umbilics.record = other.umbilics.record
    assert record.of(obj) is None
    assert record.of(other) is not None


def repacked(record, obj, change):
    """The object's record with other words, packed as a record is."""
    packed = base64.b64decode(obj.umbilics.record)
    end = 8 + record._LENGTH.unpack_from(packed)[0]
    words, arrays = record.rows.decode(record._COLUMNS, packed[8:end])
    change(words, arrays)
    beside = record.rows.encode(record._COLUMNS, arrays, words)
    whole = record._LENGTH.pack(len(beside)) + beside + packed[end:]
    return base64.b64encode(whole).decode("ascii")


WORDS = {
    "a singular matrix": {"matrix": np.zeros((4, 4)).tolist()},
    "a flat matrix": {"matrix": np.diag([1.0, 1.0, 0.0, 1.0]).tolist()},
    "an endless matrix": {"matrix": np.full((4, 4), np.inf).tolist()},
    "a matrix of words": {"matrix": [["a"] * 4] * 4},
    "a ragged matrix": {"matrix": [[1.0], [1.0, 2.0]]},
    "no matrix": {"matrix": None},
    "words for a length": {"extent": "1"},
    "a negative length": {"extent": -1.0},
    "an unknown length": {"extent": float("nan")},
    "unknown settings": {"settings": {"method": "Z"}},
    "settings of another add-on": {"settings": {"voxel": 1}},
    "no settings": {"settings": []},
    "names that are none": {"given_names": [1, 2]},
    "a name": {"given_names": "k1"},
}


def test_impossible_words_in_a_record(addon, record, obj):
    whole = obj.umbilics.record
    for what, other in WORDS.items():
        written(record, obj, whole)
        changed = repacked(record, obj, lambda words, arrays, other=other: words.update(other))
        written(record, obj, changed)
        assert record.of(obj) is None, what
    assert_everything_else_goes_on(addon, record, obj)


def test_a_record_without_a_fingerprint_is_out_of_date(addon, record, obj):
    written(record, obj, repacked(record, obj, lambda words, _: words.update(fingerprint=3)))
    assert "moved" in " ".join(addon.operators.scene.staleness.reasons(bpy.context, obj))
    assert_everything_else_goes_on(addon, record, obj)


def test_corners_of_no_vertex_and_edges_that_are_no_length(addon, record, obj):
    for name, value in (("corners", -1), ("edge", np.nan), ("edge", -1.0)):

        def change(words, arrays, name=name, value=value):
            arrays[name] = np.array(arrays[name])
            arrays[name].flat[0] = value

        written(record, obj, repacked(record, obj, change))
        assert record.of(obj) is None, name
        bpy.ops.umbilics.detect()


@settings(max_examples=150)
@given(data=st.data())
def test_any_damage_to_the_text_is_refused(data):
    import importlib

    record = importlib.import_module("bl_ext.user_default.umbilics.operators.data.record")
    text = _text()
    kind = data.draw(st.sampled_from(["cut", "letter", "bit", "any"]))
    if kind == "cut":
        damaged = text[: data.draw(st.integers(0, len(text) - 1))]
    elif kind == "any":
        damaged = data.draw(st.text())
    else:
        at = data.draw(st.integers(0, len(text) - 1))
        letter = data.draw(st.characters(codec="ascii")) if kind == "letter" else "A"
        damaged = text[:at] + letter + text[at + 1 :]
    if damaged != text:
        assert record._decode(damaged, record._digest(damaged)) is None


@cache
def _text():
    """A record's text, made once for all examples."""
    add_ellipsoid(subdivisions=2)
    bpy.ops.umbilics.detect()
    return bpy.context.object.umbilics.record


def test_damaged_properties_beside_the_record(addon, record, obj):
    obj.umbilics.pinned = "1 x -3 99999999999999999999999 2.5 7"
    obj.umbilics.deleted = "\u0661 zero"
    obj.umbilics.items[0].kind = 900
    obj.umbilics.items[1].row = -5
    obj.umbilics.active = 40
    obj.umbilics.source = "NOWHERE"
    obj.umbilics.scope = "NOTHING"
    obj.umbilics_plan.origin = "[[["
    for pole in obj.umbilics_plan.poles:
        pole.name = ""
    for child in obj.children:
        for name in ("umbilics_row", "umbilics_valence", "umbilics_kind"):
            if name in child:
                child[name] = "words"
    mesh = obj.data
    mesh["umbilics_map_shown"] = {"map": "none", "low": "a"}
    mesh["umbilics_colour_before"] = 5
    addon.operators.scene.staleness.reasons(bpy.context, obj)
    told = addon.operators.scene.staleness.plan_reasons(bpy.context, obj)
    assert told == [addon.operators.data.plans.UNREADABLE]
    # A pole that was set by hand to what no pole is cannot be planned with.
    with pytest.raises(RuntimeError, match="a pole has 3 or 5"):
        bpy.ops.umbilics.guide()
    for operator in ("detect", "show_map", "hide_map", "clear"):
        if getattr(bpy.ops.umbilics, operator).poll():
            assert getattr(bpy.ops.umbilics, operator)() == {"FINISHED"}, operator


def test_values_of_no_region_and_no_type_are_shown(obj):
    for name in ("umbilics_region", "umbilics_surface_type"):
        values = np.full(len(obj.data.attributes[name].data), 1000, np.int32)
        values[::2] = -1000
        obj.data.attributes[name].data.foreach_set("value", values)
    for name in ("region", "type"):
        bpy.context.scene.umbilics_display.map = name
        assert bpy.ops.umbilics.show_map() == {"FINISHED"}


@pytest.mark.parametrize(
    "text", ["[[[", "[]", '{"0": 1}', '{"0": {"type": "X"}}', '{"0": {"type": []}}']
)
def test_a_damaged_note_on_how_a_view_was_shaded(addon, text):
    shading = addon.operators.scene.view.view_shading
    screen = bpy.data.screens[0]
    screen["umbilics_shading"] = text
    assert shading._known(screen) == {}
    screen["umbilics_shading"] = 5
    assert shading._known(screen) == {}
    del screen["umbilics_shading"]
