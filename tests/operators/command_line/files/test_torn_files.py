"""Mesh files that are torn or damaged: all of them is read, or it is said that something is not."""

import os
import random
import struct
import zlib
from dataclasses import replace

import bpy
import numpy as np
import pytest
import surfaces
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scene_building import add_ellipsoid
from worker_stand_in import COMMAND

needs_program = pytest.mark.skipif(
    not bpy.app.binary_path, reason="as a module Blender has no program that could be started"
)
SUFFIXES = (
    *(".obj", ".ply", ".stl", ".off", ".gltf", ".glb", ".fbx", ".usd", ".usda", ".usdc", ".usdz"),
    *(".abc", ".blend"),
)
any_file = settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
shares = st.floats(0.0, 1.0, exclude_max=True)


@pytest.fixture
def opened(addon, part):
    """Opens a file: how many faces it has and what is said of them."""

    def opened(path, data):
        path.write_bytes(data)
        try:
            found = part("files.importers").open_file(str(path), "")
        except addon.operators.base.errors.FileError as error:
            return 0, [str(error)]
        return sum(len(obj.data.polygons) for obj in found.objects), found.warnings

    return opened


def text_of_stl(surface):
    lines = ["solid Egg"]
    for triangle in surface.vertices[surface.triangles].astype(np.float32):
        corners = [f"vertex {x:.9g} {y:.9g} {z:.9g}" for x, y, z in triangle]
        lines += ["facet normal 0 0 0", "outer loop", *corners, "endloop", "endfacet"]
    return ("\n".join([*lines, "endsolid Egg"]) + "\n").encode()


def bytes_of_stl(surface):
    triangles = surface.vertices[surface.triangles].astype("<f4").reshape(-1, 9)
    rows = np.zeros(len(triangles), [("normal", "<f4", 3), ("corners", "<f4", 9), ("rest", "<u2")])
    rows["corners"] = triangles
    return bytes(80) + struct.pack("<I", len(rows)) + rows.tobytes()


def text_of_obj(surface):
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in surface.vertices]
    lines += [f"f {a} {b} {c}" for a, b, c in surface.triangles + 1]
    return ("\n".join(lines) + "\n").encode()


def text_of_ply(surface):
    head = ["ply", "format ascii 1.0", f"element vertex {len(surface.vertices)}"]
    head += [f"property float {name}" for name in "xyz"]
    head += [f"element face {len(surface.triangles)}", "property list uchar int vertex_indices"]
    lines = [" ".join(f"{x:.9g}" for x in vertex) for vertex in surface.vertices]
    lines += [f"3 {a} {b} {c}" for a, b, c in surface.triangles]
    return ("\n".join([*head, "end_header", *lines]) + "\n").encode()


EGG = surfaces.ellipsoid((3.0, 2.0, 1.0), 1)
COUNT = len(EGG.triangles)
WAYS = {".stl": text_of_stl, ".obj": text_of_obj, ".ply": text_of_ply}


@pytest.mark.parametrize("suffix", WAYS)
def test_a_whole_file_is_read_without_a_word(opened, tmp_path, suffix):
    assert opened(tmp_path / f"a{suffix}", WAYS[suffix](EGG)) == (COUNT, ())


def test_a_whole_binary_stl_is_read_without_a_word(opened, tmp_path):
    assert opened(tmp_path / "a.stl", bytes_of_stl(EGG)) == (COUNT, ())


@any_file
@given(share=shares)
def test_a_text_stl_that_ends_anywhere_is_said_to(opened, tmp_path, share):
    whole = text_of_stl(EGG)
    data = whole[: int(share * len(whole))]
    faces, said = opened(tmp_path / "a.stl", data)
    if b"endsolid" in data:
        assert (faces, said) == (COUNT, ())
    else:
        assert len(said) == 1
    # What may be whole but for its last line is read; what ends within a triangle cannot be.
    first, _, rest = data.rpartition(b"endfacet")
    assert faces == (data.count(b"endfacet") if first and b"facet" not in rest else 0)


@pytest.mark.parametrize("ends", ["\r\n", "\r"])
def test_other_line_ends_and_capitals_are_not_torn(opened, tmp_path, ends):
    whole = text_of_stl(EGG).replace(b"\n", ends.encode())
    assert opened(tmp_path / "a.stl", whole) == (COUNT, ())
    assert opened(tmp_path / "a.stl", whole.upper()) == (COUNT, ())
    faces, said = opened(tmp_path / "a.stl", whole.upper()[:-200])
    assert faces == 0 and "ends within a triangle" in said[0]


def test_the_last_of_several_solids_counts(opened, tmp_path):
    two = text_of_stl(EGG) + b"solid more\n"
    faces, said = opened(tmp_path / "a.stl", two)
    assert faces == COUNT and "does not end with endsolid" in said[0]


@any_file
@given(share=shares)
def test_a_binary_stl_that_ends_anywhere_is_refused(opened, tmp_path, share):
    whole = bytes_of_stl(EGG)
    faces, said = opened(tmp_path / "a.stl", whole[: int(share * len(whole))])
    assert faces == 0
    assert "ends before all the triangles" in said[0] or "the file is empty" in said[0]


@any_file
@given(share=shares)
def test_an_obj_that_ends_anywhere_has_all_of_its_faces_or_says_so(opened, tmp_path, share):
    whole = text_of_obj(EGG)
    data = whole[: int(share * len(whole))]
    faces, said = opened(tmp_path / "a.obj", data)
    assert faces == data.count(b"\nf ") or said


def with_broken_faces(data, count):
    """The last faces, which the last lines are, have a vertex that is not there."""
    lines = data.splitlines()
    broken = [line.rpartition(b" ")[0] + b" 4000" for line in lines[-count:]]
    return b"\n".join([*lines[:-count], *broken, b""])


@pytest.mark.parametrize("times", [1, 3])
def test_faces_of_vertices_that_are_not_there_are_counted(opened, tmp_path, times):
    faces, said = opened(tmp_path / "a.obj", with_broken_faces(text_of_obj(EGG), times))
    assert faces == COUNT - times
    (sentence,) = said
    assert sentence.startswith(f"{times} of the {COUNT} faces in the file were left out: ")
    # There Blender takes others instead, and the shape would be wrong.
    faces, said = opened(tmp_path / "a.ply", with_broken_faces(text_of_ply(EGG), times))
    assert faces == 0
    names = "1 face names" if times == 1 else "3 faces name"
    assert f"{names} vertices that are not there" in said[0]


def test_faces_that_stand_in_a_file_twice_are_counted(opened, tmp_path):
    for way, suffix in ((text_of_obj, ".obj"), (text_of_stl, ".stl"), (bytes_of_stl, ".stl")):
        twice = replace(EGG, triangles=np.concatenate([EGG.triangles, EGG.triangles[:2]]))
        faces, said = opened(tmp_path / f"a{suffix}", way(twice))
        assert faces == COUNT
        assert said[0].startswith(f"2 of the {COUNT + 2} faces in the file were left out: ")


def test_faces_are_counted_over_the_ends_of_the_pieces(opened, tmp_path, part, monkeypatch):
    whole = text_of_obj(EGG)
    for size in (3, 7, 64):
        monkeypatch.setattr(part("files.content.pieces"), "SIZE", size)
        assert opened(tmp_path / "a.obj", whole) == (COUNT, ())
        assert opened(tmp_path / "a.obj", whole.replace(b"f ", b"f\t")) == (COUNT, ())


def test_what_was_left_out_is_in_the_report(run_command, part, tmp_path):
    whole = text_of_obj(surfaces.ellipsoid((3.0, 2.0, 1.0), 2))
    (tmp_path / "a.obj").write_bytes(with_broken_faces(whole, 1))
    code, said, report = run_command(tmp_path / "a.obj")
    assert code == 0
    assert "1 of the 320 faces in the file were left out" in said.out
    (entry,) = report["objects"]
    assert entry["warnings"][0].startswith("1 of the 320 faces")


@pytest.fixture
def run_command(part, capfd, tmp_path):
    """Runs the command: exit code, what was said and the report."""
    import json

    def run(*arguments):
        target = tmp_path / "report.json"
        code = part("command").run([*map(str, arguments), "--json", str(target)])
        report = json.loads(target.read_text()) if target.is_file() else None
        return code, capfd.readouterr(), report

    return run


def ogawa(groups):
    """An Alembic file of nested groups; data are bytes."""
    data = bytearray(b"Ogawa\xff\x00\x01" + bytes(8))

    def put(what):
        if isinstance(what, bytes):
            place = len(data)
            data.extend(struct.pack("<Q", len(what)) + what)
            return place | 1 << 63 if what else 1 << 63
        places = [put(one) for one in what]
        place = len(data)
        data.extend(struct.pack(f"<{1 + len(places)}Q", len(places), *places))
        return place

    data[8:16] = struct.pack("<Q", put(groups))
    return bytes(data)


ARCHIVE = ogawa([[b"one", b"", [b"two" * 40, []]], b"three", [[b"four"]]])


def of_alembic(part, path, data):
    path.write_bytes(data)
    try:
        part("files.damage").check(path)
    except Exception as error:  # noqa: BLE001
        assert type(error).__name__ == "FileError"
        return str(error)
    return ""


def test_an_alembic_file_that_ends_anywhere_is_refused(part, tmp_path):
    path = tmp_path / "a.abc"
    assert of_alembic(part, path, ARCHIVE) == ""
    for length in range(1, len(ARCHIVE)):
        said = of_alembic(part, path, ARCHIVE[:length])
        assert "is torn" in said or (length < 16 and "is not an Alembic file" in said), length
    assert "was never closed" in of_alembic(part, path, ARCHIVE.replace(b"\xff", b"\0", 1))
    assert "older kind" in of_alembic(part, path, b"\x89HDF\r\n\x1a\n" + ARCHIVE)


def test_a_file_that_is_cut_short_while_it_is_read_is_torn(part, tmp_path, monkeypatch):
    """Mapped into memory it would end the process; cut anywhere, and whenever it is read."""
    damage, pieces = part("files.damage"), part("files.content.pieces")
    path, numbers = tmp_path / "a.abc", damage._numbers
    whole = ogawa([[bytes(1 << 14)], [bytes(1 << 14), [bytes(1 << 14)]]])
    for length in (0, 16, len(whole) // 3, len(whole) - 40):
        path.write_bytes(whole)

        def cut(file, place, count, length=length):
            os.truncate(path, length)
            return numbers(file, place, count)

        monkeypatch.setattr(damage, "_numbers", cut)
        with pytest.raises(Exception, match="is torn"):
            damage.check(path)
    monkeypatch.setattr(pieces, "SIZE", 16)
    path = tmp_path / "a.obj"
    path.write_bytes(b"v 1 2 3\n" * 40000)
    lines = pieces.lines_of(path)
    assert next(lines).startswith(b"v 1 2 3")
    os.truncate(path, 8)
    assert len(b"".join(lines)) < 8 * 40000


def test_lines_come_whole_whatever_the_pieces_are(part, tmp_path, monkeypatch):
    pieces = part("files.content.pieces")
    data = b"one\r\ntwo and more\n\nthree\rfour"
    (tmp_path / "a.obj").write_bytes(data)
    for size in range(1, len(data) + 2):
        monkeypatch.setattr(pieces, "SIZE", size)
        found = list(pieces.lines_of(tmp_path / "a.obj"))
        words = [word for piece in found for word in piece.splitlines() if word]
        # Longer than a piece, a line is no line of such a file.
        assert words == [b"one", b"two and more", b"three", b"four"] or size < 12


@any_file
@given(at=st.integers(1, len(ARCHIVE) // 8 - 1), value=st.integers(0, 2**64 - 1))
def test_any_number_in_an_alembic_file_ends_the_look_at_it(part, tmp_path, at, value):
    """Also one that makes a group its own part, or as long as all memory."""
    data = bytearray(ARCHIVE)
    data[8 * at : 8 * at + 8] = struct.pack("<Q", value)
    of_alembic(part, tmp_path / "a.abc", bytes(data))
    data[8 * at : 8 * at + 8] = struct.pack("<Q", value % len(data))
    of_alembic(part, tmp_path / "a.abc", bytes(data))


@pytest.mark.skipif("alembic_export" not in dir(bpy.ops.wm), reason="built without Alembic")
def test_an_alembic_file_of_blender_is_whole_and_torn_does_not_end_it(opened, tmp_path):
    add_ellipsoid(subdivisions=3)
    bpy.ops.wm.alembic_export(filepath=str(tmp_path / "a.abc"), as_background_job=False)
    whole = (tmp_path / "a.abc").read_bytes()
    assert opened(tmp_path / "b.abc", whole) == (320, ())
    for length in (20, len(whole) // 2, len(whole) - 1):
        faces, said = opened(tmp_path / "b.abc", whole[:length])
        assert faces == 0 and "is torn" in said[0]


def fbx(version):
    """A binary FBX with nodes in nodes, and properties of every kind."""
    node = struct.Struct("<QQQB" if version >= 7500 else "<IIIB")
    packed = zlib.compress(bytes(800))
    some = b"Y\1\0" + b"C\1" + b"I\1\0\0\0" + b"D" + bytes(8) + b"S\2\0\0\0ab"
    arrays = b"f" + struct.pack("<III", 2, 0, 8) + bytes(8)
    arrays += b"d" + struct.pack("<III", 100, 1, len(packed)) + packed
    data = bytearray(b"Kaydara FBX Binary  \0\x1a\0" + struct.pack("<I", version))

    def put(name, count, properties, inner=()):
        start = len(data)
        data.extend(bytes(node.size) + name + properties)
        for one in inner:
            put(*one)
        data.extend(bytes(node.size) if inner else b"")
        node.pack_into(data, start, len(data), count, len(properties), len(name))

    put(b"Head", 5, some, [(b"Inner", 2, arrays, [(b"Leaf", 0, b"")]), (b"More", 5, some)])
    put(b"Objects", 2, arrays)
    return bytes(data) + bytes(node.size)


@pytest.mark.parametrize("version", [7400, 7500])
def test_an_fbx_is_whole_only_if_all_of_it_is_there(part, tmp_path, version):
    is_whole, path = part("files.fbx_check").is_whole, tmp_path / "a.fbx"

    def holds(data):
        path.write_bytes(data)
        return is_whole(path)

    whole = fbx(version)
    assert holds(whole) and holds(whole + b"what some programs write behind it")
    assert not [size for size in range(30, len(whole)) if holds(whole[:size])]
    # No number makes it look for ever, or take all memory.
    for place in range(27, len(whole) - 8):
        for value in (b"\xff" * 4, b"\xff" * 8, b"\0" * 4):
            holds(whole[:place] + value + whole[place + len(value) :])
    middle = whole.rindex(b"\x78\x9c") + 6
    assert not holds(whole[:middle] + b"\xff\xff" + whole[middle + 2 :])


def test_blenders_own_fbx_is_whole(part, tmp_path):
    add_ellipsoid(subdivisions=3)
    bpy.ops.export_scene.fbx(filepath=str(tmp_path / "a.fbx"))
    assert part("files.fbx_check").is_whole(tmp_path / "a.fbx")


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_bytes_that_mean_nothing_are_one_sentence(part, tmp_path, suffix, capfd, monkeypatch):
    # This process as its own worker.
    monkeypatch.setattr(part("command").lifetime, "end_with_parent", lambda: None)
    draw = random.Random(suffix)
    path = tmp_path / f"a{suffix}"
    for data in (draw.randbytes(3000), bytes(3000), b"\xff" * 3000, b"\n" * 3000, b"{}", b"0"):
        path.write_bytes(data)
        assert part("command").run([str(path), "--worker"]) == 1
        said = capfd.readouterr()
        lines = [line for line in said.err.splitlines() if line.startswith("umbilics: ")]
        assert len(lines) == 1 and str(path) in lines[0], said
        assert "fault of this program" not in lines[0]
        assert "console" not in lines[0] and "unknown error" not in lines[0]


@pytest.mark.parametrize("name", ["a.stl", "a.off", "a.ply", "a.usda", "a.fbx", "a.glb"])
def test_a_file_is_called_as_it_was_given(part, tmp_path, monkeypatch, capfd, name):
    monkeypatch.setattr(part("command").lifetime, "end_with_parent", lambda: None)
    (tmp_path / "elsewhere").write_bytes(b"0\n")
    (tmp_path / name).symlink_to(tmp_path / "elsewhere")
    monkeypatch.chdir(tmp_path)
    assert part("command").run([name, "--worker"]) == 1
    said = capfd.readouterr().err
    assert said.startswith(f"umbilics: {name}: ") and str(tmp_path) not in said


@needs_program
@pytest.mark.parametrize("suffix", [".abc", ".blend", ".usda", ".USDC"])
def test_a_file_that_ends_blender_ends_it_for_no_other(part, tmp_path, capfd, suffix):
    (tmp_path / f"bad{suffix}").write_text("crash")
    (tmp_path / "good.obj").write_text("well")
    (tmp_path / "o").mkdir()
    files = [str(tmp_path / f"bad{suffix}"), str(tmp_path / "good.obj")]
    request = part("arguments.parser").parse([*files, "--json", str(tmp_path / "o")])
    assert part("command")._needs_processes(request)
    assert part("batch.supervised").run(request, COMMAND) == 1
    assert [path.name for path in (tmp_path / "o").iterdir()] == ["good.json"]
    said = capfd.readouterr().err
    assert f"bad{suffix}: Blender ended with signal 6: the file may be damaged." in said


@needs_program
def test_files_that_are_checked_before_they_are_read_share_a_process(part, tmp_path):
    (tmp_path / "a.obj").write_text("")
    parse = part("arguments.parser").parse
    assert not part("command")._needs_processes(parse([str(tmp_path / "a.obj")]))
    (tmp_path / "b.abc").write_text("")
    aligned = parse([str(tmp_path / "a.obj"), "--align-to", str(tmp_path / "b.abc")])
    assert part("command")._needs_processes(aligned)
    assert not part("command")._needs_processes(parse(["b.abc", "--worker"]))
