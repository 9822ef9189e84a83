"""Align to Other, Find Rotation Axis, and --align-to and --find-symmetry on the command line."""

import json

import bpy
import numpy as np
import pytest
from mathutils import Matrix
from scene_building import add_ellipsoid, add_mesh
from surfaces.blobs import blob, random_sphere, star
from surfaces.sampling import icosphere

POSE = Matrix.Translation((3.0, -1.0, 2.0)) @ Matrix.Rotation(0.8, 4, (0.3, 1.0, 0.4))


def add_blob(seed, name):
    points, triangles = random_sphere(2500, seed)
    return add_mesh(blob(points, seed), triangles, name=name)


def add_scan(name, scale=1.0):
    """Blob 3 on other points, elsewhere."""
    points, triangles = icosphere(4)
    obj = add_mesh(blob(points, 3), triangles, name=name)
    obj.matrix_world = POSE @ Matrix.Scale(scale, 4)
    bpy.context.view_layer.update()
    return obj


def select(active, *others):
    for obj in bpy.context.view_layer.objects:
        obj.select_set(obj in (active, *others))
    bpy.context.view_layer.objects.active = active


def off(obj):
    """How far the object is from where it came from."""
    return float(np.abs(np.array(obj.matrix_world) - np.eye(4)).max())


def test_a_mesh_is_brought_onto_the_other_selected_one():
    first, scan = add_blob(3, "First"), add_scan("Scan")
    places = [tuple(vertex.co) for vertex in scan.data.vertices]
    select(scan, first)
    assert bpy.ops.umbilics.align_to_other() == {"FINISHED"}
    assert off(scan) < 2e-3
    assert off(first) == 0.0
    assert [tuple(vertex.co) for vertex in scan.data.vertices] == places


def test_of_several_it_goes_to_the_one_that_it_is_in_its_size():
    others = [add_blob(4, "Four"), add_blob(3, "Three")]
    others[0].location.x = 20.0
    scan = add_scan("Scan", scale=2.5)
    select(scan, *others)
    assert bpy.ops.umbilics.align_to_other(scaled=True) == {"FINISHED"}
    assert off(scan) < 4e-3


def test_what_it_cannot_do_it_says_and_moves_nothing():
    first, other = add_blob(3, "First"), add_blob(4, "Other")
    select(first)
    with pytest.raises(RuntimeError, match="Select the mesh"):
        bpy.ops.umbilics.align_to_other()
    select(first, other)
    with pytest.raises(RuntimeError, match="not the same"):
        bpy.ops.umbilics.align_to_other()
    assert off(first) == off(other) == 0.0


def test_in_edit_mode_one_undo_takes_it_back(addon):
    first, scan = add_blob(3, "First"), add_scan("Scan")
    select(scan, first)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.ed.undo_push(message="in Edit Mode")
    matching = addon.operators.jobs.matching
    job = matching.gather(bpy.context, False)
    matching.move(bpy.context, job, job.compute())
    assert off(scan) < 2e-3
    assert bpy.context.mode == "EDIT_MESH"
    bpy.ops.ed.undo()
    bpy.context.view_layer.update()
    assert off(bpy.data.objects["Scan"]) > 1.0


def test_the_axis_stands_in_the_scene_and_goes_with_clear():
    points, triangles = random_sphere(1500, 5)
    obj = add_mesh(star(points, 5), triangles, name="Star")
    assert bpy.ops.umbilics.rotation_symmetry() == {"FINISHED"}
    bpy.context.view_layer.update()
    (empty,) = [child for child in obj.children if child.get("umbilics_guidance") == "axis"]
    assert empty["umbilics_order"] == 5
    assert abs(empty.matrix_world.col[2].to_3d().normalized().z) > 0.9999
    assert "Order 5" in obj.umbilics_plan.axis
    bpy.ops.umbilics.clear()
    assert not obj.children
    assert not obj.umbilics_plan.axis


@pytest.mark.usefixtures("here")
def test_the_command_says_which_mesh_it_is(run, tmp_path, capfd):
    for seed in (3, 4):
        bpy.ops.wm.read_homefile(use_empty=True)
        add_blob(seed, f"Blob{seed}")
        bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / f"{seed}.blend"), copy=True)
    bpy.ops.wm.read_homefile(use_empty=True)
    scan = add_scan("Scan", scale=2.0)
    wanted = np.linalg.inv(np.array(scan.matrix_world))
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scan.blend"), copy=True)
    target = tmp_path / "out.json"
    references = [f"--align-to={tmp_path / f'{seed}.blend'}" for seed in (4, 3)]
    arguments = [str(tmp_path / "scan.blend"), *references, "--align-scaled"]
    assert run(*arguments, "--json", str(target)) == 0
    assert "It is Blob3" in capfd.readouterr().out
    (entry,) = json.loads(target.read_text())["objects"]
    four, three = entry["alignment"]
    assert four["object"] == "Blob4"
    assert three["same"]
    assert not four["same"] or four["score"] < 0.5 * three["score"]
    assert three["scale"] == pytest.approx(0.5, abs=2e-3)
    np.testing.assert_allclose(three["matrix"], wanted, atol=4e-3)


@pytest.mark.usefixtures("here")
def test_the_command_says_what_brings_a_mesh_onto_itself(run, tmp_path):
    add_ellipsoid(subdivisions=4, name="Egg")
    file, target = tmp_path / "egg.blend", tmp_path / "out.json"
    bpy.ops.wm.save_as_mainfile(filepath=str(file), copy=True)
    assert run(str(file), "--find-symmetry", "--json", str(target)) == 0
    (entry,) = json.loads(target.read_text())["objects"]
    assert max(np.abs(entry["symmetry"]["mirror"]["normal"])) > 0.9999
    assert entry["symmetry"]["rotation"]["order"] == 2
    assert max(np.abs(entry["symmetry"]["rotation"]["axis"])) > 0.999


def test_arguments_that_need_others(run, capsys):
    assert run("--align-to", "other.obj") == 2
    assert "needs the FILE" in capsys.readouterr().err
    assert run("mine.obj", "--align-to", "other.obj") == 2
    assert "--align-to other.obj: there is no such file" in capsys.readouterr().err
    assert run("--align-scaled") == 2
