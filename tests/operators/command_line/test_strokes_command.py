"""--strokes: guide strokes and poles of a file steer the plan of the command line."""

import json
import shutil

import bpy
import numpy as np
import pytest
from mesh_files import write_obj

RADII = np.array((3.0, 2.0, 1.0))


@pytest.fixture
def surface(tmp_path):
    """An ellipsoid with half axes 3, 2 and 1, of 5,120 triangles."""
    bpy.ops.wm.read_homefile(use_empty=True)
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=5)
    mesh = bpy.context.object.data
    points = np.array([vertex.co for vertex in mesh.vertices])
    points *= RADII / np.linalg.norm(points, axis=1, keepdims=True)
    path = tmp_path / "surface.obj"
    write_obj(path, points, np.array([polygon.vertices[:] for polygon in mesh.polygons]))
    return path


def across(folder, **more):
    """A file with a stroke over the top of the ellipsoid, at 45 degrees to its lines."""
    t = np.linspace(-0.3, 0.3, 9)
    top = np.stack([t, t, np.sqrt(1 - t**2 / 9 - t**2 / 4)], axis=1)
    path = folder / "hand.json"
    path.write_text(json.dumps({"strokes": [{"points": top.tolist()}], **more}))
    return path


def crosses_at_the_top(path):
    """Degrees between the crosses near the top and the diagonal, at most 45."""
    rows = [line.split() for line in path.with_suffix(".rosy").read_text().splitlines()[2:]]
    directions = np.array(rows, float)
    points, faces = [], []
    for line in path.with_suffix(".obj").read_text().splitlines():
        if line.startswith("v "):
            points.append(line.split()[1:4])
        elif line.startswith("f "):
            faces.append([int(word.partition("/")[0]) - 1 for word in line.split()[1:]])
    middle = np.array(points, float)[np.array(faces)].mean(axis=1)
    near = (middle[:, 2] > 0) & (np.hypot(middle[:, 0], middle[:, 1]) < 0.3)
    assert near.any()
    off = np.degrees(np.arctan2(directions[near, 1], directions[near, 0])) - 45.0
    return np.abs((off + 45.0) % 90.0 - 45.0)


def test_strokes_steer_the_files_and_the_report_says_so(run, surface, tmp_path):
    hand, report = across(tmp_path), tmp_path / "r.json"
    free, steered = tmp_path / "free", tmp_path / "steered"
    assert run(surface, "--guide", free, "--json", report) == 0
    found = json.loads(report.read_text())["objects"][0]
    assert "steering" not in found
    assert found["plan"] == {"valence_3": 8, "valence_5": 0, "warnings": []}
    assert run(surface, "--guide", steered, "--strokes", hand, "--json", report) == 0
    (name,) = (path.stem for path in steered.glob("*.rosy"))
    assert np.median(crosses_at_the_top(free / name)) > 30.0
    assert np.median(crosses_at_the_top(steered / name)) < 10.0
    said = json.loads(report.read_text())["objects"][0]["steering"]
    assert said == {"file": str(hand), "strokes": 1, "poles": None, "warnings": []}
    # Narrow ones count less far.
    narrow = tmp_path / "narrow"
    words = ("--strokes", hand, "--stroke-influence", 0.001)
    assert run(surface, "--guide", narrow, *words) == 0
    off = crosses_at_the_top(narrow / name)
    assert np.median(off) > np.median(crosses_at_the_top(steered / name))


def test_poles_of_a_file_are_those_of_the_plan(run, surface, tmp_path):
    written = tmp_path / "g"
    assert run(surface, "--guide", written, "--guide-files", "json") == 0
    (poles,) = written.glob("*-poles.json")
    content = json.loads(poles.read_text())
    assert len(content["poles"]) == 8
    moved = content["poles"][0]
    moved |= {"x": 0.0, "y": 0.0, "z": 1.0}
    poles.write_text(json.dumps(content))
    again, report = tmp_path / "again", tmp_path / "r.json"
    words = ("--guide-files", "json", "--strokes", poles, "--json", report)
    assert run(surface, "--guide", again, *words) == 0
    (found,) = again.glob("*-poles.json")
    planned = json.loads(found.read_text())["poles"]
    places = np.array([[one[axis] for axis in "xyz"] for one in planned])
    assert len(places) == 8
    assert np.linalg.norm(places - [0, 0, 1], axis=1).min() < 0.2
    assert json.loads(report.read_text())["objects"][0]["steering"]["poles"] == 8


def test_a_file_that_is_turned_otherwise_is_steered_in_its_own_numbers(run, surface, tmp_path):
    """A glTF has y up, and Blender turns it."""
    bpy.ops.wm.read_homefile(use_empty=True)
    bpy.ops.wm.obj_import(filepath=str(surface), forward_axis="Y", up_axis="Z")
    bpy.ops.export_scene.gltf(filepath=str(tmp_path / "s.glb"), export_yup=False)
    out = tmp_path / "g"
    assert run(tmp_path / "s.glb", "--guide", out, "--strokes", across(tmp_path)) == 0
    (path,) = out.glob("*.rosy")
    assert np.median(crosses_at_the_top(path)) < 10.0


def test_of_a_folder_the_file_of_the_same_name(run, surface, tmp_path, capfd):
    shutil.copy(surface, tmp_path / "other.obj")
    (tmp_path / "hands").mkdir()
    across(tmp_path).rename(tmp_path / "hands" / "surface.json")
    words = ("--guide", tmp_path / "g", "--strokes", tmp_path / "hands", "--guide-files", "rosy")
    assert run(surface, tmp_path / "other.obj", *words) == 1
    assert "no file is called other there, for --strokes" in capfd.readouterr().err
    assert len(list((tmp_path / "g").glob("*.rosy"))) == 1


def test_what_cannot_be_is_said(run, surface, tmp_path, capfd):
    guide = ("--guide", tmp_path / "g")
    hand = across(tmp_path)
    assert run(surface, "--strokes", hand) == 2
    assert "--strokes needs a plan" in capfd.readouterr().err
    assert run(surface, *guide, "--strokes", tmp_path / "none.json") == 2
    assert "there is no such file" in capfd.readouterr().err
    assert run(surface, *guide, "--strokes", hand, "--stroke-influence", 2) == 2
    assert run(surface, *guide, "--strokes", hand, "--json", hand) == 2
    assert "would overwrite" in capfd.readouterr().err
    hand.write_text("{")
    assert run(surface, *guide, "--strokes", hand) == 1
    assert "is not JSON" in capfd.readouterr().err
    across(tmp_path, poles=[{"position": [0, 0, 1], "valence": 3}])
    bpy.ops.wm.read_homefile(use_empty=True)
    for x in (0, 5):
        bpy.ops.mesh.primitive_uv_sphere_add(location=(x, 0, 0))
    assert run(*guide, "--strokes", hand) == 1
    assert "name it with --object" in capfd.readouterr().err


def test_what_a_plan_lacks_is_in_the_report_and_in_the_summary(run, part, tmp_path):
    """It was said on the terminal alone, and in batches nowhere."""
    bpy.ops.wm.read_homefile(use_empty=True)
    bpy.ops.mesh.primitive_cube_add()
    mesh = bpy.context.object.data
    path, report = tmp_path / "cube.obj", tmp_path / "r.json"
    points = np.array([vertex.co for vertex in mesh.vertices])
    write_obj(path, points, np.array([polygon.vertices[:] for polygon in mesh.polygons]))
    words = ("--guide-files", "csv", "lines", "--json", report)
    assert run(path, "--guide", tmp_path / "guide", *words) == 0
    plan = json.loads(report.read_text())["objects"][0]["plan"]
    assert (plan["valence_3"], plan["valence_5"]) == (8, 0)
    assert any("no preferred direction" in sentence for sentence in plan["warnings"])
    (entry,) = part("batch.summary").objects_in(report.read_bytes())
    assert set(plan["warnings"]) <= set(entry["warnings"])
