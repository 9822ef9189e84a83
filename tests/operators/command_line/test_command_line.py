"""blender -b --command umbilics: files in, JSON, .blend and PNG out, and its exit codes."""

import json
import os
import subprocess

import bpy
import numpy as np
import pytest
from scene_building import add_ellipsoid, add_mesh, ellipsoid_umbilics, empties, empty_scene

PLACE = np.array([1.0, 2.0, 3.0])


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """The same ellipsoid, moved, in every kind of file."""
    empty_scene()
    folder = tmp_path_factory.mktemp("files")
    obj = add_ellipsoid(subdivisions=5, name="Egg")
    obj.location = PLACE
    bpy.context.view_layer.update()
    axes = {"forward_axis": "Y", "up_axis": "Z"}
    bpy.ops.wm.obj_export(filepath=str(folder / "egg.obj"), export_materials=False, **axes)
    # With a UV map the exporter would cut the mesh open along its seams.
    bpy.ops.wm.ply_export(filepath=str(folder / "egg.ply"), export_uv=False, **axes)
    bpy.ops.wm.stl_export(filepath=str(folder / "egg.stl"), **axes)
    bpy.ops.export_scene.gltf(filepath=str(folder / "egg.glb"))
    bpy.ops.export_scene.gltf(filepath=str(folder / "egg.gltf"), export_format="GLTF_SEPARATE")
    bpy.ops.export_scene.fbx(filepath=str(folder / "egg.fbx"))
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "egg.blend"), copy=True)
    return folder


def in_file(points: np.ndarray, suffix: str) -> np.ndarray:
    """World points as the file writes them: glTF and FBX have y up, FBX counts centimetres."""
    if suffix in ("glb", "gltf", "fbx"):
        points = points[:, (0, 2, 1)] * (1.0, 1.0, -1.0)
    return points * 100.0 if suffix == "fbx" else points


@pytest.mark.parametrize("suffix", ["obj", "ply", "stl", "glb", "gltf", "fbx", "blend"])
def test_positions_are_those_of_the_file(run, files, tmp_path, suffix):
    target = tmp_path / "out.json"
    assert run(str(files / f"egg.{suffix}"), "--json", str(target)) == 0
    (entry,) = json.loads(target.read_text())["objects"]
    assert entry["triangles"] == 5120
    assert entry["vertices"] == 2562
    found = np.array([umbilic["position"] for umbilic in entry["umbilics"]])
    wanted = in_file(ellipsoid_umbilics() + PLACE, suffix)
    scale = 100.0 if suffix == "fbx" else 1.0
    away = np.linalg.norm(found[:, None] - wanted[None], axis=2)
    assert len(found) == 4
    assert away.min(axis=0).max() < 0.1 * scale


def test_json_is_what_the_manual_says(run, files, tmp_path):
    target = tmp_path / "deep" / "out.json"
    arguments = [str(files / "egg.obj"), "--json", str(target), "--per-vertex"]
    assert run(*arguments, "--persistence", "0", "--crease-angle", "90") == 0
    found = json.loads(target.read_text(), parse_constant=pytest.fail)
    assert found["schema"] == 1
    assert found["settings"]["method"] == "S"
    assert found["settings"]["persistence"] == 0.0
    assert found["settings"]["crease_angle"] == 90.0
    (entry,) = found["objects"]
    assert entry["counts"] == {"star": 0, "lemon": 4, "monstar": 0, "compound": 0, "uncertain": 0}
    assert (entry["index_sum"], entry["expected_index_sum"]) == (2.0, 2.0)
    assert entry["euler_characteristic"] == 2
    assert {len(values) for values in entry["curvature"].values()} == {entry["vertices"]}
    for umbilic in entry["umbilics"]:
        assert umbilic["kind"] == "lemon"
        assert umbilic["index"] == 0.5
        assert abs(sum(umbilic["barycentric"]) - 1.0) < 1e-9
        assert np.linalg.norm(umbilic["normal"]) == pytest.approx(1.0)
        assert umbilic["curvature"] == pytest.approx(3.0 / 8.0, rel=0.05)
        assert umbilic["permanent"] == (umbilic["persistence"] is None)
        assert umbilic["vertex"] is None
        assert len(umbilic["triangle_vertices"]) == 3
        assert umbilic["face"] == umbilic["triangle"]


def test_every_field_is_in_the_manual(run, files, tmp_path):
    manual = os.path.join(os.path.dirname(__file__), "..", "..", "..", "docs", "json.md")
    with open(manual, encoding="utf-8") as file:
        text = file.read()
    target = tmp_path / "out.json"
    run(str(files / "egg.obj"), "--json", str(target), "--per-vertex")

    def names(value):
        if isinstance(value, dict):
            for name, item in value.items():
                yield name
                yield from names(item)
        elif isinstance(value, list):
            for item in value:
                yield from names(item)

    found = json.loads(target.read_text())
    (entry,) = found["objects"]
    entry["timings"], entry["counts"], found["settings"] = None, None, None
    assert [name for name in sorted(set(names(found))) if f"`{name}`" not in text] == []


def test_blend_and_picture_of_one_run(run, files, tmp_path):
    target, picture = tmp_path / "out.blend", tmp_path / "out.png"
    assert run(str(files / "egg.ply"), "--blend", str(target), "--png", str(picture)) == 0
    bpy.ops.wm.open_mainfile(filepath=str(target))
    obj = bpy.data.objects["egg"]
    assert len(empties(obj)) == 4
    assert "umbilics_gap" in obj.data.attributes
    assert obj.umbilics.lemon == 4
    # No scaffolding of the picture is left.
    assert len(bpy.data.objects) == 5
    assert len(bpy.data.scenes) == 1
    image = bpy.data.images.load(str(picture))
    pixels = np.empty(len(image.pixels), dtype=np.float32)
    image.pixels.foreach_get(pixels)
    pixels = pixels.reshape(-1, 4)[:, :3]
    saturation = pixels.max(axis=1) - pixels.min(axis=1)
    assert image.size[0] >= 1280
    # The background, the grey mesh, and yellow glyphs that take a small part of it.
    assert 0.2 < np.mean(pixels.min(axis=1) > 0.88) < 0.95
    assert 1e-4 < np.mean(saturation > 0.4) < 0.05


def test_several_files_fill_folders(run, files, tmp_path, capfd):
    twin = tmp_path / "twin.obj"
    twin.write_bytes((files / "egg.obj").read_bytes())
    target = tmp_path / "results"
    missing = tmp_path / "missing.obj"
    code = run(str(files / "egg.obj"), str(missing), str(twin), "--json", str(target))
    assert code == 1
    assert sorted(path.name for path in target.iterdir()) == ["egg.json", "twin.json"]
    errors = capfd.readouterr().err.strip().splitlines()
    assert len(errors) == 1
    assert "missing.obj" in errors[0]


@pytest.mark.usefixtures("here")
def test_every_mesh_of_a_blend_and_only_those_named(run, tmp_path):
    add_ellipsoid(subdivisions=3, name="One")
    add_ellipsoid(subdivisions=3, name="Two")
    add_mesh([(0, 0, 0), (1, 0, 0)], [], edges=[(0, 1)], name="Wire")
    scene = str(tmp_path / "two.blend")
    bpy.ops.wm.save_as_mainfile(filepath=scene, copy=True)
    target = tmp_path / "out.json"
    assert run(scene, "--json", str(target)) == 0
    found = json.loads(target.read_text())["objects"]
    assert sorted(entry["object"] for entry in found) == ["One", "Two"]
    assert run(scene, "--object", "Two", "--json", str(target)) == 0
    assert [e["object"] for e in json.loads(target.read_text())["objects"]] == ["Two"]
    assert run(scene, "--object", "Three") == 1
    assert run(scene, "--object", "Wire") == 1


def test_a_single_file_is_given_up_at_its_limit(run, files, tmp_path, capfd):
    """By its process where Blender is a program, by the work itself where it is a module."""
    target = tmp_path / "out.json"
    assert run(str(files / "egg.obj"), "--json", str(target), "--time-limit", "0.001") == 1
    assert "given up after 0.001 s (--time-limit)" in capfd.readouterr().err
    assert not target.exists()


def test_options_may_come_in_one_text(run, files, tmp_path, capfd):
    target = tmp_path / "out dir" / "out.json"
    text = f"--opening 1 --json '{target}'"
    assert run(str(files / "egg.obj"), "--options", text, "--no-regions") == 0
    settings = json.loads(target.read_text())["settings"]
    assert (settings["opening"], settings["regions"]) == (1, False)
    assert run("--options", "--json 'o") == 2
    assert run("--options") == 2
    assert run("--options", "--unheard-of") == 2


BAD_FILES = {
    "none.obj": (None, "no such file"),
    "empty.obj": (b"", "empty"),
    "words.obj": (b"hello\n", "no mesh"),
    "points.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\n", "faces"),
    "words.ply": (b"hello\n", "no head of a PLY"),
    "words.stl": (b"hello\n", "cannot read"),
    "words.glb": (b"hello\n", "cannot read"),
    "words.gltf": (b"{}\n", "cannot read"),
    "words.fbx": (b"hello\n", "cannot read"),
    "words.blend": (b"hello\n", "cannot read"),
    "words.txt": (b"hello\n", "not a kind of file"),
}


@pytest.mark.parametrize("name", BAD_FILES)
def test_bad_file_is_one_clear_line(run, tmp_path, capfd, name):
    content, words = BAD_FILES[name]
    path = tmp_path / name
    if content is not None:
        path.write_bytes(content)
    target = tmp_path / "out.json"
    assert run(str(path), "--json", str(target)) == 1
    lines = capfd.readouterr().err.strip().splitlines()
    assert len(lines) == 1
    assert lines[0].startswith("umbilics: ")
    assert name in lines[0]
    assert words in lines[0]
    assert not target.exists()


def test_folder_is_not_a_file(run, tmp_path, capfd):
    assert run(str(tmp_path)) == 1
    assert "folder" in capfd.readouterr().err


def test_unwritable_output_is_one_clear_line(run, files, tmp_path, capfd):
    (tmp_path / "file").write_text("in the way")
    for kind in ("json", "blend", "png"):
        target = tmp_path / "file" / f"out.{kind}"
        assert run(str(files / "egg.obj"), f"--{kind}", str(target)) == 1
        lines = capfd.readouterr().err.strip().splitlines()
        assert len(lines) == 1, lines
        assert "cannot be written" in lines[0]


@pytest.mark.parametrize(
    "arguments",
    [
        ["--methode", "S"],
        ["--method", "X"],
        ["--opening", "-1"],
        ["--opening", "1.5"],
        ["--persistence", "nan"],
        ["--scale", "wide"],
        ["--crease-angle", "400"],
        ["--curvature", "given", "--normal-smoothing", "2"],
        ["a.obj", "b/a.ply", "--json", "out"],
    ],
)
def test_wrong_arguments_are_exit_code_2(run, arguments, capfd):
    assert run(*arguments) == 2
    assert "error:" in capfd.readouterr().err


def test_help_names_every_setting(run, addon, capfd):
    assert run("--help") == 0
    text = capfd.readouterr().out
    for name in addon.core.options():
        assert f"--{name.replace('_', '-')}" in text


@pytest.mark.skipif(not bpy.app.binary_path, reason="Blender as a module has no command line")
def test_exit_codes_of_a_real_blender(files, tmp_path):
    def blender(*arguments):
        return subprocess.run(
            [bpy.app.binary_path, "-b", *arguments], capture_output=True, text=True, check=False
        )

    target = tmp_path / "out.json"
    command = ["--command", "umbilics"]
    done = blender(*command, str(files / "egg.obj"), "--json", str(target))
    assert done.returncode == 0, done.stderr
    assert "4 lemons" in done.stdout
    assert json.loads(target.read_text())["schema"] == 1
    opened = blender(str(files / "egg.blend"), *command)
    assert opened.returncode == 0
    assert "Egg: 4 lemons" in opened.stdout
    missing = blender(*command, str(tmp_path / "none.obj"))
    assert missing.returncode == 1
    assert [line for line in missing.stderr.splitlines() if "umbilics:" in line] == [
        f"umbilics: {tmp_path / 'none.obj'}: there is no such file."
    ]
    assert "Traceback" not in missing.stderr
    assert blender(*command, "--method", "Z").returncode == 2
