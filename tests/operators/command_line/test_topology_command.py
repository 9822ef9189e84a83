"""--check-topology: quads of a file or of the open scene held against a surface."""

import json
import shutil

import bpy
import numpy as np
import pytest
from batch_files import needs_program, write_ellipsoid
from mesh_files import write_obj
from scene_building import add_ellipsoid, add_mesh

RADII = np.array((3.0, 2.0, 1.0))


def cube_on_ellipsoid(size=8):
    """Vertices and quads of a cube blown up to an ellipsoid: eight vertices of valence 3."""
    bpy.ops.wm.read_homefile(use_empty=True)
    bpy.ops.mesh.primitive_cube_add(size=2.0)
    obj = bpy.context.object
    obj.modifiers.new("Subdivision", "SUBSURF").subdivision_type = "SIMPLE"
    obj.modifiers[0].levels = int(np.log2(size))
    bpy.ops.object.modifier_apply(modifier="Subdivision")
    points = np.array([vertex.co for vertex in obj.data.vertices])
    points *= RADII / np.linalg.norm(points, axis=1, keepdims=True)
    return points, np.array([polygon.vertices[:] for polygon in obj.data.polygons])


def topology_in(report):
    return json.loads(report.read_text())["objects"][0]["topology"]


@pytest.fixture
def files(tmp_path):
    """surface.obj, an ellipsoid, and quads.obj, a cube on it."""
    write_ellipsoid(tmp_path / "surface.obj")
    write_obj(tmp_path / "quads.obj", *cube_on_ellipsoid())
    return tmp_path


def test_a_file_against_a_surface(run, files, capsys):
    report = files / "r.json"
    surface, quads = files / "surface.obj", files / "quads.obj"
    assert run(surface, "--check-topology", quads, "--json", report) == 0
    said = topology_in(report)
    assert said["checked"] == str(quads)
    assert (said["quads"], said["faces"], said["vertices"]) == (384, 384, 386)
    assert said["irregular"] == len(said["irregular_vertices"]) == 8
    assert said["matched"] + said["extra"] == 8 == said["matched"] + said["missing"]
    assert said["missing"] == len(said["missing_poles"])
    assert sum(one["planned"] for one in said["irregular_vertices"]) == said["matched"]
    for one in said["irregular_vertices"]:
        assert one["valence"] == 3
        # A corner of the cube.
        assert np.abs(one["position"]) == pytest.approx(RADII / np.sqrt(3.0), abs=1e-4)
    assert said["folded"] == 0 and 0.0 < said["distance"]["from_surface"] < said["edge"]
    assert 0.0 < said["angle"] < 45.0 and 0.0 < said["jacobian"]["least"] < 1.0
    assert f"Topology of {quads}: {said['matched']} of 8 planned poles" in capsys.readouterr().out


def test_files_turned_otherwise_meet_in_the_coordinates_of_the_file(run, files):
    """A glTF has y up, and Blender turns it; its numbers are those of the OBJ."""
    bpy.ops.wm.read_homefile(use_empty=True)
    bpy.ops.wm.obj_import(filepath=str(files / "surface.obj"), forward_axis="Y", up_axis="Z")
    bpy.ops.export_scene.gltf(filepath=str(files / "s.glb"), export_yup=False)
    report = files / "r.json"
    assert run(files / "s.glb", "--check-topology", files / "quads.obj", "--json", report) == 0
    assert topology_in(report)["distance"]["largest"] < 0.3


def test_an_object_of_the_open_scene_is_checked_and_is_no_surface(run, tmp_path):
    vertices, quads = cube_on_ellipsoid()
    bpy.ops.wm.read_homefile(use_empty=True)
    add_mesh(vertices, quads, "Retopo")
    add_ellipsoid(subdivisions=3)
    report = tmp_path / "r.json"
    assert run("--check-topology", "Retopo", "--json", report) == 0
    assert topology_in(report)["irregular"] == 8
    objects = json.loads(report.read_text())["objects"]
    assert [one["object"] for one in objects] == ["Ellipsoid"]
    assert run("--check-topology", "Nothing", "--json", report) == 1


def test_of_a_folder_the_mesh_of_the_same_name(run, files, capfd):
    shutil.copy(files / "surface.obj", files / "other.obj")
    (files / "retopo").mkdir()
    shutil.copy(files / "quads.obj", files / "retopo" / "surface.obj")
    out = files / "out"
    both = [files / "surface.obj", files / "other.obj"]
    assert run(*both, "--check-topology", files / "retopo", "--json", out) == 1
    assert topology_in(out / "surface.json")["irregular"] == 8
    assert "no mesh is called other there" in capfd.readouterr().err


def test_what_cannot_be_checked_is_said_and_what_is_checked_is_no_result(run, files, capfd):
    surface, quads = files / "surface.obj", files / "quads.obj"
    assert run(surface, "--check-topology", files / "none.obj") == 2
    assert "there is no such file" in capfd.readouterr().err
    before = quads.read_bytes()
    assert run(surface, "--check-topology", quads, "--ply", quads) == 2
    assert "would overwrite" in capfd.readouterr().err
    assert quads.read_bytes() == before
    (files / "points.obj").write_text("v 0 0 0\nv 1 0 0\nl 1 2\n")
    assert run(surface, "--check-topology", files / "points.obj") == 1
    assert "no faces to check" in capfd.readouterr().err
    assert run(surface, "--check-topology", quads, "--smoothness", 2) == 2


@needs_program
def test_a_batch_checks_and_knows_when_the_checked_mesh_is_another(said_by, files):
    out = files / "out"

    def batch():
        surface, quads = files / "surface.obj", files / "quads.obj"
        code, said = said_by(surface, "--check-topology", quads, "--out", out, "--resume")
        assert code == 0, said
        return said

    assert "1 files to do" in batch()
    assert topology_in(out / "surface.obj.json")["irregular"] == 8
    assert "0 files to do, 1 done before" in batch()
    with open(files / "quads.obj", "a") as file:
        file.write("# another\n")
    assert "1 files to do" in batch()
