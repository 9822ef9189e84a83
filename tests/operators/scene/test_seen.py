"""What is seen is what is analysed, and the user's object stays as and where it is."""

import bmesh
import bpy
import numpy as np
import pytest
from scene_building import (
    add_ellipsoid,
    add_object,
    census,
    ellipsoid_umbilics,
    empties,
    places,
    result_names,
    values,
)


def close_to_theory(obj, reach=0.05):
    return len(empties(obj)) == 4 and np.abs(places(obj) - ellipsoid_umbilics()).max() < reach


def subdivided(subdivisions=3, levels=1):
    """A coarse ellipsoid under a Subdivision modifier, which makes more vertices of it."""
    obj = add_ellipsoid(subdivisions=subdivisions)
    obj.modifiers.new("Subdivision", "SUBSURF").levels = levels
    bpy.context.view_layer.update()
    return obj


def state(obj):
    """What must not change of the user's object."""
    return (
        obj.mode,
        obj.hide_get(),
        obj.hide_viewport,
        obj.select_get(),
        bpy.context.view_layer.objects.active == obj,
        obj.data.name,
        [vertex.co[:] for vertex in obj.data.vertices],
        [modifier.name for modifier in obj.modifiers],
    )


def own_meshes():
    return [mesh for mesh in bpy.data.meshes if mesh.name.startswith("Umbilics of")]


def test_subdivision_is_analysed_and_the_object_stays_as_it_is():
    obj = subdivided()
    before, file = state(obj), census()
    assert bpy.ops.umbilics.detect() == {"FINISHED"}
    assert state(obj) == before
    assert obj.umbilics.analysed == "With Subdivision, whole object"
    assert len(empties(obj)) == 4
    assert not result_names(obj), "its vertices are not those that were analysed"
    assert [other.type for other in bpy.context.scene.objects].count("MESH") == 1
    (mesh,) = own_meshes()
    assert len(mesh.vertices) > 3 * len(obj.data.vertices)
    assert len(mesh.attributes["umbilics_k1"].data) == len(mesh.vertices)
    # Again, and there is still one mesh of ours; cleared, and there is none.
    assert bpy.ops.umbilics.detect() == {"FINISHED"}
    assert len(own_meshes()) == 1
    assert bpy.ops.umbilics.clear() == {"FINISHED"}
    assert state(obj) == before
    assert census() == file


@pytest.mark.parametrize("kind", ["SMOOTH", "ARMATURE", "CAST"])
def test_modifiers_that_keep_the_vertices_leave_results_with_them(kind):
    obj = add_ellipsoid(subdivisions=3)
    obj.modifiers.new("Modifier", kind)
    assert bpy.ops.umbilics.detect() == {"FINISHED"}
    assert "umbilics_k1" in result_names(obj)
    assert not own_meshes()


def half_an_ellipsoid():
    """Its umbilics lie on the plane that a Mirror modifier mirrors at."""
    obj = add_ellipsoid(subdivisions=5)
    work = bmesh.new()
    work.from_mesh(obj.data)
    bmesh.ops.bisect_plane(
        work,
        geom=work.verts[:] + work.edges[:] + work.faces[:],
        dist=1e-4,
        plane_co=(0, 0, 0),
        plane_no=(0, 1, 0),
        clear_outer=True,
    )
    work.to_mesh(obj.data)
    work.free()
    obj.modifiers.new("Mirror", "MIRROR").use_axis = (False, True, False)
    return obj


def test_half_a_model_with_a_mirror_has_the_umbilics_of_the_whole():
    obj = half_an_ellipsoid()
    assert bpy.ops.umbilics.detect() == {"FINISHED"}
    # The cut leaves slivers along the plane: within an edge is all that can be asked.
    assert close_to_theory(obj, reach=0.1)


def test_shape_keys_give_the_same_in_object_and_in_edit_mode(addon):
    obj = add_ellipsoid(radii=(1.0, 1.0, 1.0), subdivisions=5)
    obj.shape_key_add(name="Basis")
    key = obj.shape_key_add(name="Long")
    for point, vertex in zip(key.data, obj.data.vertices, strict=True):
        point.co = (3.0 * vertex.co.x, 2.0 * vertex.co.y, vertex.co.z)
    key.value = 1.0
    assert bpy.ops.umbilics.detect() == {"FINISHED"}
    assert close_to_theory(obj)
    # The key that is edited is another one than the mixture that is seen.
    obj.active_shape_key_index = 0
    bpy.ops.object.mode_set(mode="EDIT")
    assert bpy.ops.umbilics.detect() == {"FINISHED"}
    assert obj.mode == "EDIT"
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.context.view_layer.update()
    assert close_to_theory(obj)
    assert not addon.operators.scene.staleness.reasons(bpy.context, obj)


def test_a_posed_rig_has_its_umbilics_on_the_posed_surface():
    obj = add_ellipsoid(subdivisions=5)
    rig = add_object(bpy.data.armatures.new("Rig"), "Rig")
    bpy.ops.object.mode_set(mode="EDIT")
    bone = rig.data.edit_bones.new("Bone")
    bone.tail = (0.0, 0.0, 1.0)
    bpy.ops.object.mode_set(mode="OBJECT")
    group = obj.vertex_groups.new(name="Bone")
    group.add(list(range(len(obj.data.vertices))), 1.0, "REPLACE")
    obj.modifiers.new("Armature", "ARMATURE").object = rig
    rig.pose.bones["Bone"].location = (0.0, 5.0, 0.0)
    bpy.context.view_layer.objects.active = obj
    bpy.context.view_layer.update()
    assert bpy.ops.umbilics.detect() == {"FINISHED"}
    # A bone along z: its own y is the world's z.
    assert np.abs(places(obj) - ellipsoid_umbilics() - (0.0, 0.0, 5.0)).max() < 0.05


def test_geometry_nodes_that_make_the_surface_are_analysed():
    obj = add_object(bpy.data.meshes.new("Nothing"), "Nothing")
    group = bpy.data.node_groups.new("Sphere", "GeometryNodeTree")
    group.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    sphere = group.nodes.new("GeometryNodeMeshIcoSphere")
    sphere.inputs["Subdivisions"].default_value = 5
    stretched = group.nodes.new("GeometryNodeTransform")
    stretched.inputs["Scale"].default_value = (3.0, 2.0, 1.0)
    group.links.new(sphere.outputs[0], stretched.inputs["Geometry"])
    group.links.new(stretched.outputs[0], group.nodes.new("NodeGroupOutput").inputs[0])
    obj.modifiers.new("Nodes", "NODES").node_group = group
    bpy.context.view_layer.update()
    assert bpy.ops.umbilics.detect() == {"FINISHED"}
    assert len(empties(obj)) == 4
    assert not obj.data.vertices


def test_multires_is_analysed_as_it_is_seen():
    obj = add_ellipsoid(subdivisions=3)
    obj.modifiers.new("Multires", "MULTIRES")
    bpy.ops.object.multires_subdivide(modifier="Multires")
    assert bpy.ops.umbilics.detect() == {"FINISHED"}
    assert len(own_meshes()[0].vertices) > 3 * len(obj.data.vertices)


def excluded(obj):
    """Put an object into a collection that the view layer leaves out."""
    away = bpy.data.collections.new("Away")
    bpy.context.scene.collection.children.link(away)
    away.objects.link(obj)
    bpy.context.scene.collection.objects.unlink(obj)
    bpy.context.view_layer.layer_collection.children["Away"].exclude = True
    bpy.context.view_layer.update()


def test_a_source_outside_the_view_layer_is_refused_in_words():
    obj = subdivided()
    bpy.ops.umbilics.detect()
    bpy.ops.umbilics.show_map()
    display = next(child for child in obj.children if child.type == "MESH")
    excluded(obj)
    stamp = obj.umbilics.stamp
    bpy.context.view_layer.objects.active = display
    with pytest.raises(RuntimeError, match="not in this view layer"):
        bpy.ops.umbilics.detect()
    assert obj.umbilics.stamp == stamp


def hidden_in_viewports(obj):
    obj.hide_viewport = True


def hidden_by_the_eye(obj):
    obj.hide_set(True)


def hidden_with_its_collection(obj):
    away = bpy.data.collections.new("Away")
    bpy.context.scene.collection.children.link(away)
    away.objects.link(obj)
    bpy.context.scene.collection.objects.unlink(obj)
    away.hide_viewport = True


@pytest.mark.parametrize(
    "hide", [hidden_in_viewports, hidden_by_the_eye, hidden_with_its_collection]
)
def test_a_hidden_object_is_analysed_as_it_would_be_seen(hide):
    obj = subdivided()
    hide(obj)
    bpy.context.view_layer.objects.active = obj
    # Blender evaluates nothing that is hidden: what it last made is not what is wanted.
    obj.modifiers[0].levels = 2
    objects = set(bpy.data.objects)
    assert bpy.ops.umbilics.detect() == {"FINISHED"}
    assert set(bpy.data.objects) == objects | set(empties(obj))
    assert len(own_meshes()[0].vertices) > 12 * len(obj.data.vertices)


def test_undo_takes_results_beside_the_object_back_and_redo_brings_them_again():
    obj = subdivided()
    bpy.ops.ed.undo_push(message="made")
    bpy.ops.umbilics.detect()
    bpy.ops.umbilics.show_map()
    bpy.ops.ed.undo_push(message="detected")
    name, shown = obj.name, census()["objects"]
    bpy.ops.ed.undo()
    assert census()["objects"] == [name]
    assert not bpy.data.objects[name].umbilics.detected
    bpy.ops.ed.redo()
    assert census()["objects"] == shown
    obj = bpy.data.objects[name]
    assert len(empties(obj)) == 4
    assert len(obj.umbilics.mesh.attributes["umbilics_k1"].data) == len(obj.umbilics.mesh.vertices)


def test_results_beside_the_object_stay_in_the_file(tmp_path):
    obj = subdivided()
    bpy.ops.umbilics.detect()
    name, path = obj.name, str(tmp_path / "file.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    obj = bpy.data.objects[name]
    assert "umbilics_k1" in obj.umbilics.mesh.attributes
    assert bpy.ops.umbilics.show_map() == {"FINISHED"}


def test_a_plan_is_made_of_what_is_seen_and_marks_are_refused_in_words():
    obj = subdivided()
    bpy.ops.umbilics.detect()
    assert bpy.ops.umbilics.guide() == {"FINISHED"}
    assert obj.umbilics_plan.planned
    assert not result_names(obj)
    with pytest.raises(RuntimeError, match="Apply its modifiers"):
        bpy.ops.umbilics.mark_seams()
    assert bpy.ops.umbilics.clear() == {"FINISHED"}
    assert not own_meshes()


def test_strokes_lie_where_the_modifiers_put_the_surface(addon):
    obj = add_ellipsoid(subdivisions=3)
    moved = obj.modifiers.new("Displace", "DISPLACE")
    moved.direction, moved.mid_level, moved.strength = "X", 0.0, 2.0
    bpy.context.view_layer.update()
    bpy.ops.umbilics.detect()
    where, *_ = addon.operators.scene.view.direction_fields.read_field(obj)
    assert where[:, 0].mean() == pytest.approx(2.0, abs=1e-3)


def test_strokes_of_a_subdivided_object_are_those_of_its_surface(addon):
    obj = subdivided()
    bpy.ops.umbilics.detect()
    where, d1, *_ = addon.operators.scene.view.direction_fields.read_field(obj)
    assert len(where) == len(d1) > 3 * len(obj.data.vertices)


def test_an_instance_of_a_collection_is_refused_in_words():
    kept = bpy.data.collections.new("Kept")
    kept.objects.link(bpy.data.objects.new("Inside", bpy.data.meshes.new("Inside")))
    instance = add_object(None, "Instance")
    instance.instance_type, instance.instance_collection = "COLLECTION", kept
    with pytest.raises(RuntimeError, match=r"Instance is not a mesh.*Make Instances Real"):
        bpy.ops.umbilics.detect()


@pytest.mark.parametrize(
    ("data", "words"),
    [
        ("armatures", "armature moves"),
        ("curves", "Convert > Mesh"),
        ("cameras", r"Choose a mesh\.\s*$"),
    ],
)
def test_what_is_no_mesh_is_refused_with_what_can_be_done(data, words):
    kind = {"type": "CURVE"} if data == "curves" else {}
    add_object(getattr(bpy.data, data).new("Other", **kind), "Other")
    with pytest.raises(RuntimeError, match=f"Other is not a mesh.*{words}"):
        bpy.ops.umbilics.detect()


def test_geometry_nodes_that_leave_instances_alone_are_refused_in_words():
    obj = add_ellipsoid(subdivisions=2)
    tree = bpy.data.node_groups.new("Instances", "GeometryNodeTree")
    for way in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Mesh", in_out=way, socket_type="NodeSocketGeometry")
    kinds = ("NodeGroupInput", "GeometryNodeGeometryToInstance", "NodeGroupOutput")
    first, middle, last = map(tree.nodes.new, kinds)
    tree.links.new(first.outputs[0], middle.inputs[0])
    tree.links.new(middle.outputs[0], last.inputs[0])
    obj.modifiers.new("Nodes", "NODES").node_group = tree
    with pytest.raises(RuntimeError, match="Realize the instances"):
        bpy.ops.umbilics.detect()


def test_each_scene_sees_the_object_as_its_own_view_layer_does():
    obj = subdivided()
    other = bpy.data.scenes.new("Other")
    other.collection.objects.link(obj)
    bpy.ops.umbilics.detect()
    count = len(obj.umbilics.items)
    with bpy.context.temp_override(scene=other, view_layer=other.view_layers[0]):
        other.view_layers[0].objects.active = obj
        assert bpy.ops.umbilics.detect() == {"FINISHED"}
        assert other.umbilics_display.source == "EVALUATED"
    assert len(obj.umbilics.items) == len(empties(obj)) == count
    assert len(own_meshes()) == 1


# Objects that share a mesh.


def shared():
    """Two objects with one mesh, the second twice as large."""
    first = add_ellipsoid(subdivisions=4, name="First")
    second = bpy.data.objects.new("Second", first.data)
    bpy.context.scene.collection.objects.link(second)
    second.location.x, second.scale = 10.0, (2.0, 2.0, 2.0)
    bpy.context.view_layer.update()
    return first, second


def home(addon, obj):
    return addon.operators.scene.homes.mesh_of(obj)


def largest_k1(addon, obj):
    found = home(addon, obj).attributes["umbilics_k1"]
    read = np.empty(len(found.data), np.float32)
    found.data.foreach_get("value", read)
    return float(read.max())


def select(*objects):
    for obj in bpy.context.view_layer.objects:
        obj.select_set(obj in objects)
    bpy.context.view_layer.objects.active = objects[0]


@pytest.mark.parametrize("together", [True, False])
@pytest.mark.parametrize("source", ["EVALUATED", "BASE"])
def test_objects_that_share_a_mesh_have_results_of_their_own(addon, together, source):
    bpy.context.scene.umbilics_display.source = source
    first, second = shared()
    for objects in ((first, second),) if together else ((first,), (second,), (first,)):
        select(*objects)
        assert bpy.ops.umbilics.detect() == {"FINISHED"}
    # At the tip of the ellipsoid 3:2:1 the larger curvature is a / c² = 3.
    assert largest_k1(addon, first) == pytest.approx(3.0, rel=0.05)
    assert largest_k1(addon, second) == pytest.approx(1.5, rel=0.05)
    select(second)
    bpy.ops.umbilics.clear()
    assert largest_k1(addon, first) == pytest.approx(3.0, rel=0.05)
    assert len(empties(first)) == 4
    select(first)
    bpy.ops.umbilics.clear()
    assert not result_names(first)
    assert not own_meshes()


def test_clear_on_the_first_leaves_the_second_what_is_its_own(addon):
    first, second = shared()
    select(first, second)
    bpy.ops.umbilics.detect()
    select(first)
    bpy.ops.umbilics.clear()
    assert not first.umbilics.detected
    assert largest_k1(addon, second) == pytest.approx(1.5, rel=0.05)


def test_a_linked_duplicate_keeps_results_that_the_other_clears(addon):
    first = add_ellipsoid(subdivisions=4)
    bpy.ops.umbilics.detect()
    second = first.copy()
    bpy.context.scene.collection.objects.link(second)
    select(first)
    bpy.ops.umbilics.clear()
    assert largest_k1(addon, second) == pytest.approx(3.0, rel=0.05)
    select(second)
    bpy.ops.umbilics.clear()
    assert not result_names(second)


def test_a_map_of_one_does_not_colour_the_other(addon):
    first, second = shared()
    select(first)
    bpy.ops.umbilics.detect()
    bpy.ops.umbilics.show_map()
    assert not first.data.color_attributes
    assert "umbilics_map" in home(addon, first).color_attributes
    assert largest_k1(addon, first) == pytest.approx(3.0, rel=0.05)
    bpy.ops.umbilics.hide_map()
    bpy.ops.umbilics.clear()
    assert not own_meshes()
    assert values(second, "position").shape == (len(first.data.vertices), 3)
