"""Files that Blender's importers misread: each is read right, or refused in words."""

import importlib
import json
import struct

import bpy
import numpy as np
import pytest
from scene_building import add_ellipsoid


@pytest.fixture
def egg(tmp_path):
    """Files of one ellipsoid by ending."""
    add_ellipsoid(subdivisions=3, name="Egg")
    bpy.ops.wm.obj_export(filepath=str(tmp_path / "o.obj"), export_materials=False)
    bpy.ops.wm.stl_export(filepath=str(tmp_path / "a.stl"), ascii_format=True)
    bpy.ops.wm.stl_export(filepath=str(tmp_path / "b.stl"))
    bpy.ops.wm.ply_export(filepath=str(tmp_path / "p.ply"), export_uv=False)
    return {path.name: path.read_bytes() for path in tmp_path.iterdir()}


WAYS = {
    "a mark of the byte order in an OBJ": ("o.obj", lambda data: b"\xef\xbb\xbf" + data),
    "an OBJ that begins with a vertex": (
        "o.obj",
        lambda data: b"\xef\xbb\xbf" + data[data.index(b"\nv ") + 1 :],
    ),
    "an OBJ of an old Mac": ("o.obj", lambda data: data.replace(b"\n", b"\r")),
    "an OBJ of Windows": ("o.obj", lambda data: data.replace(b"\n", b"\r\n")),
    "an STL in capitals": ("a.stl", bytes.upper),
    "an STL of an old Mac": ("a.stl", lambda data: data.replace(b"\n", b"\r")),
    "a mark in an STL": ("a.stl", lambda data: b"\xef\xbb\xbf" + data),
    "bytes behind a binary STL": ("b.stl", lambda data: data + b"made by hand"),
    "a binary STL that is called solid": (
        "b.stl",
        lambda data: b"solid facet".ljust(80) + data[80:],
    ),
    "an STL without a name": ("a.stl", lambda data: b"solid\n" + data.split(b"\n", 1)[1]),
}


@pytest.mark.parametrize("what", WAYS)
def test_what_is_in_the_file_is_read(run, egg, tmp_path, what):
    name, change = WAYS[what]
    path = tmp_path / f"changed{name[1:]}"
    path.write_bytes(change(egg[name]))
    before = path.read_bytes()
    assert run(path, "--json", tmp_path / "o.json") == 0
    report = json.loads((tmp_path / "o.json").read_text())
    (entry,) = report["objects"]
    assert entry["object"] in ("changed", "Egg")
    assert report["source"]["bytes"] == len(before) and path.read_bytes() == before
    assert (entry["vertices"], entry["triangles"]) == (162, 320)
    assert entry["counts"]["lemon"] == 4 and entry["index_sum"] == 2.0


BAD = {
    "more vertices than bytes": ("p.ply", 162, "element vertex %d", "ends before all the elements"),
    "more faces than bytes": ("p.ply", 320, "element face %d", "ends before all the elements"),
}


@pytest.mark.parametrize("what", BAD)
def test_counts_beyond_the_file_end_no_blender(run, egg, tmp_path, what, capfd):
    name, count, line, words = BAD[what]
    old, new = ((line % number).encode() for number in (count, 4_000_000_000))
    assert old in egg[name]
    (tmp_path / "bad.ply").write_bytes(egg[name].replace(old, new))
    assert run(tmp_path / "bad.ply", tmp_path / "p.ply", "--json", tmp_path / "out") == 1
    assert words in capfd.readouterr().err
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["p.json"]


def test_text_of_two_bytes_a_letter_is_refused_in_words(run, egg, tmp_path, capfd):
    (tmp_path / "wide.obj").write_bytes(egg["o.obj"].decode().encode("utf-16"))
    assert run(tmp_path / "wide.obj") == 1
    assert "wide.obj: is text in UTF-16" in capfd.readouterr().err


@pytest.mark.parametrize(
    "data", [b"glTF\x02\0\0\0", struct.pack("<III", 0x46546C67, 2, 900) + b"x" * 40]
)
def test_a_reason_is_of_the_file_and_not_of_a_script(run, tmp_path, data, capfd):
    (tmp_path / "torn.glb").write_bytes(data)
    assert run(tmp_path / "torn.glb") == 1
    said = [line for line in capfd.readouterr().err.splitlines() if line.startswith("umbilics: ")]
    (line,) = said
    assert "torn.glb: Blender cannot read it (" in line
    assert ".py" not in line and "Location" not in line


def test_binary_stl_of_any_count_is_never_cut_short(addon, tmp_path):
    """Only what lies behind all its triangles goes."""
    quirks = importlib.import_module(f"{addon.__name__}.operators.command_line.files.quirks")
    for count in (0, 1, 1000):
        whole = bytes(80) + struct.pack("<I", count) + np.zeros(50 * count, np.uint8).tobytes()
        for data in (whole, whole + b"more", whole[:-1]):
            path = tmp_path / "s.stl"
            path.write_bytes(data)
            with quirks.readable(str(path)) as place, open(place, "rb") as file:
                assert file.read() == data[: len(whole)]
