"""What the user has under names of ours stays as it is, and nothing ends in a traceback."""

import bpy
import numpy as np
import pytest
from scene_building import add_ellipsoid, empties

# Names of ours on meshes, one for each operator that writes them.
NAMES = (
    "umbilics_k1", "umbilics_cross", "umbilics_map", "umbilics_ridge", "umbilics_marked",
    "umbilics_check_angle",
)  # fmt: skip
# Types that results have and types that none has, on all domains.
OTHERS = [("POINT", "INT"), ("EDGE", "FLOAT"), ("FACE", "INT8"), ("CORNER", "BYTE_COLOR")]
OTHERS += [("POINT", "QUATERNION"), ("CORNER", "FLOAT2")]

ALL = (
    "detect", "guide", "lines", "separatrices", "ridges", "mark_seams", "show_map", "apply_filters",
    "check_topology", "show_check", "hide_map", "clear",
)  # fmt: skip


def said_by(name):
    """What an operator refuses with; empty if it does not."""
    operator = getattr(bpy.ops.umbilics, name)
    if not operator.poll():
        return ""
    try:
        operator()
    except RuntimeError as error:
        return str(error)
    return ""


@pytest.mark.parametrize("name", NAMES)
def test_attributes_of_other_types_stay(addon, name):
    obj = add_ellipsoid(subdivisions=2)
    for domain, kind in OTHERS:
        if name == "umbilics_map" and kind == "BYTE_COLOR":  # as ours are
            continue
        mine = obj.data.attributes.new(name, kind, domain)
        values = None
        if kind in ("FLOAT", "INT"):
            values = np.arange(len(mine.data)).astype(np.float32 if kind == "FLOAT" else np.int32)
            mine.data.foreach_set("value", values)
        for operator in ALL:
            assert "Traceback" not in said_by(operator), (operator, domain, kind)
            mine = obj.data.attributes[name]
            assert (mine.domain, mine.data_type) == (domain, kind), operator
            if values is not None:
                found = np.empty_like(values)
                mine.data.foreach_get("value", found)
                np.testing.assert_array_equal(found, values)
        assert not empties(obj)
        left = [one.name for one in obj.data.attributes if one.name.startswith("umbilics_")]
        assert left == [name], (domain, kind)
        obj.data.attributes.remove(obj.data.attributes[name])


# All but the marks of edges: one attribute is all of them.
OF_OUR_TYPES = {
    "umbilics_k1": ("POINT", "FLOAT"),
    "umbilics_d2": ("POINT", "FLOAT_VECTOR"),
    "umbilics_conformal_scale": ("POINT", "FLOAT"),
    "umbilics_scope": ("FACE", "INT"),
    "umbilics_confidence": ("POINT", "FLOAT"),
    "umbilics_cross_face": ("FACE", "FLOAT_VECTOR"),
    "umbilics_ridge": ("EDGE", "INT"),
    "umbilics_check_angle": ("FACE", "FLOAT"),
}


@pytest.mark.parametrize("name", OF_OUR_TYPES)
def test_an_attribute_of_our_type_stays_where_nothing_of_ours_is(addon, name):
    surface = add_ellipsoid(subdivisions=2, name="Surface")
    obj = add_ellipsoid(subdivisions=2)
    surface.select_set(True)
    domain, kind = OF_OUR_TYPES[name]
    mine = obj.data.attributes.new(name, kind, domain)
    key = "vector" if kind == "FLOAT_VECTOR" else "value"
    values = np.arange(len(mine.data) * (3 if key == "vector" else 1))
    values = values.astype(np.int32 if kind == "INT" else np.float32)
    mine.data.foreach_set(key, values)
    refused = []
    for operator in (*ALL, "clear_file"):
        if operator == "check_topology":
            bpy.context.view_layer.objects.active = obj
            surface.select_set(True)
        refused.append(said_by(operator))
        assert "Traceback" not in refused[-1], operator
        found = np.empty_like(values)
        obj.data.attributes[name].data.foreach_get(key, found)
        np.testing.assert_array_equal(found, values, err_msg=operator)
    assert any(f"{name} that is not a result" in text for text in refused)


def test_all_taken_names_are_named_at_once(addon):
    obj = add_ellipsoid(subdivisions=2)
    for name in ("umbilics_k1", "umbilics_gap"):
        obj.data.attributes.new(name, "FLOAT", "POINT")
    assert "umbilics_k1, umbilics_gap" in said_by("detect")


def test_results_of_which_some_were_deleted_are_replaced_and_cleared(addon):
    obj = add_ellipsoid(subdivisions=2)
    bpy.ops.umbilics.detect()
    obj.data.attributes.remove(obj.data.attributes["umbilics_gap"])
    assert bpy.ops.umbilics.detect() == {"FINISHED"}
    obj.data.attributes.remove(obj.data.attributes["umbilics_d1"])
    assert bpy.ops.umbilics.clear() == {"FINISHED"}
    assert not [one.name for one in obj.data.attributes if one.name.startswith("umbilics_")]


def test_a_map_under_a_taken_name_is_refused_in_words(addon):
    obj = add_ellipsoid(subdivisions=2)
    bpy.ops.umbilics.detect()
    colours = obj.data.color_attributes.new("umbilics_map", "FLOAT_COLOR", "POINT")
    before = np.linspace(0.0, 1.0, 4 * len(colours.data)).astype(np.float32)
    colours.data.foreach_set("color", before)
    colours.data.foreach_get("color", before)
    with pytest.raises(RuntimeError, match="umbilics_map that is not a result of Umbilics"):
        bpy.ops.umbilics.show_map()
    after = np.empty_like(before)
    obj.data.color_attributes["umbilics_map"].data.foreach_get("color", after)
    np.testing.assert_array_equal(after, before)
    obj.data.color_attributes["umbilics_map"].name = "Mine"
    assert bpy.ops.umbilics.show_map() == {"FINISHED"}


def test_a_map_that_came_with_a_joined_mesh_is_drawn_anew_and_cleared(addon):
    one, two = add_ellipsoid(subdivisions=2, name="One"), add_ellipsoid(subdivisions=2, name="Two")
    bpy.context.view_layer.objects.active = one
    one.select_set(True)
    two.select_set(False)
    bpy.ops.umbilics.detect()
    bpy.ops.umbilics.show_map()
    two.location.x = 9.0
    two.select_set(True)
    bpy.context.view_layer.objects.active = two
    bpy.ops.object.join()
    assert "umbilics_map" in two.data.attributes
    assert bpy.ops.umbilics.detect() == {"FINISHED"}
    assert bpy.ops.umbilics.show_map() == {"FINISHED"}
    assert bpy.ops.umbilics.hide_map() == {"FINISHED"}
    two.data.color_attributes.new("umbilics_map", "BYTE_COLOR", "POINT")
    assert bpy.ops.umbilics.clear() == {"FINISHED"}
    assert not [one.name for one in two.data.attributes if one.name.startswith("umbilics_")]


def copy_without_a_record(obj, stamped):
    """Another object with the results of one and nothing that tells of them but, if `stamped`, the
    mesh's own word, as of a mesh that came from another file."""
    mesh = obj.data.copy()
    for key in [key for key in mesh.keys() if key.startswith("umbilics")]:  # noqa: SIM118
        if not stamped:
            del mesh[key]
    other = bpy.data.objects.new("Other", mesh)
    bpy.context.collection.objects.link(other)
    bpy.ops.object.select_all(action="DESELECT")
    other.select_set(True)
    bpy.context.view_layer.objects.active = other
    return other


@pytest.mark.parametrize("operator", ["clear", "clear_file"])
@pytest.mark.parametrize(
    ("stamped", "whole", "cleared"),
    [(True, True, True), (True, False, True), (False, True, True), (False, False, False)],
)
def test_results_that_came_with_a_mesh_are_told_by_its_word_or_as_a_whole(
    addon, stamped, whole, cleared, operator
):
    obj = add_ellipsoid(subdivisions=2)
    bpy.ops.umbilics.detect()
    other = copy_without_a_record(obj, stamped)
    if not whole:
        other.data.attributes.remove(other.data.attributes["umbilics_gap"])
    said_by(operator)
    left = [one.name for one in other.data.attributes if one.name.startswith("umbilics_")]
    assert bool(left) != cleared
    assert ("umbilics_k1" in obj.data.attributes) == (operator == "clear")


def test_results_of_an_earlier_version_are_told_by_their_object(addon):
    obj = add_ellipsoid(subdivisions=2)
    bpy.ops.umbilics.detect()
    for key in [key for key in obj.data.keys() if key.startswith("umbilics")]:  # noqa: SIM118
        del obj.data[key]
    obj.data.attributes.remove(obj.data.attributes["umbilics_gap"])
    assert bpy.ops.umbilics.clear() == {"FINISHED"}
    assert not [one.name for one in obj.data.attributes if one.name.startswith("umbilics_")]
