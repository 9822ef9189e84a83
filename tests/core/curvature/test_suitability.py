"""Whether a mesh is fine enough, and smooth: on surfaces where both are known."""

import numpy as np
import pytest
from surfaces import icosphere

import core


def suits(vertices, triangles):
    return core.suitability(vertices, triangles, core.detect(vertices, triangles))


def cube(cuts=1):
    """A cube whose sides are grids of 2 * cuts² triangles."""
    line = np.linspace(-1.0, 1.0, cuts + 1)
    u, v = (grid.ravel() for grid in np.meshgrid(line, line, indexing="ij"))
    corner = np.arange((cuts + 1) ** 2).reshape(cuts + 1, cuts + 1)
    a, b, c, d = corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]
    side = np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)]).reshape(-1, 3)
    points, faces = [], []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            place = np.insert(np.column_stack([u, v]), axis, sign, axis=1)
            outward = (sign > 0) == (axis != 1)
            faces.append((side if outward else side[:, ::-1]) + len(u) * len(points))
            points.append(place)
    merged, back = np.unique(np.concatenate(points), axis=0, return_inverse=True)
    return merged, back.ravel()[np.concatenate(faces)]


@pytest.mark.parametrize(("level", "coarse"), [(2, True), (4, False), (5, False)])
def test_an_ellipsoid_is_coarse_until_its_neighbourhoods_are_small(level, coarse):
    vertices, triangles = icosphere(level)
    found = suits(vertices * (3.0, 2.0, 1.0), triangles)
    assert found.is_coarse == coarse
    assert not found.is_hard


def test_turn_of_a_sphere_is_the_angle_that_its_neighbourhoods_span():
    vertices, triangles = icosphere(4)
    detection = core.detect(7.0 * vertices, triangles)
    found = core.suitability(7.0 * vertices, triangles, detection)
    assert found.turn == pytest.approx(detection.scale / 7.0, rel=0.05)


def test_a_cube_of_eight_vertices_is_coarse_and_a_fine_one_is_hard():
    assert suits(*cube()).is_coarse
    vertices, triangles = cube(12)
    found = suits(vertices, triangles)
    assert not found.is_coarse
    assert found.is_hard
    assert (found.sharp, found.bent) == (12 * 12, 0)


def test_creases_that_were_heeded_smear_nothing():
    """By any angle that reaches them, or by marks; a few that are left out do no harm."""
    vertices, triangles = cube(12)
    for settings, smeared in (
        ({"regions": False}, True),
        ({"crease_angle": 120.0}, True),
        ({"crease_angle": 80.0}, False),
        ({}, False),
    ):
        detection = core.detect(vertices, triangles, core.Settings(**settings))
        found = core.suitability(vertices, triangles, detection)
        assert found.is_hard and found.is_smeared == smeared, settings
    detection = core.detect(vertices, triangles, core.Settings(regions=False))
    edge = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    creases = edge[(abs(vertices[edge]) > 1.0 - 1e-9).all(axis=1).sum(axis=1) == 2]
    assert len(np.unique(creases, axis=0)) == 12 * 12
    marked = creases[:, ::-1]
    assert not core.suitability(vertices, triangles, detection, marked).is_smeared
    # As an importer leaves them, on all edges, marks are no creases and not heeded.
    assert core.suitability(vertices, triangles, detection, edge).is_smeared


def test_where_most_edges_are_sharp_it_is_coarse_however_little_it_turns():
    for sharp, coarse in ((50, False), (51, True)):
        found = core.Suitability(turn=0.1, edges=100, sharp=sharp, bent=0, crossed=0)
        assert (found.is_coarse, found.is_hard) == (coarse, False)


@pytest.mark.parametrize("shape", [cube(4), icosphere(1)], ids=["right angles", "less"])
def test_winding_makes_no_crease(shape):
    vertices, triangles = shape
    detection = core.detect(vertices, triangles)
    flipped = triangles.copy()
    flipped[::2] = flipped[::2, ::-1]
    straight = core.suitability(vertices, triangles, detection)
    assert straight.sharp + straight.bent > 0
    assert core.suitability(vertices, flipped, detection) == straight


def test_triangles_without_area_count_for_nothing():
    vertices, triangles = cube(4)
    detection = core.detect(vertices, triangles)
    flat = np.vstack([triangles, [[0, 0, 1]]])
    assert core.suitability(vertices, flat, detection).sharp == 12 * 4
