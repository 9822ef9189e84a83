"""Arrays that do not fit end in a sentence, not in NumPy's words, and never in a wrong result."""

import dataclasses
from functools import cache

import numpy as np
import pytest
from surfaces import icosphere

import core


@cache
def ellipsoid(subdivisions=2):
    vertices, triangles = icosphere(subdivisions)
    vertices = vertices * (3.0, 2.0, 1.0)
    return vertices, triangles, core.detect(vertices, triangles)


VERTICES, TRIANGLES, DETECTION = ellipsoid()
COUNT = len(VERTICES)
RAGGED = [[0, 1, 2], [0, 1, 2, 3]]


def detect(vertices=VERTICES, triangles=TRIANGLES, **settings):
    marks = {name: settings.pop(name) for name in ("seams", "uv", "sharp") if name in settings}
    return core.detect(vertices, triangles, core.Settings(**settings), **marks)


@pytest.mark.parametrize(
    "vertices",
    [VERTICES.astype(complex), VERTICES.astype("M8[s]"), RAGGED, "abc", VERTICES.ravel()],
)
def test_vertices(vertices):
    with pytest.raises(core.InvalidMeshError, match="The vertices must"):
        detect(vertices)


@pytest.mark.parametrize(
    "triangles", [RAGGED, TRIANGLES + 0.5, TRIANGLES > 1, TRIANGLES.ravel(), np.full((1, 4), 0)]
)
def test_triangles(triangles):
    with pytest.raises(core.InvalidMeshError, match="The triangles must"):
        detect(triangles=triangles)


BAD_PAIRS = [[(0, COUNT)], [(0, -3)], [(0, 2**40)], [1, 2, 3], [(0.5, 1.0)], "ab", RAGGED]


@pytest.mark.parametrize("pairs", BAD_PAIRS)
@pytest.mark.parametrize("name", ["seams", "sharp"])
def test_marked_edges(name, pairs):
    with pytest.raises(core.InvalidMeshError, match=r"The (seams|sharp edges) "):
        detect(**{name: pairs})
    if name == "sharp":
        guide = core.Guide(VERTICES, TRIANGLES, DETECTION)
        with pytest.raises(core.InvalidMeshError, match="sharp edges"):
            guide.guidance(sharp=pairs)
        with pytest.raises(core.InvalidMeshError, match="sharp edges"):
            core.quad_layout(VERTICES, TRIANGLES, detection=DETECTION, sharp=pairs)
        with pytest.raises(core.InvalidMeshError, match="marked edges"):
            core.suitability(VERTICES, TRIANGLES, DETECTION, pairs)


@pytest.mark.parametrize("pairs", [[], np.zeros((0, 2)), [(0, 1)], np.array([(0, 1)], np.uint8)])
def test_marked_edges_of_any_whole_numbers_are_taken(pairs):
    found = detect(sharp=pairs, seams=pairs)
    assert len(found.umbilics) == len(DETECTION.umbilics)


@pytest.mark.parametrize("uv", ["x", [[1], [1, 2]], np.zeros((3, 3, 2)), np.zeros((1, 1)) + 1j])
def test_a_uv_map(uv):
    with pytest.raises(core.InvalidMeshError, match="The UV map"):
        detect(method="C", charts="uv", uv=uv)


@pytest.mark.parametrize("k1", ["x", 1.0, np.ones(3), np.ones(COUNT) + 1j])
def test_given_curvatures(k1):
    given = dataclasses.replace(DETECTION.curvature, k1=k1)
    with pytest.raises(core.InvalidMeshError, match="The given k1"):
        core.detect(VERTICES, TRIANGLES, core.Settings(curvature="given"), given=given)


@pytest.mark.parametrize("other", [1, 3])
def test_a_detection_of_another_mesh(other):
    vertices, triangles, _ = ellipsoid(other)
    for use in (
        core.Guide,
        core.Shape.of,
        core.suitability,
        lambda *mesh: core.remesh(*mesh[:2], detection=mesh[2]),
    ):
        with pytest.raises(core.InvalidMeshError, match="of another mesh"):
            use(vertices, triangles, DETECTION)


# Rows in place of a mask would name other vertices without a word.
@pytest.mark.parametrize(
    "zone", [np.ones(3, bool), [1, 2, 3], np.arange(COUNT), np.ones((COUNT, 1), bool)]
)
def test_a_zone(zone):
    guide = core.Guide(VERTICES, TRIANGLES, DETECTION)
    with pytest.raises(core.InvalidMeshError, match="The zone must"):
        guide.guidance(zone=zone)
    for make in (core.remesh, core.quad_layout):
        with pytest.raises(core.InvalidMeshError, match="The zone must"):
            make(VERTICES, TRIANGLES, detection=DETECTION, zone=zone)


def test_a_zone_may_be_a_list():
    guide = core.Guide(VERTICES, TRIANGLES, DETECTION)
    assert len(guide.guidance(zone=[False] * COUNT).poles) == 8


@pytest.mark.parametrize(
    ("position", "valence"),
    [([(3, 0, 0)], [4]), ([(3, 0, 0)], [3, 5]), ([3, 0, 0], [3]), ([(3, 0)], [3]), ([0], [])],
)
def test_wanted_poles(position, valence):
    with pytest.raises(core.GuidanceError, match="each 3 or 5"):
        core.WantedPoles(np.array(position, float), np.array(valence, int))


@pytest.mark.parametrize(
    ("start", "points", "influence"),
    [
        ([0, 9], 2, 1),
        ([0, 2], 2, 2),
        ([2, 0], 2, 1),
        ([0, 2, 1, 2], 2, 3),
        ([], 0, 0),
        ([1, 2], 2, 1),
    ],
)
def test_strokes(start, points, influence):
    with pytest.raises(core.GuidanceError, match="Strokes need"):
        core.Strokes(np.array(start, int), np.zeros((points, 3)), np.zeros(influence))


def test_a_mesh_that_is_checked():
    guide = core.Guide(VERTICES, TRIANGLES, DETECTION)
    poles = guide.guidance().poles
    corners, start = TRIANGLES.ravel(), 3 * np.arange(len(TRIANGLES) + 1)
    nowhere = VERTICES.copy()
    nowhere[5] = np.nan
    beyond = np.where(corners == 5, COUNT, corners)
    for vertices, its_corners, its_start, match in (
        (VERTICES, corners, start[:-1], "need all corners"),
        (VERTICES, corners, start[::-1], "need all corners"),
        (VERTICES, TRIANGLES, start, "need all corners"),
        (VERTICES, corners, np.insert(start, 1, 0), "need all corners"),
        (VERTICES, beyond, start, "The faces name vertices"),
        (VERTICES, -corners, start, "The faces name vertices"),
        (VERTICES[:, :2], corners, start, "The vertices must"),
        (VERTICES, corners, [], "has no faces"),
        (nowhere, corners, start, "nowhere"),
    ):
        with pytest.raises(core.InvalidMeshError, match=match):
            core.check_topology(vertices, its_corners, its_start, guide, poles)


def test_a_kind_of_file_that_there_is_not(tmp_path):
    guide = core.Guide(VERTICES, TRIANGLES, DETECTION)
    with pytest.raises(core.FormatError, match="no kind of file fbx"):
        core.guidance_paths(tmp_path / "a", ["fbx"])
    with pytest.raises(core.FormatError, match="no kind of file fbx"):
        core.export_guidance(
            tmp_path / "a",
            ["mesh", "fbx"],
            guide,
            core.GuidanceSettings(),
            mesh=(VERTICES, TRIANGLES),
        )
    assert not list(tmp_path.iterdir())


def test_edges_may_be_lists():
    guide = core.Guide(VERTICES, TRIANGLES, DETECTION)
    edges = np.unique(np.sort(TRIANGLES[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)), axis=0)
    lines, ridges = guide.separatrices(), guide.ridges()
    given = VERTICES.tolist(), edges.tolist()
    np.testing.assert_array_equal(
        core.edge_paths(*given, lines), core.edge_paths(VERTICES, edges, lines)
    )
    core.ridge_edges(*given, ridges)
