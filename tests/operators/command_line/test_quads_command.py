"""--quads on the command line: the mesh, its figures, one file and batches, and what is refused."""

import json

import bpy
import numpy as np
import pytest
from batch_files import needs_program, write_ellipsoid
from scene_building import add_ellipsoid


def quads_in(path):
    """Vertices and quads of an OBJ file."""
    rows = [row.split() for row in path.read_text().splitlines()]
    vertices = np.array([row[1:] for row in rows if row[0] == "v"], float)
    faces = [row[1:] for row in rows if row[0] == "f"]
    assert {len(face) for face in faces} == {4}
    return vertices, np.array(faces, int) - 1


def test_the_mesh_and_its_figures(run, tmp_path, capsys):
    add_ellipsoid((1.5, 1.0, 0.7), subdivisions=4)
    report = tmp_path / "r.json"
    assert run("--quads", 300, "--guide", tmp_path / "o", "--json", report) == 0
    vertices, quads = quads_in(tmp_path / "o" / "Ellipsoid-quads.obj")
    assert np.bincount(np.bincount(quads.ravel()))[3] == 8
    said = json.loads(report.read_text())["objects"][0]["quads"]
    assert (said["asked"], said["quads"], said["faces"]) == (300, len(quads), len(quads))
    assert abs(said["quads"] - 300) < 60
    assert said["vertices"] == len(vertices)
    assert (said["irregular"], said["matched"], said["missing"], said["extra"]) == (8, 8, 0, 0)
    assert 0.0 <= said["angle"] < 5.0
    assert 0.3 < said["jacobian"]["least"] <= said["jacobian"]["mean"] <= 1.0
    assert said["distance"]["mean"] <= said["distance"]["largest"] < 0.05 * said["edge"]
    assert "8 of 8 planned poles" in capsys.readouterr().out
    # The guidance is written as it would be without.
    assert (tmp_path / "o" / "Ellipsoid.rosy").exists()


def test_settings_of_the_remeshing_have_names_of_their_own(run, tmp_path):
    add_ellipsoid((1.5, 1.0, 0.7), subdivisions=4)
    report = tmp_path / "r.json"
    options = ["--symmetry", "x", "--relaxation", 3, "--quad-smoothness", "0.6", "--smoothness", 0]
    kinds = ["--guide-files", "quads_ply"]
    done = run("--quads", 200, *options, *kinds, "--guide", tmp_path / "o", "--json", report)
    assert done == 0
    assert [path.name for path in (tmp_path / "o").iterdir()] == ["Ellipsoid-quads.ply"]
    bpy.ops.wm.read_homefile(use_empty=True)
    path = str(tmp_path / "o" / "Ellipsoid-quads.ply")
    bpy.ops.wm.ply_import(filepath=path, forward_axis="Y", up_axis="Z")
    made = bpy.context.selected_objects[0].data
    places = {tuple(round(c, 5) for c in vertex.co) for vertex in made.vertices}
    assert all((round(-x, 5) + 0.0, y, z) in places for x, y, z in places)
    assert run("--quads", 200, "--quad-smoothness", 2, "--guide", tmp_path / "o") == 2
    assert run("--quads", 7, "--guide", tmp_path / "o") == 2


def test_an_edge_length_takes_the_place_of_a_number(run, tmp_path):
    add_ellipsoid((1.5, 1.0, 0.7), subdivisions=4)
    report = tmp_path / "r.json"
    kinds = ["--guide-files", "quads", "--edge-length", 0.25]
    assert run(*kinds, "--guide", tmp_path / "o", "--json", report) == 0
    said = json.loads(report.read_text())["objects"][0]["quads"]
    assert said["asked"] is None
    assert said["edge"] == pytest.approx(0.25, rel=0.15)


def test_without_a_folder_it_is_refused(run, capfd):
    add_ellipsoid(subdivisions=2)
    assert run("--quads", 300) == 2
    assert "--quads needs a folder" in capfd.readouterr().err


def test_no_input_is_overwritten_and_no_two_results_meet(run, tmp_path, capfd):
    write_ellipsoid(tmp_path / "x-quads.obj")
    write_ellipsoid(tmp_path / "x.obj")
    before = (tmp_path / "x-quads.obj").read_bytes()
    files = [tmp_path / "x.obj", tmp_path / "x-quads.obj"]
    assert run(*files, "--quads", 300, "--guide", tmp_path) == 2
    assert "would overwrite" in capfd.readouterr().err
    assert (tmp_path / "x-quads.obj").read_bytes() == before
    write_ellipsoid(tmp_path / "a" / "x.obj")
    write_ellipsoid(tmp_path / "b" / "x.obj")
    files = [tmp_path / "a" / "x.obj", tmp_path / "b" / "x.obj"]
    assert run(*files, "--quads", 300, "--guide", tmp_path / "o") == 2
    assert "written twice" in capfd.readouterr().err
    assert not (tmp_path / "o").exists()


def test_what_cannot_be_remeshed_is_said_and_nothing_is_written(run, addon, tmp_path, monkeypatch):
    def fails(*_, **__):
        raise addon.core.RemeshError("No quads today.")

    add_ellipsoid(subdivisions=2)
    monkeypatch.setattr(addon.core.formats.export, "remesh", fails)
    report = tmp_path / "r.json"
    assert run("--quads", 300, "--guide", tmp_path / "o", "--json", report) == 1
    assert not (tmp_path / "o").exists() or not list((tmp_path / "o").iterdir())


@needs_program
def test_a_batch_makes_quads_beside_each_report_and_resumes(said_by, tmp_path):
    for name, third in (("one", 1.0), ("two", 1.2)):
        write_ellipsoid(tmp_path / "in" / f"{name}.obj", third)
    out = tmp_path / "out"

    def batch(*more):
        # Of the folder that the results are in, too: they are no meshes of the next run.
        code, said = said_by(tmp_path, "--out", out, "--resume", *more)
        assert code == 0, said
        return said

    options = ["--quads", 150, "--relaxation", 3]
    assert "2 files to do" in batch(*options)
    made = out / "in"
    for name in ("one", "two"):
        _, quads = quads_in(made / f"{name}.obj" / f"{name}-quads.obj")
        assert [path.name for path in (made / f"{name}.obj").iterdir()] == [f"{name}-quads.obj"]
        said = json.loads((made / f"{name}.obj.json").read_text())["objects"][0]["quads"]
        assert (said["asked"], said["quads"]) == (150, len(quads))
    assert "0 files to do, 2 done before" in batch(*options)
    (made / "two.obj" / "two-quads.obj").unlink()
    assert "1 files to do, 1 done before" in batch(*options)
    assert "2 files to do" in batch("--quads", 150, "--relaxation", 4)
    # Nothing unfinished is left.
    assert not list(out.rglob(".umbilics-*"))
