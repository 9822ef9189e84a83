"""Each format: the exact bytes, the round trip, and what is refused."""

import json
from dataclasses import replace

import numpy as np
import pytest
from surfaces import ellipsoid

import core
from core import formats
from core.base.errors import FormatError
from core.formats.points import poles_table, umbilics_table

RANDOM = np.random.default_rng(5)


@pytest.fixture(scope="module")
def exported():
    mesh = ellipsoid(subdivisions=4)
    detection = core.detect(mesh.vertices, mesh.triangles)
    guide = core.Guide(mesh.vertices, mesh.triangles, detection)
    guidance = guide.guidance()
    return core.Exported(
        mesh.vertices,
        mesh.triangles,
        guide,
        guidance,
        lines=guide.lines(),
        separatrices=guide.separatrices(),
        ridges=guide.ridges(),
        quads=core.remesh(
            mesh.vertices, mesh.triangles, core.RemeshSettings(quads=150), detection=detection
        ),
    )


def test_rosy_bytes(tmp_path):
    path = tmp_path / "a.rosy"
    formats.write_rosy(path, np.array([[1.0, 0.0, 0.0], [0.0, 0.5, -1.0]]))
    assert path.read_bytes() == b"2\n4\n1 0 0\n0 0.5 -1\n"


def test_rawfield_bytes(tmp_path):
    path = tmp_path / "a.rawfield"
    formats.write_rawfield(path, np.arange(12.0).reshape(1, 4, 3))
    assert path.read_bytes() == b"4 1\n0 1 2 3 4 5 6 7 8 9 10 11\n"


def test_sing_bytes(tmp_path):
    path = tmp_path / "a.sing"
    formats.write_sing(path, np.array([7, 9]), np.array([1, -1]))
    assert path.read_bytes() == b"4 2\n7 1\n9 -1\n"


def test_dmat_bytes(tmp_path):
    path = tmp_path / "a.dmat"
    formats.write_dmat(path, np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]))
    # Columns, then rows; the numbers go down the columns.
    assert path.read_bytes() == b"3 2\n1\n4\n2\n5\n3\n6\n"


def test_sharp_bytes(tmp_path):
    path = tmp_path / "a.sharp"
    formats.write_sharp(path, np.array([True, False]), np.array([3, 8]), np.array([0, 2]))
    assert path.read_bytes() == b"2\n1,3,0\n0,8,2\n"


@pytest.mark.parametrize("shape", [(5, 3), (0, 3), (1, 1)])
def test_dmat_round_trip(tmp_path, shape):
    matrix = RANDOM.normal(size=shape)
    formats.write_dmat(tmp_path / "m.dmat", matrix)
    assert np.array_equal(formats.read_dmat(tmp_path / "m.dmat"), matrix)


def test_field_round_trips_are_exact(tmp_path):
    direction = RANDOM.normal(size=(40, 3))
    formats.write_rosy(tmp_path / "f.rosy", direction, 4)
    found, symmetry = formats.read_rosy(tmp_path / "f.rosy")
    assert np.array_equal(found, direction) and symmetry == 4
    vectors = RANDOM.normal(size=(40, 4, 3))
    formats.write_rawfield(tmp_path / "f.rawfield", vectors)
    assert np.array_equal(formats.read_rawfield(tmp_path / "f.rawfield"), vectors)
    vertex, quarters = np.array([3, 5, 900000]), np.array([1, -1, 2])
    formats.write_sing(tmp_path / "f.sing", vertex, quarters)
    back = formats.read_sing(tmp_path / "f.sing")
    assert np.array_equal(back[0], vertex) and np.array_equal(back[1], quarters) and back[2] == 4
    convex, face, edge = RANDOM.random(9) > 0.5, np.arange(9), np.arange(9) % 3
    formats.write_sharp(tmp_path / "f.sharp", convex, face, edge)
    for one, other in zip(
        formats.read_sharp(tmp_path / "f.sharp"), (convex, face, edge), strict=True
    ):
        assert np.array_equal(one, other)


@pytest.mark.once
def test_curves_round_trip(tmp_path, exported):
    lines = exported.lines
    formats.write_curves(tmp_path / "c.obj", lines)
    points, family, closed = formats.read_curves(tmp_path / "c.obj")
    order = np.argsort(lines.family, kind="stable")
    assert np.array_equal(family, lines.family[order])
    assert np.array_equal(closed, lines.closed[order])
    for found, line in zip(points, order, strict=True):
        assert np.array_equal(found, lines.points(line))


def test_quads_as_ply_have_their_figures(tmp_path, exported):
    made = exported.quads
    formats.write_quads(tmp_path / "q.ply", made)
    data = (tmp_path / "q.ply").read_bytes()
    header, _, body = data.partition(b"end_header\n")
    counts = [int(line.split()[2]) for line in header.splitlines() if line.startswith(b"element")]
    assert counts == [len(made.vertices), len(made.quads)]
    # Three doubles and a whole number; a count, four corners, a whole number and a float.
    assert len(body) == 28 * counts[0] + 25 * counts[1]
    rows = np.frombuffer(body[: 28 * counts[0]], np.dtype([("p", "<f8", 3), ("valence", "<i4")]))
    assert np.array_equal(rows["p"], made.vertices)
    assert sorted(rows["valence"][rows["valence"] > 0].tolist()) == [3] * 8
    kind = np.dtype([("n", "u1"), ("c", "<i4", 4), ("patch", "<i4"), ("angle", "<f4")])
    faces = np.frombuffer(body[28 * counts[0] :], kind)
    assert (faces["n"] == 4).all()
    assert np.array_equal(faces["c"], made.quads)
    assert np.array_equal(faces["patch"], made.patch)
    assert np.array_equal(faces["angle"], made.angle.astype(np.float32), equal_nan=True)


def test_tables_round_trip(tmp_path, exported):
    tables = {
        "poles": poles_table(exported.guidance.poles),
        "umbilics": umbilics_table(exported.guide.detection.umbilics),
    }
    formats.write_points_json(tmp_path / "t.json", tables)
    found = formats.read_points_json(tmp_path / "t.json")
    # What topology keeps has no persistence that a table could hold.
    assert set(found["umbilics"].pop("persistence")) == {None}
    wanted = {key: value for key, value in tables["umbilics"].items() if key != "persistence"}
    assert found == {"poles": tables["poles"], "umbilics": wanted}
    formats.write_points_csv(tmp_path / "t.csv", tables["poles"])
    assert formats.read_points_csv(tmp_path / "t.csv") == tables["poles"]


def test_all_kinds_at_once(tmp_path, exported):
    turn = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    kinds = list(core.FILE_KINDS)
    written = core.write_guidance(tmp_path / "new" / "thing", kinds, exported, turn)
    assert written == core.guidance_paths(tmp_path / "new" / "thing", kinds)
    assert set(written) == set((tmp_path / "new").iterdir())
    vertices, triangles = formats.read_mesh(tmp_path / "new" / "thing.obj")
    assert np.array_equal(triangles, exported.triangles)
    assert np.allclose(vertices, exported.vertices @ turn.T, rtol=0, atol=1e-15)
    rows = (tmp_path / "new" / "thing-quads.obj").read_text().splitlines()
    places = np.array([row.split()[1:] for row in rows if row[0] == "v"], float)
    assert np.allclose(places, exported.quads.vertices @ turn.T, rtol=0, atol=1e-15)
    corners = np.array([row.split()[1:] for row in rows if row[0] == "f"], int)
    assert np.array_equal(corners - 1, exported.quads.quads)
    direction, _ = formats.read_rosy(tmp_path / "new" / "thing.rosy")
    corner = vertices[triangles]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    assert np.abs(np.einsum("ij,ij->i", direction, normal)).max() < 1e-9
    field = formats.read_rawfield(tmp_path / "new" / "thing.rawfield")
    assert np.allclose(np.cross(field[:, 0], field[:, 1]), normal)
    assert np.allclose(field[:, 2], -field[:, 0])
    _, quarters, _ = formats.read_sing(tmp_path / "new" / "thing.sing")
    assert quarters.sum() == 8
    content = json.loads((tmp_path / "new" / "thing-poles.json").read_text())
    assert len(content["poles"]) == 8 and len(content["umbilics"]) == 4


@pytest.mark.parametrize(
    "reader, text, what",
    [
        (formats.read_rosy, "3\n4\n1 0 0\n", "holds 3 numbers"),
        (formats.read_rosy, "", "whole numbers"),
        (formats.read_rosy, "1 4 a b c", "not a number"),
        (formats.read_rawfield, "0 3\n", "no vectors"),
        (formats.read_dmat, "2 -1\n", "whole numbers"),
        (formats.read_sharp, "2\n1,2,3\n", "holds 3 numbers"),
        (formats.read_sing, "4 1\n2 0.5\n", "not a number"),
        (formats.read_curves, "v 0 0 0\nl 1 2\n", "not there"),
        (formats.read_mesh, "v 0 0 0\nf 1 1\n", "not a triangle"),
        (formats.read_points_csv, "a,b\n1\n", "as many values"),
        (formats.read_points_json, "[", "not a JSON object"),
    ],
)
def test_broken_files_are_refused_with_a_reason(tmp_path, reader, text, what):
    path = tmp_path / "broken"
    path.write_text(text)
    with pytest.raises(FormatError, match=what):
        reader(path)
    with pytest.raises(FormatError, match="cannot be read"):
        reader(tmp_path / "missing")


def test_what_is_not_there_is_not_written(tmp_path, exported):
    without = replace(exported, lines=None, ridges=None, quads=None)
    for kind in ("lines", "ridge_figures", *core.QUAD_KINDS):
        with pytest.raises(FormatError, match="There are no"):
            core.write_guidance(tmp_path / "thing", [kind], without)
    assert not list(tmp_path.iterdir())


def test_a_folder_that_cannot_be_written_is_an_error(tmp_path, exported):
    (tmp_path / "file").write_text("")
    with pytest.raises(FormatError, match="cannot be"):
        core.write_guidance(tmp_path / "file" / "thing", ["rosy"], exported)
