"""Vertices that are no numbers, infinite or too far away: Blender puts them elsewhere unsaid."""

import base64
import json
import struct
import zlib

import bpy
import numpy as np
import pytest
import surfaces

EGG = surfaces.ellipsoid((3.0, 2.0, 1.0), 2)
TRIANGLES = EGG.triangles.astype("<i4")
NUMBERS = [np.nan, -np.nan, np.inf, -np.inf, np.float32(3.4e38), 0.0, -0.0]


def places(value, kind="<f4"):
    found = EGG.vertices.astype(kind)
    found[7, 1] = value
    return found


def gltf(value, **view):
    """The JSON of a glTF and its buffer."""
    points, corners = places(value).tobytes(), TRIANGLES.tobytes()
    return {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{"byteLength": len(points) + len(corners)}],
        "bufferViews": [
            {"buffer": 0, "byteLength": len(points)} | view,
            {"buffer": 0, "byteOffset": len(points), "byteLength": len(corners)},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(EGG.vertices), "type": "VEC3"}
            | {"min": [-3.0, -2.0, -1.0], "max": [3.0, 2.0, 1.0]},
            {"bufferView": 1, "componentType": 5125, "count": TRIANGLES.size, "type": "SCALAR"},
        ],
    }, points + corners


def in_glb(path, value):
    scene, data = gltf(value)
    text = json.dumps(scene).encode()
    text += b" " * (-len(text) % 4)
    parts = struct.pack("<I4s", len(text), b"JSON") + text
    parts += struct.pack("<I4s", len(data), b"BIN\0") + data
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(parts)) + parts)


def in_gltf(path, value):
    scene, data = gltf(value)
    text = base64.b64encode(data).decode()
    scene["buffers"][0]["uri"] = f"data:application/octet-stream;base64,{text}"
    path.write_text(json.dumps(scene))


def in_gltf_with_a_file(path, value):
    scene, data = gltf(value)
    (path.parent / "a b.bin").write_bytes(data)
    scene["buffers"][0]["uri"] = "a%20b.bin"
    path.write_text(json.dumps(scene))


def in_sparse_gltf(path, value):
    scene, data = gltf(EGG.vertices[7, 1])
    more = struct.pack("<I", 7) + places(value)[7].tobytes()
    scene["bufferViews"] += [
        {"buffer": 0, "byteOffset": len(data), "byteLength": 4},
        {"buffer": 0, "byteOffset": len(data) + 4, "byteLength": 12},
    ]
    indices = {"bufferView": 2, "componentType": 5125}
    sparse = {"count": 1, "indices": indices, "values": {"bufferView": 3}}
    scene["accessors"][0]["sparse"] = sparse
    uri = f"data:application/octet-stream;base64,{base64.b64encode(data + more).decode()}"
    scene["buffers"] = [{"byteLength": len(data + more), "uri": uri}]
    path.write_text(json.dumps(scene))


def head_of_ply(format_, kind):
    lines = ["ply", f"format {format_} 1.0", "comment made by a test"]
    lines += [f"element vertex {len(EGG.vertices)}", "property uchar quality"]
    lines += [f"property {kind} {axis}" for axis in "xyz"]
    lines += [f"element face {len(TRIANGLES)}", "property list uchar int vertex_indices"]
    return "\n".join([*lines, "end_header", ""]).encode()


def in_ply(order, kind, name):
    def write(path, value):
        points = np.zeros(len(EGG.vertices), [("quality", "u1"), ("at", f"{order}{kind}", 3)])
        points["at"] = places(value, kind)
        faces = np.zeros(len(TRIANGLES), [("count", "u1"), ("corners", f"{order}i4", 3)])
        faces["count"], faces["corners"] = 3, TRIANGLES
        form = "binary_big_endian" if order == ">" else "binary_little_endian"
        path.write_bytes(head_of_ply(form, name) + points.tobytes() + faces.tobytes())

    return write


def in_text_of_ply(path, value):
    rows = [f"1 {x} {y} {z}" for x, y, z in places(value)]
    rows += [f"3 {a} {b} {c}" for a, b, c in TRIANGLES]
    path.write_bytes(head_of_ply("ascii", "float") + "\n".join(rows).encode())


def in_stl(path, value):
    found = np.zeros(len(TRIANGLES), [("n", "<f4", 3), ("at", "<f4", (3, 3)), ("rest", "<u2")])
    found["at"] = places(value)[TRIANGLES]
    path.write_bytes(bytes(80) + struct.pack("<I", len(found)) + found.tobytes())


def in_text_of_stl(path, value):
    lines = ["solid a"]
    for corners in places(value)[TRIANGLES]:
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += [f"vertex {x} {y} {z}" for x, y, z in corners]
        lines += ["endloop", "endfacet"]
    path.write_text("\n".join([*lines, "endsolid a", ""]))


def in_obj(path, value):
    rows = [f"v {x} {y} {z}" for x, y, z in places(value)]
    path.write_text("\n".join([*rows, *(f"f {a} {b} {c}" for a, b, c in TRIANGLES + 1), ""]))


# Of an STL the corners are counted: six triangles have the vertex.
WRITERS = {
    "a.glb": (in_glb, 1),
    "a.gltf": (in_gltf, 1),
    "file.gltf": (in_gltf_with_a_file, 1),
    "sparse.gltf": (in_sparse_gltf, 1),
    "little.ply": (in_ply("<", "f4", "float"), 1),
    "big.ply": (in_ply(">", "f4", "float"), 1),
    "double.ply": (in_ply("<", "f8", "double"), 1),
    "text.ply": (in_text_of_ply, 1),
    "a.stl": (in_stl, int((TRIANGLES == 7).sum())),
    "text.stl": (in_text_of_stl, int((TRIANGLES == 7).sum())),
    "a.obj": (in_obj, 1),
}


@pytest.mark.parametrize("name", WRITERS)
@pytest.mark.parametrize("value", NUMBERS, ids=str)
def test_what_has_no_place_is_counted_in_every_format(part, tmp_path, name, value):
    write, times = WRITERS[name]
    write(tmp_path / name, value)
    expected = 0 if np.isfinite(value) else times
    assert part("files.content.nowhere").count(tmp_path / name) == expected
    assert part("files.content.nowhere").word_in(tmp_path / name) is None


def test_doubles_beyond_single_precision_are_nowhere(part, tmp_path):
    in_ply("<", "f8", "double")(tmp_path / "a.ply", 1e300)
    assert part("files.content.nowhere").count(tmp_path / "a.ply") == 1


@pytest.mark.parametrize("name", WRITERS)
def test_what_is_nowhere_is_said(run, tmp_path, name, capfd):
    WRITERS[name][0](tmp_path / name, np.nan)
    assert run(tmp_path / name, "--json", tmp_path / "o.json") == 0
    (entry,) = json.loads((tmp_path / "o.json").read_text())["objects"]
    assert any("in the file" in said and "nowhere" in said for said in entry["warnings"])
    capfd.readouterr()


@pytest.mark.parametrize("name", ["text.ply", "text.stl", "a.obj"])
@pytest.mark.parametrize("word", ["0,5", "foo", "1.5d0", "1.#INF", "--", "1.2.3"])
def test_words_that_are_no_numbers_are_refused(run, tmp_path, name, word, capfd):
    """Blender reads what comes before, or nothing."""
    WRITERS[name][0](tmp_path / name, np.nan)
    text = (tmp_path / name).read_text()
    assert " nan " in text
    (tmp_path / name).write_text(text.replace(" nan ", f" {word} "))
    assert run(tmp_path / name) == 1
    assert f"a vertex has {word}, which is no number" in capfd.readouterr().err


def test_a_row_of_a_ply_that_is_too_short_is_refused(run, tmp_path, capfd):
    in_text_of_ply(tmp_path / "a.ply", np.nan)
    text = (tmp_path / "a.ply").read_text()
    (tmp_path / "a.ply").write_text(text.replace(" nan ", " "))
    assert run(tmp_path / "a.ply") == 1
    assert "fewer than three numbers" in capfd.readouterr().err


def test_words_elsewhere_in_a_file_are_not_looked_at(part, tmp_path):
    in_obj(tmp_path / "a.obj", 0.5)
    text = (tmp_path / "a.obj").read_text()
    names = "# v nan nan nan\no v 1,5 nan foo\ng nan\nvn nan nan nan\nvt nan nan\n"
    (tmp_path / "a.obj").write_text(names + text)
    in_text_of_ply(tmp_path / "a.ply", 0.5)
    data = (tmp_path / "a.ply").read_bytes()
    (tmp_path / "a.ply").write_bytes(data.replace(b"made by", b"1,5 nan") + b"\nnan nan nan nan\n")
    for path in (tmp_path / "a.obj", tmp_path / "a.ply"):
        assert part("files.content.nowhere").word_in(path) is None
        assert part("files.content.nowhere").count(path) == 0


@pytest.mark.parametrize("packed", [False, True])
@pytest.mark.parametrize("kind", ["d", "f"])
def test_places_in_an_fbx_are_found(part, tmp_path, kind, packed):
    count = part("files.content.nowhere").count
    for value, expected in ((0.5, 0), (np.nan, 1), (np.inf, 1)):
        data = places(value, {"d": "<f8", "f": "<f4"}[kind]).tobytes()
        stored = zlib.compress(data) if packed else data
        array = struct.pack("<III", 3 * len(EGG.vertices), packed, len(stored)) + stored
        name = b"\x08Vertices" + kind.encode()
        (tmp_path / "a.fbx").write_bytes(b"Kaydara FBX Binary  \0" + name + array)
        assert count(tmp_path / "a.fbx") == expected
        rows = ",".join(str(number) for number in places(value).ravel())
        text = f"Vertices: *{3 * len(EGG.vertices)} {{\n\t\ta: {rows}\n}} "
        (tmp_path / "a.fbx").write_text(text)
        assert count(tmp_path / "a.fbx") == expected


def test_what_cannot_be_followed_counts_for_nothing(part, tmp_path):
    """It is the importer's to refuse it."""
    count = part("files.content.nowhere").count
    for name in WRITERS:
        WRITERS[name][0](tmp_path / name, 0.5)
        data = (tmp_path / name).read_bytes()
        for end in (0, 30, 90, len(data) // 2, len(data) - 1):
            path = tmp_path / f"cut{name[name.index('.'):]}"
            path.write_bytes(data[:end])
            assert count(path) == 0
    array = b"\x08Verticesd" + struct.pack("<III", 6, 1, 9) + b"no packing"
    (tmp_path / "a.fbx").write_bytes(array)
    assert count(tmp_path / "a.fbx") == 0


def test_a_vertex_far_away_joins_no_others(run, tmp_path, capfd):
    """What glTF splits is the same to the bit; nothing else is joined, however large the mesh."""
    scene, _ = gltf(0.5)
    points = np.concatenate([places(0.5), places(0.5)[:1] * 0 + np.float32(1e9)])
    corners = TRIANGLES.tobytes()
    scene["bufferViews"][0]["byteLength"] = points.nbytes
    scene["bufferViews"][1]["byteOffset"] = points.nbytes
    scene["accessors"][0] |= {"count": len(points), "max": [1e9, 1e9, 1e9]}
    whole = points.tobytes() + corners
    text = base64.b64encode(whole).decode()
    scene["buffers"] = [
        {"byteLength": len(whole), "uri": f"data:application/octet-stream;base64,{text}"}
    ]
    (tmp_path / "far.gltf").write_text(json.dumps(scene))
    assert run(tmp_path / "far.gltf", "--json", tmp_path / "o.json") == 0
    (entry,) = json.loads((tmp_path / "o.json").read_text())["objects"]
    assert entry["faces"] == len(TRIANGLES)
    capfd.readouterr()


def test_splits_of_gltf_are_joined_however_small_the_mesh(run, tmp_path, capfd):
    for scale in (1e-6, 1.0, 1e6):
        bpy.ops.wm.read_homefile(use_empty=True)
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3, radius=scale)
        bpy.ops.export_scene.gltf(filepath=str(tmp_path / "a.glb"))
        assert run(tmp_path / "a.glb", "--json", tmp_path / "o.json") == 0
        (entry,) = json.loads((tmp_path / "o.json").read_text())["objects"]
        # Flat faces: every corner stands in the file.
        assert (entry["vertices"], entry["faces"]) == (162, 320)
    capfd.readouterr()
