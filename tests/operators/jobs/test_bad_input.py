"""What cannot be done is refused in words, and the file stays as it was."""

import math
import threading

import bpy
import numpy as np
import pytest
from scene_building import add_ellipsoid, add_mesh, add_object, census, empties, result_names


def refusal() -> str:
    """Run the operator, which must refuse; its words."""
    before = census()
    with pytest.raises(RuntimeError) as caught:
        bpy.ops.umbilics.detect()
    assert census() == before
    assert "Traceback" not in str(caught.value)
    return str(caught.value)


def test_no_active_object():
    assert not bpy.ops.umbilics.detect.poll()
    assert "no active object" in refusal()
    assert not bpy.ops.umbilics.clear.poll()


def test_not_a_mesh():
    add_object(bpy.data.cameras.new("Eye"), "Eye")
    assert "Eye is not a mesh" in refusal()


def test_no_faces_at_all():
    add_mesh([], [])
    assert "no faces" in refusal()


def test_wires_only():
    add_mesh([(0, 0, 0), (1, 0, 0), (1, 1, 0)], [], edges=[(0, 1), (1, 2)])
    assert "no faces" in refusal()


def test_no_faces_left_in_edit_mode():
    obj = add_mesh([(0, 0, 0), (1, 0, 0), (1, 1, 0)], [(0, 1, 2)])
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.delete(type="ONLY_FACE")
    assert "no faces" in refusal()
    assert obj.mode == "EDIT"


def test_flattened_by_a_scale_of_zero():
    add_ellipsoid(subdivisions=2).scale.z = 0.0
    assert "scale of zero" in refusal()


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_coordinate_that_is_no_number(value):
    obj = add_ellipsoid(subdivisions=3)
    obj.data.attributes["position"].data[5].vector = (value, 0.0, 0.0)
    before = census()
    try:
        outcome = bpy.ops.umbilics.detect()
    except RuntimeError as error:
        assert "Traceback" not in str(error)
        assert census() == before
    else:
        assert outcome == {"FINISHED"}
        assert obj.umbilics.warnings
        data = obj.data.attributes["umbilics_k1"].data
        assert all(math.isfinite(item.value) for item in data)


def test_a_place_that_is_no_number():
    add_ellipsoid(subdivisions=2).location.x = math.nan
    assert "stands nowhere" in refusal()


def test_ridges_of_a_mesh_with_a_vertex_that_is_no_place():
    obj = add_ellipsoid(subdivisions=3)
    obj.data.attributes["position"].data[5].vector = (math.nan, 0.0, 0.0)
    assert bpy.ops.umbilics.detect() == {"FINISHED"}
    assert bpy.ops.umbilics.ridges() == {"FINISHED"}
    assert bpy.ops.umbilics.mark_seams(lines="RIDGES") == {"FINISHED"}


def test_single_triangle_gives_no_umbilics_and_says_something():
    obj = add_mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
    try:
        assert bpy.ops.umbilics.detect() == {"FINISHED"}
    except RuntimeError as error:
        assert "Traceback" not in str(error)
    assert not empties(obj)


BAD_MESHES = {
    "zero area": ([(0, 0, 0), (1, 0, 0), (2, 0, 0)], [(0, 1, 2)]),
    "duplicate faces": ([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2), (0, 1, 2)]),
    "three faces at an edge": (
        [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1)],
        [(0, 1, 2), (1, 0, 3), (0, 1, 4)],
    ),
    "pinched vertex": (
        [(0, 0, 0), (1, 0, 0), (0, 1, 0), (-1, 0, 0), (0, -1, 0)],
        [(0, 1, 2), (0, 3, 4)],
    ),
    "opposite windings": ([(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)], [(0, 1, 2), (1, 2, 3)]),
    "all in one point": (np.zeros((4, 3)), [(0, 1, 2), (0, 2, 3)]),
}


@pytest.mark.parametrize("name", BAD_MESHES)
def test_broken_mesh_never_ends_in_a_traceback(name):
    obj = add_mesh(*BAD_MESHES[name])
    before = census()
    try:
        assert bpy.ops.umbilics.detect() == {"FINISHED"}
    except RuntimeError as error:
        assert "Traceback" not in str(error)
        assert census() == before
    else:
        assert len(result_names(obj)) == 8


def test_broken_part_of_a_good_mesh_is_warned_of():
    obj = add_ellipsoid(subdivisions=4)
    count = len(obj.data.vertices)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.object.mode_set(mode="OBJECT")
    import bmesh

    work = bmesh.new()
    work.from_mesh(obj.data)
    work.verts.ensure_lookup_table()
    edge = next(iter(work.edges))
    fin = work.verts.new((9.0, 9.0, 9.0))
    work.faces.new((edge.verts[0], edge.verts[1], fin))
    work.to_mesh(obj.data)
    work.free()
    assert bpy.ops.umbilics.detect() == {"FINISHED"}
    assert obj.umbilics.warnings
    assert len(obj.data.attributes["umbilics_k1"].data) == count + 1


@pytest.mark.parametrize(("domain", "kind"), [("CORNER", "FLOAT"), ("POINT", "INT")])
def test_users_attribute_of_the_same_name_is_kept(domain, kind):
    obj = add_ellipsoid(subdivisions=2)
    obj.data.attributes.new("umbilics_gap", kind, domain)
    assert "umbilics_gap" in refusal()
    assert obj.data.attributes["umbilics_gap"].domain == domain


def test_vertex_group_of_the_same_name():
    add_ellipsoid(subdivisions=2).vertex_groups.new(name="umbilics_k1")
    assert "vertex group umbilics_k1" in refusal()


def test_missing_given_attribute():
    add_ellipsoid(subdivisions=2)
    bpy.context.scene.umbilics.curvature = "given"
    words = refusal()
    assert "'k1'" in words
    assert "Jets" in words


def test_given_attribute_of_another_type():
    obj = add_ellipsoid(subdivisions=2)
    obj.data.attributes.new("k1", "FLOAT", "FACE")
    bpy.context.scene.umbilics.curvature = "given"
    assert "domain Face" in refusal()


def test_settings_that_do_not_fit():
    add_ellipsoid(subdivisions=2)
    bpy.context.scene.umbilics.curvature = "given"
    bpy.context.scene.umbilics.normal_smoothing = 2
    assert "smoothing" in refusal()


def test_missing_uv_map():
    obj = add_ellipsoid(subdivisions=2)
    while obj.data.uv_layers:
        obj.data.uv_layers.remove(obj.data.uv_layers[0])
    bpy.context.scene.umbilics.method = "C"
    bpy.context.scene.umbilics.charts = "uv"
    assert "UV map" in refusal()


def test_mesh_that_changes_meanwhile(addon):
    engine = addon.operators.jobs.detect
    obj = add_ellipsoid(subdivisions=3)
    inputs = engine.gather(obj, addon.core.Settings())
    detection = engine.compute(inputs)
    obj.data.attributes["position"].data[0].vector.x += 0.5
    before = census()
    with pytest.raises(addon.core.UmbilicsError, match="changed"):
        engine.write(bpy.context, inputs, engine.results_of(inputs, detection))
    assert census() == before


def test_object_that_disappears_meanwhile(addon):
    engine = addon.operators.jobs.detect
    obj = add_ellipsoid(subdivisions=3)
    inputs = engine.gather(obj, addon.core.Settings())
    detection = engine.compute(inputs)
    bpy.data.objects.remove(obj)
    with pytest.raises(addon.core.UmbilicsError, match="no longer there"):
        engine.write(bpy.context, inputs, engine.results_of(inputs, detection))


def test_run_can_be_cancelled_and_leaves_no_thread(addon):
    engine, running = addon.operators.jobs.detect, addon.operators.jobs.worker
    obj = add_ellipsoid(subdivisions=5)
    before = census()
    run = running.begin(engine.gather(obj, addon.core.Settings()))
    assert not bpy.ops.umbilics.detect.poll()
    run.cancel()
    running.end()
    assert run.finished
    with pytest.raises(addon.core.CancelledError):
        run.results()
    assert running.current() is None
    assert census() == before
    assert all(thread.name != "umbilics" for thread in threading.enumerate())


def test_modifiers_that_make_nothing_but_instances():
    """Also of a mesh that has no faces itself, for which filling it would be no way."""
    for faces in ([], [(0, 1, 2)]):
        obj = add_mesh([(0, 0, 0), (1, 0, 0), (1, 1, 0)], faces)
        tree = bpy.data.node_groups.new("Instances", "GeometryNodeTree")
        tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
        points, instances, end = (
            tree.nodes.new(name)
            for name in (
                "GeometryNodeMeshLine",
                "GeometryNodeInstanceOnPoints",
                "NodeGroupOutput",
            )
        )
        cube = tree.nodes.new("GeometryNodeMeshCube")
        tree.links.new(points.outputs["Mesh"], instances.inputs["Points"])
        tree.links.new(cube.outputs["Mesh"], instances.inputs["Instance"])
        tree.links.new(instances.outputs["Instances"], end.inputs[0])
        obj.modifiers.new("Instances", "NODES").node_group = tree
        assert "Realize the instances" in refusal()
