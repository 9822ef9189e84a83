"""The command line overwrites no input and no result of its own: it refuses before it works."""

import json
import os
import shutil
import struct
import sys
from concurrent.futures import ThreadPoolExecutor

import bpy
import pytest
from scene_building import add_ellipsoid
from worker_stand_in import COMMAND


@pytest.fixture
def meshes(tmp_path, monkeypatch):
    """A folder, gone to, with q.ply, r.ply, x.obj and y.obj."""
    add_ellipsoid(subdivisions=2, name="Egg")
    bpy.ops.wm.ply_export(filepath=str(tmp_path / "q.ply"))
    bpy.ops.wm.obj_export(filepath=str(tmp_path / "x.obj"), export_materials=False)
    shutil.copy(tmp_path / "q.ply", tmp_path / "r.ply")
    shutil.copy(tmp_path / "x.obj", tmp_path / "y.obj")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def contents(folder):
    return {
        path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()
    }


REFUSED = {
    "the mesh of the guidance": ["x.obj", "--guide", "."],
    "a folder of results": ["q.ply", "r.ply", "--ply", "."],
    "itself": ["q.ply", "--ply", "q.ply"],
    "another way to say it": ["q.ply", "--ply", "../{here}/q.ply"],
    "another ending": ["x.obj", "--json", "x.obj"],
    "two results, one path": ["x.obj", "--json", "o", "--png", "o"],
    "upper case": ["q.ply", "--ply", "Q.PLY"],
    "two files of one name": ["a/x.obj", "b/x.obj", "--guide", "g"],
    "two files but for the case": ["x.obj", "b/X.obj", "--json", "g"],
    "the summary": ["x.obj", "--out", "o", "--report", "x.obj"],
    "the journal": ["x.obj", "--out", "o", "--report", "o/report.jsonl"],
    "a link": ["q.ply", "--ply", "link.ply"],
    "another name on the disk": ["q.ply", "--ply", "hard.ply"],
    "a frame": ["q.ply", "q.0003.ply", "--frames", "3", "--ply", "."],
    "results beside the meshes": [".", "--out", ".", "--also", "ply"],
    "guidance in the folder of a mesh": ["x.obj", "h", "--out", "o", "--guide", "h/sub"],
    "accents composed otherwise": ["e\u0301", "--out", "o"],
}


@pytest.mark.parametrize("arguments", REFUSED.values(), ids=REFUSED)
def test_what_would_be_overwritten_is_refused_before_anything_runs(run, meshes, arguments, capfd):
    for folder in ("a", "b"):
        (meshes / folder).mkdir()
        shutil.copy(meshes / "x.obj", meshes / folder / "x.obj")
    shutil.copy(meshes / "x.obj", meshes / "b" / "X.obj")
    shutil.copy(meshes / "q.ply", meshes / "q.0003.ply")
    # As if the user had it already: no journal says that it is a result.
    shutil.copy(meshes / "q.ply", meshes / "x.obj.ply")
    (meshes / "h" / "sub" / "x.obj").mkdir(parents=True)
    shutil.copy(meshes / "x.obj", meshes / "h" / "sub" / "x.obj" / "x.obj")
    (meshes / "e\u0301").mkdir()
    for name in ("\u00e9.obj", "e\u0301.obj"):
        shutil.copy(meshes / "x.obj", meshes / "e\u0301" / name)
    os.symlink("q.ply", meshes / "link.ply")
    os.link(meshes / "q.ply", meshes / "hard.ply")
    before = contents(meshes)
    code = run(*(argument.format(here=meshes.name) for argument in arguments))
    assert code == 2
    said = capfd.readouterr().err
    assert "would overwrite" in said or "same name" in said or "would both have" in said
    assert contents(meshes) == before


def test_an_object_of_another_name_than_its_file_spares_the_meshes_too(addon, meshes, capfd):
    """Its files are known only when it is open, in a process of its own."""
    runner = addon.operators.command_line.batch.runner
    (meshes / "h" / "g" / "x.obj").mkdir(parents=True)
    shutil.copy(meshes / "x.obj", meshes / "h" / "g" / "x.obj" / "x-Egg.obj")
    (meshes / "x.obj").write_text("guide x-Egg.obj")
    before = contents(meshes)
    plan = addon.operators.command_line.arguments.parser.parse(
        [str(word) for word in ("x.obj", "h", "--out", "o", "--guide", "h/g")]
    ).batch
    assert runner.run(plan, COMMAND) == 1
    assert "h/g/x.obj/x-Egg.obj, which is read" in capfd.readouterr().err
    assert before.items() <= contents(meshes).items()
    assert not (meshes / "o" / "x.obj.json").exists()


NAMELESS = {
    "FILE": [""],
    "--json": ["x.obj", "--json", ""],
    "--usda": ["x.obj", "--usda="],
    "--out": ["x.obj", "--out", ""],
    "--report": ["x.obj", "--out", "o", "--report", ""],
    "--guide": ["x.obj", "--guide", ""],
    "--strokes": ["x.obj", "--guide", "g", "--strokes", ""],
    "--check-topology": ["x.obj", "--check-topology", ""],
    "--align-to": ["x.obj", "--align-to", ""],
}


@pytest.mark.parametrize("what", NAMELESS)
def test_an_empty_name_is_no_name(run, meshes, what, capfd):
    """As a script gives that has a variable which was not set."""
    before = contents(meshes)
    assert run(*NAMELESS[what]) == 2
    assert f"argument {what}: the name is empty" in capfd.readouterr().err
    assert contents(meshes) == before


def test_a_link_that_leads_nowhere_is_no_folder(run, meshes, capfd):
    os.symlink("nowhere", meshes / "o")
    assert run("x.obj", "--out", "o") == 2
    assert "--out o is not a folder" in capfd.readouterr().err


def test_a_summary_of_nothing_is_none(run, meshes, capfd):
    assert run("--out", "o", "--summary") == 1
    assert "no batch has been at work there" in capfd.readouterr().err
    assert not (meshes / "o").exists()
    assert run("x.obj", "--out", "o", "--summary") == 2


def test_two_objects_whose_names_differ_only_in_a_stroke_are_refused(run, tmp_path, capfd):
    add_ellipsoid(subdivisions=2, name="a/b")
    add_ellipsoid(subdivisions=2, name="a_b")
    assert run("--guide", tmp_path / "g") == 1
    assert "same name" in capfd.readouterr().err
    assert not (tmp_path / "g").exists()


def test_the_scene_that_is_open_is_an_input(run, tmp_path, capfd):
    add_ellipsoid(subdivisions=2, name="Egg")
    scene = tmp_path / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(scene))
    before = scene.read_bytes()
    assert run("--blend", scene) == 2
    assert scene.read_bytes() == before


def test_a_picture_that_a_mesh_needs_is_an_input(run, tmp_path, capfd):
    obj = add_ellipsoid(subdivisions=2, name="Egg")
    image = bpy.data.images.new("skin", 4, 4)
    image.filepath_raw, image.file_format = str(tmp_path / "skin.png"), "PNG"
    image.save()
    material = bpy.data.materials.new("skin")
    material.use_nodes = True
    node = material.node_tree.nodes.new("ShaderNodeTexImage")
    node.image = image
    base = material.node_tree.nodes["Principled BSDF"].inputs["Base Color"]
    material.node_tree.links.new(node.outputs["Color"], base)
    obj.data.materials.append(material)
    obj.data.uv_layers.new()
    gltf = str(tmp_path / "skin.gltf")
    bpy.ops.export_scene.gltf(filepath=gltf, export_format="GLTF_SEPARATE", use_selection=False)
    before = contents(tmp_path)
    assert run(gltf, "--png", tmp_path / "skin.png") == 1
    assert run(gltf, "--json", tmp_path / "skin.bin") == 1
    assert "which is read" in capfd.readouterr().err
    assert contents(tmp_path) == before


def crate(*tokens):
    """What a binary layer of USD has of its words, in the way of LZ4 that packs nothing."""
    words = b"".join(token + b"\0" for token in tokens)
    more, rest = divmod(len(words) - 15, 255)
    block = b"\0\xf0" + b"\xff" * more + bytes([rest]) + words
    section = struct.pack("<QQQ", len(tokens), len(words), len(block)) + block
    table = struct.pack("<Q16sqq", 1, b"TOKENS", 88, len(section))
    return b"PXR-USDC\0\x08".ljust(16, b"\0") + struct.pack("<q", 88 + len(section)) + bytes(
        64
    ) + section + table


_GLB = b'{"buffers": [{"uri": "a%20b.bin"}, {"byteLength": 4}], "images": [{"uri": "data:image"}]}'


@pytest.mark.parametrize(
    ("file", "content", "others"),
    [
        ("a.obj", b"mtllib a b.mtl\nv 0 0\nmtllib c.mtl d.mtl\r\n", {"a b.mtl", "c.mtl", "d.mtl"}),
        ("a b.obj", b'v 0 0\rmtllib "c d.usda"\r', {"a b.mtl", "c d.usda"}),
        ("a.obj", b"mtllib a\0b.mtl\nmtllib " + b"x" * 5000 + b"\n#mtllib q.mtl\n", {"x" * 5000}),
        ("a.gltf", _GLB, {"a b.bin"}),
        ("a.gltf", b'{"images": [{"uri": "\\ud800.png"}, {"uri": "a\\u0000b"}]}', set()),
        ("a.usdc", crate(b"Egg", b"./b.usda", b"none.usdc", b"y" * 5000), {"b.usda", "c d.usda"}),
        ("a.glb", struct.pack("<4sIIII", b"glTF", 2, 99, len(_GLB), 1) + _GLB, {"a b.bin"}),
        ("a.usda", b"#usda 1.0\n(subLayers = [@./b.usda@])\n", {"b.usda", "c d.usda"}),
        ("a.ply", b"ply\n", set()),
    ],
)
def test_the_files_beside_one_are_known_to_its_report(addon, tmp_path, file, content, others):
    (tmp_path / file).write_bytes(content)
    (tmp_path / "a b.mtl").write_bytes(b"")
    # Which names the first again.
    (tmp_path / "b.usda").write_bytes(b"#usda 1.0\n(subLayers = [@@@c d.usda@@@, @a.usda@])\n")
    (tmp_path / "c d.usda").write_bytes(b"#usda 1.0\n")
    command_line = addon.operators.command_line
    found = command_line.files.beside.files_beside(str(tmp_path / file))
    assert {os.path.relpath(one, tmp_path) for one in found} == others
    told = command_line.report.source_of(str(tmp_path / file), found).get("beside", [])
    is_there = {os.path.basename(one["file"]): one["sha256"] is not None for one in told}
    assert is_there == {name: os.path.exists(tmp_path / name) for name in others}


def test_a_pipe_is_written_to_and_stays_a_pipe(run, meshes):
    os.mkfifo(meshes / "pipe")
    for option, begin in (("--json", b"{"), ("--blend", b""), ("--ply", b"ply")):
        with ThreadPoolExecutor() as pool:
            read = pool.submit((meshes / "pipe").read_bytes)
            assert run("x.obj", option, "pipe") == 0
            assert read.result().startswith(begin) and len(read.result()) > 1000
    assert (meshes / "pipe").is_fifo()


def test_a_file_that_fails_unforeseen_does_not_end_the_others(
    run, addon, meshes, monkeypatch, capfd
):
    compute = addon.operators.jobs.detect.compute
    errors = [KeyError("no such thing"), MemoryError()]

    def failing(inputs, progress=None):
        if errors:
            raise errors.pop(0)
        return compute(inputs, progress)

    monkeypatch.setattr(addon.operators.jobs.detect, "compute", failing)
    assert run("x.obj", "y.obj", "q.ply", "--json", "out") == 1
    said = capfd.readouterr().err
    assert "x.obj: stopped by a fault of this program (KeyError" in said
    assert "y.obj: out of memory" in said
    assert [path.name for path in (meshes / "out").iterdir()] == ["q.json"]


def test_an_error_without_words_gets_some(run, addon, tmp_path, monkeypatch):
    add_ellipsoid(subdivisions=2, name="Good")
    add_ellipsoid(subdivisions=2, name="Silent")
    compute = addon.operators.jobs.detect.compute

    def failing(inputs, progress=None):
        if inputs.object_name == "Silent":
            raise addon.core.InvalidMeshError("")
        return compute(inputs, progress)

    monkeypatch.setattr(addon.operators.jobs.detect, "compute", failing)
    assert run("--json", tmp_path / "o.json") == 1
    found = json.loads((tmp_path / "o.json").read_text())["objects"]
    errors = {entry["object"]: entry.get("error") for entry in found}
    assert errors["Good"] is None
    assert "InvalidMeshError" in errors["Silent"]


def test_all_results_of_a_file_are_whole_or_not_there(run, meshes, addon, monkeypatch):
    """Where the last result cannot be written, the one before it is not half written either."""
    (meshes / "in the way").mkdir()
    (meshes / "o.json").write_text("of before")
    assert run("x.obj", "--ply", "in the way/o.ply", "--json", "in the way") == 2

    def torn(value):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(addon.operators.command_line.report, "_plain", torn)
    assert run("x.obj", "--json", "o.json") == 1
    assert (meshes / "o.json").read_text() == "of before"
    assert not list(meshes.glob(".umbilics*"))


def test_the_panel_knows_which_files_of_the_guidance_are_there_already(addon, tmp_path):
    """The file browser warns of the one name that is typed, but more are written."""
    in_the_way = addon.operators.export_field.in_the_way
    kinds = ["mesh", "rosy", "csv"]
    assert in_the_way(str(tmp_path / "egg.obj"), kinds) == []
    for name in ("egg.rosy", "egg-umbilics.csv", "egg.sharp"):
        (tmp_path / name).write_text("")
    assert in_the_way(str(tmp_path / "egg.obj"), kinds) == ["egg.rosy", "egg-umbilics.csv"]


def test_names_that_endings_do_not_fit_on_are_cut_and_stay_apart(run, meshes):
    long = ["m" * 250 + letter + ".obj" for letter in "ab"]
    for name in long:
        shutil.copy(meshes / "x.obj", meshes / name)
    guide = ("--guide", "g", "--guide-files", "separatrices", "csv")
    assert run(*long, "--json", "out", *guide) == 0
    assert len(list((meshes / "out").glob("*.json"))) == 2
    assert len(list((meshes / "g").iterdir())) == 6


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="bounds files as Linux does")
@pytest.mark.parametrize("kind", ["blend", "png", "ply", "usda", "json"])
def test_what_does_not_fit_on_the_disk_is_not_there(run, meshes, kind, capfd):
    """As on a full disk: no file may grow beyond a few kilobytes."""
    import resource
    import signal

    (meshes / f"o.{kind}").write_text("of before")
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    ignored = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, limits[1]))
    try:
        code = run("x.obj", f"--{kind}", f"o.{kind}", "--per-vertex")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        signal.signal(signal.SIGXFSZ, ignored)
    assert code == 1
    said = [line for line in capfd.readouterr().err.splitlines() if "umbilics:" in line]
    assert "cannot be written" in said[-1]
    assert (meshes / f"o.{kind}").read_text() == "of before"
    assert not list(meshes.glob(".umbilics*"))
