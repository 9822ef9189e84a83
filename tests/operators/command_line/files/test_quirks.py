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
    bpy.ops.wm.ply_export(filepath=str(tmp_path / "t.ply"), export_uv=False, ascii_format=True)
    return {path.name: path.read_bytes() for path in tmp_path.iterdir()}


WAYS = {
    "a mark of the byte order in an OBJ": ("o.obj", lambda data: b"\xef\xbb\xbf" + data),
    "an OBJ that begins with a vertex": (
        "o.obj",
        lambda data: b"\xef\xbb\xbf" + data[data.index(b"\nv ") + 1 :],
    ),
    "an OBJ of an old Mac": ("o.obj", lambda data: data.replace(b"\n", b"\r")),
    "a PLY in text of an old Mac": ("t.ply", lambda data: data.replace(b"\n", b"\r")),
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


def test_of_a_folder_it_is_said_how_to_take_all_in_it(run, tmp_path, capfd):
    assert run(tmp_path) == 1
    assert "this is a folder, not a file; with --out DIR" in capfd.readouterr().err


PLACE = "-0.5 0.25 1"


@pytest.mark.parametrize(
    "place", ["-0,5 0,25 1", "-5D-01 0.25 1", "-5.0d0 0.25 1", "-0.5 1.#INF 1,0", "-0.5 0.25 nano"]
)
def test_what_is_no_number_in_an_obj_is_refused(run, tmp_path, capfd, place):
    """Blender reads what comes before the comma or the D, or nothing."""
    (tmp_path / "a.obj").write_text(f"# 1,5 nan\nv 0 0 0\n\tv  {place}\nv 0 1 0\nf 1 2 3\n")
    assert run(tmp_path / "a.obj") == 1
    assert "which is no number such as" in capfd.readouterr().err


@pytest.mark.parametrize(
    ("word", "count"),
    [
        *((word, 1) for word in ("nan", "-nan(ind)", "NaN", "inf", "-Infinity", "1e300", "-4E+38")),
        *((word, 0) for word in ("1", "-.5", "+1.", "1e5", "3.4e+38", "1E-300", "1e-45")),
    ],
)
def test_what_is_nowhere_in_an_obj_is_counted(addon, tmp_path, word, count):
    damage = addon.operators.command_line.files.damage
    path = tmp_path / "a.obj"
    path.write_text(f"o one, nan\nv {PLACE}\r\n v {PLACE} 0.5,\nv 0 1 {word}\rf 1 2 3\n")
    damage.check(path)
    said = damage.doubts(path, 1)
    assert [sentence.partition(" (")[0] for sentence in said] == count * [
        "1 vertex in the file is nowhere"
    ]


def test_an_obj_that_counts_from_0_is_said_to(addon, tmp_path):
    doubts = addon.operators.command_line.files.damage.doubts
    text = f"v {PLACE}\nv 0 0 0\nv 0 1 0\nf 1/0 2/0 3/0\n"
    (tmp_path / "a.obj").write_text(text)
    assert not doubts(tmp_path / "a.obj", 1)
    for face in ("0 1 2", "1 0 2", "1 2 0", "0/1 1/1 2/1", "1 2 0/3/1"):
        (tmp_path / "a.obj").write_text(f"{text}f {face}\n")
        assert "OBJ counts from 1" in doubts(tmp_path / "a.obj", 1)[-1], face


def test_bytes_behind_a_binary_stl_are_said(addon, egg, tmp_path):
    doubts = addon.operators.command_line.files.damage.doubts
    assert not doubts(tmp_path / "b.stl", 320)
    (tmp_path / "b.stl").write_bytes(egg["b.stl"] + bytes(50))
    assert doubts(tmp_path / "b.stl", 320)[0].startswith("50 bytes behind the triangles")


@pytest.mark.parametrize(
    ("head", "body", "why"),
    [
        ("property list uchar float w\n", "0 0 0 1 1\n" * 3, "vertices have lists"),
        ("", "0 0 0\n1 0 0\n0 1 0\n", "a face may have more corners"),
    ],
)
def test_what_blender_reads_in_no_ply_is_said(run, tmp_path, capfd, head, body, why):
    text = "ply\nformat ascii 1.0\nelement vertex 3\n"
    text += "".join(f"property float {axis}\n" for axis in "xyz")
    text += f"{head}element face 1\nproperty list int int vertex_indices\nend_header\n{body}"
    (tmp_path / "a.ply").write_text(f"{text}300 {'0 1 2 ' * 100}\n")
    assert run(tmp_path / "a.ply") == 1
    assert why in capfd.readouterr().err


@pytest.mark.parametrize("name", ["p.ply", "t.ply"])
def test_no_byte_of_the_head_of_a_ply_ends_blender(addon, egg, tmp_path, name):
    """Each is changed by itself: the file is read or refused in words, and nothing else comes of
    it. By itself, Blender's importer ends the process on some of them."""
    files = addon.operators.command_line.files
    data = bytearray(egg[name])
    random = np.random.default_rng(7)
    refused, head = 0, data.index(b"end_header") + len("end_header")
    for place in range(head):
        changed = data.copy()
        changed[place] = random.integers(256) if place % 2 else random.choice(list(b"aVx09 \n"))
        (tmp_path / "a.ply").write_bytes(changed)
        try:
            files.importers.open_file(str(tmp_path / "a.ply"), "")
        except addon.operators.base.errors.FileError as error:
            refused += 1
            assert "a.ply: " in str(error)
    assert refused > head / 3


def lists_of_ply(order, extra):
    """A PLY of a cube with faces of three and four corners, and with more in each."""
    name = {"<": "binary_little_endian", ">": "binary_big_endian"}[order]
    lines = [f"ply\nformat {name} 1.0\nobj_info made by a test\nelement vertex 8"]
    lines += [f"property double {axis}" for axis in "xyz"]
    lines += ["element face 7", *(["property uchar red"] if extra else [])]
    lines += ["property list ushort int vertex_indices"]
    lines += [*(["property list uchar float texcoord"] if extra else []), "end_header\n"]
    corners = np.array(np.meshgrid(*[[-1, 1]] * 3, indexing="ij")).reshape(3, -1).T
    data = "\n".join(lines).encode() + corners.astype(order + "f8").tobytes()
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7]]
    for face in [*faces, [1, 7, 3]]:
        data += bytes([9] if extra else []) + struct.pack(f"{order}H{len(face)}i", len(face), *face)
        data += struct.pack(f"{order}B2f", 2, 0.5, 0.5) if extra else b""
    return data


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("extra", [False, True])
def test_a_binary_ply_that_ends_anywhere_before_its_end_is_torn(addon, tmp_path, order, extra):
    files, path = addon.operators.command_line.files, tmp_path / "a.ply"
    data = lists_of_ply(order, extra)
    for end in range(data.index(b"end_header") + 11, len(data)):
        path.write_bytes(data[:end])
        with pytest.raises(addon.operators.base.errors.FileError, match="torn"):
            files.damage.check(path)
    path.write_bytes(data)
    files.damage.check(path)
    assert files.damage.doubts(path, 7) == []
    path.write_bytes(data + b"1234")
    assert files.damage.doubts(path, 7)[0].startswith("4 bytes behind the triangles")


def test_an_obj_that_ends_within_a_line_is_doubted_where_faces_are_missing(addon, egg, tmp_path):
    doubts, path = addon.operators.command_line.files.damage.doubts, tmp_path / "a.obj"
    data = egg["o.obj"].rstrip()
    path.write_bytes(data)
    assert doubts(path, 320) == []
    path.write_bytes(data[: int(0.8 * len(data))].rstrip())
    assert any("ends within a line" in said for said in doubts(path, 320))
    # Where it ends with its line, nothing tells it from one that somebody made so.
    path.write_bytes(data + b"\n")
    assert doubts(path, 320) == []
