"""umbilics.detect: what it finds, where it stores it, and that it can be repeated and undone."""

import bpy
import numpy as np
import pytest
from mathutils import Matrix
from scene_building import (
    add_ellipsoid,
    add_mesh,
    census,
    ellipsoid_umbilics,
    empties,
    empty_scene,
    places,
    result_names,
    values,
)

RESULTS = {
    "umbilics_k1": ("POINT", "FLOAT"),
    "umbilics_k2": ("POINT", "FLOAT"),
    "umbilics_gap": ("POINT", "FLOAT"),
    "umbilics_d1": ("POINT", "FLOAT_VECTOR"),
    "umbilics_d2": ("POINT", "FLOAT_VECTOR"),
    "umbilics_surface_type": ("POINT", "INT"),
    "umbilics_index": ("FACE", "FLOAT"),
    "umbilics_region": ("FACE", "INT"),
}


def test_ellipsoid_has_four_lemons_where_theory_says():
    obj = add_ellipsoid()
    assert bpy.ops.umbilics.detect() == {"FINISHED"}
    assert [empty["umbilics_kind"] for empty in empties(obj)] == ["lemon"] * 4
    assert np.abs(places(obj) - ellipsoid_umbilics()).max() < 0.03
    summary = obj.umbilics
    assert (summary.lemon, summary.star, summary.index_sum, summary.balanced) == (4, 0, 2.0, True)


def test_empty_says_what_and_where_it_is():
    obj = add_ellipsoid()
    bpy.ops.umbilics.detect()
    bpy.context.view_layer.update()
    for empty in empties(obj):
        place = np.array(empty.matrix_world.translation)
        corners = np.array([obj.data.vertices[i].co for i in empty["umbilics_vertices"]])
        weights = np.array(empty["umbilics_barycentric"])
        assert np.abs(weights @ corners - place).max() < 1e-5
        obj.data.calc_loop_triangles()
        triangle = obj.data.loop_triangles[empty["umbilics_triangle"]]
        assert list(triangle.vertices) == list(empty["umbilics_vertices"])
        z = np.array(empty.matrix_world.to_3x3().col[2])
        outward = place / np.array([9.0, 4.0, 1.0])
        assert z @ outward / np.linalg.norm(outward) > 0.999
        # At an umbilic of the ellipsoid both curvatures are a c / b³.
        assert empty["umbilics_curvature"] == pytest.approx(3.0 / 8.0, rel=0.02)
        assert empty["umbilics_index"] == 0.5
        assert empty["umbilics_persistence"] > 0.0
        assert all(type(empty[key]) is float for key in ("umbilics_index", "umbilics_curvature"))
        edge = np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1).mean()
        assert 0.5 * edge < empty.empty_display_size < 10.0 * edge


def test_kinds_are_told_apart_by_colour_and_by_glyph(addon):
    obj = add_mesh(*wavy_sphere())
    bpy.ops.umbilics.detect()
    shown = {}
    for empty in empties(obj):
        look = (tuple(empty.color), empty.data["umbilics_glyph"])
        assert shown.setdefault(empty["umbilics_kind"], look) == look
        assert empty.empty_display_type == "IMAGE"
    assert {"lemon", "star"} <= set(shown)
    assert len(set(shown.values())) == len(shown)
    assert all(image.packed_file for image in bpy.data.images if "umbilics_glyph" in image)


def wavy_sphere():
    """Vertices and faces of a sphere with bumps: lemons and stars."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=5, radius=1.0)
    mesh = bpy.context.object.data
    points = np.array([vertex.co for vertex in mesh.vertices])
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    x, y, z = points.T
    points *= 1.0 + 0.3 * (np.sin(3 * x) * np.sin(3 * y + 1) * np.sin(3 * z + 2))[:, None]
    return points, [tuple(polygon.vertices) for polygon in mesh.polygons]


def test_attributes_are_of_the_documented_kind_and_finite():
    obj = add_ellipsoid()
    bpy.ops.umbilics.detect()
    found = {name: obj.data.attributes[name] for name in RESULTS}
    assert {name: (a.domain, a.data_type) for name, a in found.items()} == RESULTS
    assert all(np.isfinite(values(obj, name)).all() for name in RESULTS)
    gap = values(obj, "umbilics_k1") - values(obj, "umbilics_k2")
    assert np.abs(gap - values(obj, "umbilics_gap")).max() < 1e-5
    assert gap.min() >= 0.0
    d1, d2 = values(obj, "umbilics_d1"), values(obj, "umbilics_d2")
    assert np.abs(np.linalg.norm(d1, axis=1) - 1.0).max() < 1e-5
    assert np.abs(np.sum(d1 * d2, axis=1)).max() < 1e-5
    index = values(obj, "umbilics_index")
    assert sorted(index[index != 0.0]) == [0.5] * 4


def test_again_replaces_own_results_and_nothing_else():
    obj = add_ellipsoid()
    mine = bpy.data.objects.new("Lemon.mine", None)
    mine.parent = obj
    bpy.context.scene.collection.objects.link(mine)
    decoy = bpy.data.collections.new("Umbilics of Ellipsoid")
    bpy.context.scene.collection.children.link(decoy)
    bpy.ops.umbilics.detect()
    first = census()
    own = next(c for c in bpy.data.collections if "umbilics" in c)
    own.name = "Renamed"
    own.objects.link(mine)
    bpy.ops.umbilics.detect()
    again = census()
    assert again["objects"] == first["objects"]
    assert sorted(again["collections"]) == ["Renamed", "Umbilics of Ellipsoid"]
    assert mine.name in own.objects
    assert len(own.objects) == 5
    assert not decoy.objects


def test_two_objects_have_results_of_their_own():
    first = add_ellipsoid(name="First")
    bpy.ops.umbilics.detect()
    second = add_ellipsoid(name="Second", subdivisions=4)
    bpy.ops.umbilics.detect()
    assert len(empties(first)) == len(empties(second)) == 4
    owners = [c for c in bpy.data.collections if "umbilics" in c]
    assert len(owners) == 2
    bpy.ops.umbilics.clear()
    assert len(empties(first)) == 4
    assert not empties(second)


def test_results_do_not_keep_a_deleted_object_alive():
    obj = add_ellipsoid(subdivisions=3)
    users = obj.users
    bpy.ops.umbilics.detect()
    assert obj.users == users


def test_clear_leaves_the_file_as_it_was():
    obj = add_ellipsoid()
    before = census()
    bpy.ops.umbilics.detect()
    assert census() != before
    assert bpy.ops.umbilics.clear() == {"FINISHED"}
    assert census() == before
    assert not obj.umbilics.detected
    assert bpy.ops.umbilics.clear() == {"CANCELLED"}


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
def test_one_undo_takes_all_back_and_redo_brings_it_again(mode):
    add_ellipsoid(subdivisions=4)
    bpy.ops.ed.undo_push(message="made")
    bpy.ops.object.mode_set(mode=mode)
    bpy.ops.ed.undo_push(message="mode")
    before = census()["objects"]
    bpy.ops.umbilics.detect()
    if mode == "OBJECT":
        # In the window Blender does this; in Edit Mode the operator has done it.
        bpy.ops.ed.undo_push(message="detected")
    detected = census()["objects"]
    assert len(detected) == 5
    bpy.ops.ed.undo()
    assert census()["objects"] == before
    assert bpy.context.object.mode == mode
    assert not bpy.context.object.umbilics.detected
    bpy.ops.ed.redo()
    assert census()["objects"] == detected
    assert bpy.context.object.umbilics.detected


def test_edit_mode_sees_unapplied_changes_and_stays_in_edit_mode():
    obj = add_ellipsoid(radii=(1.0, 1.0, 1.0))
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.transform.resize(value=(3.0, 2.0, 1.0))
    bpy.ops.mesh.select_all(action="DESELECT")
    assert bpy.ops.umbilics.detect() == {"FINISHED"}
    assert obj.mode == "EDIT"
    bpy.ops.object.mode_set(mode="OBJECT")
    assert np.abs(places(obj) - ellipsoid_umbilics()).max() < 0.03
    assert set(result_names(obj)) == set(RESULTS)
    assert len(values(obj, "umbilics_k1")) == len(obj.data.vertices)


def test_edit_mode_of_several_objects_is_restored():
    first = add_ellipsoid(name="First", subdivisions=3)
    second = add_ellipsoid(name="Second", subdivisions=3)
    third = add_ellipsoid(name="Third", subdivisions=3)
    first.select_set(True)
    bpy.ops.object.mode_set(mode="EDIT")
    assert (first.mode, second.mode, third.mode) == ("EDIT", "OBJECT", "EDIT")
    bpy.ops.umbilics.detect()
    assert (first.mode, second.mode, third.mode) == ("EDIT", "OBJECT", "EDIT")
    assert bpy.context.view_layer.objects.active == third
    assert [first.select_get(), second.select_get(), third.select_get()] == [True, False, True]


def detected_under(matrix, radii):
    """Umbilics in the world and curvatures of an ellipsoid, seen through a transform."""
    empty_scene()
    obj = add_ellipsoid(radii)
    obj.matrix_world = matrix
    bpy.ops.umbilics.detect()
    return places(obj), values(obj, "umbilics_k1"), values(obj, "umbilics_k2"), obj


def test_non_uniform_scale_gives_what_applying_it_gives():
    scaled = detected_under(Matrix.Diagonal((3.0, 2.0, 1.0, 1.0)), (1.0, 1.0, 1.0))
    applied = detected_under(Matrix.Identity(4), (3.0, 2.0, 1.0))
    for ours, wanted in zip(scaled[:3], applied[:3], strict=True):
        assert np.abs(ours - wanted).max() < 1e-3


@pytest.mark.parametrize("size", [1e-15, 1e15])
def test_a_scale_of_any_size_is_one(size):
    """Three such numbers multiplied are none in single precision."""
    obj = add_ellipsoid(subdivisions=3)
    obj.scale = 3 * [size]
    bpy.context.view_layer.update()
    assert bpy.ops.umbilics.detect() == {"FINISHED"}
    assert obj.umbilics.lemon == 4
    places = np.array([child.matrix_world.translation for child in obj.children]) / size
    assert np.linalg.norm(places[:, None] - ellipsoid_umbilics(), axis=2).min(axis=1).max() < 0.15
    bpy.ops.umbilics.guide()


def test_mirrored_object_keeps_its_outside():
    upright = detected_under(Matrix.Identity(4), (3.0, 2.0, 1.0))
    mirrored = detected_under(Matrix.Diagonal((-1.0, 1.0, 1.0, 1.0)), (3.0, 2.0, 1.0))
    assert np.abs(upright[1] - mirrored[1]).max() < 1e-3
    assert mirrored[1].min() > 0.0
    obj = mirrored[3]
    for empty in empties(obj):
        normal = empty.matrix_world.to_3x3().col[2]
        assert normal.dot(empty.matrix_world.translation) > 0.0
        corners = [obj.data.vertices[i].co for i in empty["umbilics_vertices"]]
        weights = empty["umbilics_barycentric"]
        local = sum((w * c for w, c in zip(weights, corners, strict=True)), corners[0] * 0.0)
        assert (obj.matrix_world @ local - empty.matrix_world.translation).length < 1e-5


def test_empties_are_not_sheared_and_follow_the_object():
    matrix = Matrix.Rotation(0.7, 4, (1.0, 2.0, 3.0)) @ Matrix.Diagonal((3.0, 2.0, 1.0, 1.0))
    obj = detected_under(matrix, (1.0, 1.0, 1.0))[3]
    before = places(obj)
    for empty in empties(obj):
        axes = np.array(empty.matrix_world.to_3x3())
        assert np.abs(axes.T @ axes - np.eye(3)).max() < 1e-4
    obj.location.x += 10.0
    after = places(obj)
    assert sorted(after[:, 0] - 10.0) == pytest.approx(sorted(before[:, 0]), abs=1e-4)


def test_stored_directions_are_right_under_the_objects_transform():
    obj = detected_under(Matrix.Diagonal((3.0, 2.0, 1.0, 1.0)), (1.0, 1.0, 1.0))[3]
    world = np.array(obj.matrix_world)[:3, :3]
    d1 = values(obj, "umbilics_d1") @ world.T
    d2 = values(obj, "umbilics_d2") @ world.T
    cosine = np.sum(d1 * d2, axis=1) / np.linalg.norm(d1, axis=1) / np.linalg.norm(d2, axis=1)
    assert np.abs(cosine).max() < 1e-4


def test_quads_and_ngons_are_cut_without_new_vertices():
    bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24)
    obj = bpy.context.object
    obj.scale = (3.0, 2.0, 1.0)
    count = len(obj.data.vertices)
    faces = len(obj.data.polygons)
    assert bpy.ops.umbilics.detect() == {"FINISHED"}
    assert len(obj.data.vertices) == count
    assert len(values(obj, "umbilics_index")) == faces
    assert obj.umbilics.index_sum == 2.0
    assert values(obj, "umbilics_index").sum() == pytest.approx(2.0)


def test_single_ngon_is_read():
    angle = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
    ring = np.column_stack([np.cos(angle), np.sin(angle), 0.05 * np.cos(2.0 * angle)])
    obj = add_mesh(ring, [range(12)])
    assert bpy.ops.umbilics.detect() == {"FINISHED"}
    assert len(values(obj, "umbilics_index")) == 1


def test_multi_user_mesh():
    obj = add_ellipsoid(subdivisions=4)
    twin = obj.copy()
    bpy.context.scene.collection.objects.link(twin)
    twin.select_set(False)
    assert bpy.ops.umbilics.detect() == {"FINISHED"}
    assert obj.data == twin.data
    assert len(empties(obj)) == 4
    assert not empties(twin)


def test_hidden_object_can_be_active():
    obj = add_ellipsoid(subdivisions=4)
    obj.hide_viewport = True
    bpy.context.view_layer.objects.active = obj
    assert bpy.ops.umbilics.detect() == {"FINISHED"}
    assert len(empties(obj)) == 4


def test_isolated_vertices_keep_their_place_and_are_zero():
    obj = add_ellipsoid(subdivisions=4)
    obj.data.vertices.add(2)
    bpy.ops.umbilics.detect()
    assert len(empties(obj)) == 4
    for name in ("umbilics_k1", "umbilics_k2", "umbilics_d1"):
        assert not values(obj, name)[-2:].any()


def test_given_attributes_are_used():
    obj = add_ellipsoid()
    bpy.ops.umbilics.detect()
    wanted = places(obj)
    group = bpy.context.scene.umbilics
    group.curvature = "given"
    for name in ("k1", "k2", "d1", "d2"):
        setattr(group, f"given_{name}", f"umbilics_{name}")
    assert bpy.ops.umbilics.detect() == {"FINISHED"}
    assert np.abs(places(obj) - wanted).max() < 0.03


def test_marked_edges_and_corners_reach_the_core(addon):
    """Seams, sharp edges and UVs of a mesh of quads, mirrored and not."""
    bpy.ops.mesh.primitive_cube_add()
    obj = bpy.context.object
    obj.data.edges[3].use_seam = True
    obj.data.edges[5].use_edge_sharp = True
    for sign in (1.0, -1.0):
        obj.scale.x = sign
        bpy.context.view_layer.update()
        arrays = addon.operators.mesh.read.read_mesh(obj, with_uv=True)
        assert arrays.seams.tolist() == [list(obj.data.edges[3].vertices)]
        assert arrays.sharp.tolist() == [list(obj.data.edges[5].vertices)]
        layer = obj.data.uv_layers.active
        for triangle, corners in zip(arrays.triangles, arrays.uv, strict=True):
            for vertex, uv in zip(triangle, corners, strict=True):
                at_vertex = [
                    tuple(layer.uv[loop.index].vector)
                    for loop in obj.data.loops
                    if loop.vertex_index == vertex
                ]
                assert tuple(uv) in at_vertex
        a, b, c = (arrays.vertices[arrays.triangles[:, k]] for k in range(3))
        outward = np.sum(np.cross(b - a, c - a) * (a + b + c), axis=1)
        assert (outward > 0.0).all()
        assert arrays.polygon.tolist() == sorted([0, 1, 2, 3, 4, 5] * 2)
