"""What much else is made of: unit vectors, turns, triangles in the plane, rings, medians."""

import numpy as np
import pytest
import surfaces
from exact_fields import surface_of

from core.base.median import weighted_median
from core.base.plane import corner_angles, doubled_areas
from core.base.unit import angles_between, cross, phase, unit
from core.fields.frames import frame
from core.fields.transport import carried, rotation
from core.mesh.rings import ring_around, with_rings


def test_what_is_across_is_what_numpy_says():
    random = np.random.default_rng(0)
    for one, other in (((40, 3), (40, 3)), ((40, 4, 3), (40, 1, 3)), ((40, 1, 3), (40, 4, 3))):
        a, b = random.normal(size=one), random.normal(size=other)
        np.testing.assert_array_equal(cross(a, b), np.cross(a, b))


def test_length_becomes_one_and_nothing_stays_nothing_or_no_turn():
    np.testing.assert_array_equal(phase(np.array([0.0, 0.25j, -3.0, 2.0])), [1.0, 1j, -1.0, 1.0])
    found = unit(np.array([[0.0, 0.0, 0.0], [0.0, 0.5, 0.0], [3.0, 0.0, 4.0]]))
    np.testing.assert_allclose(found, [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.6, 0.0, 0.8]])


def test_small_angles_are_told_to_the_last_digits():
    turn = np.array([0.0, 1e-12, 1e-3, 0.5 * np.pi, np.pi])
    turned = np.stack([np.cos(turn), np.sin(turn), np.zeros(5)], axis=1)
    found = angles_between(turned, np.array([1.0, 0.0, 0.0]))
    np.testing.assert_allclose(found, turn, rtol=1e-12)


def test_a_frame_is_turned_as_the_smallest_rotation_carries_it():
    """Also between planes that are more than a right angle apart."""
    random = np.random.default_rng(0)
    source, target = unit(random.standard_normal((2, 50, 3)))
    e1, e2 = frame(source.T)
    f1, f2 = frame(target.T)
    turn = rotation(e1 + 1j * e2, f1 + 1j * f2)
    np.testing.assert_allclose(np.abs(turn), 1.0)
    moved = carried(e1.T, source, target)
    # e1 is 1 in its own frame, and the turn in the other one.
    expected = turn.real * f1 + turn.imag * f2
    np.testing.assert_allclose(moved, expected.T, atol=1e-9)


def test_triangles_in_the_plane_upside_down_are_negative():
    triangles = np.array([[0.0, 2.0, 2.0j], [0.0, 2.0j, 2.0]])
    np.testing.assert_allclose(doubled_areas(triangles), [4.0, -4.0])
    right = np.pi * np.array([0.5, 0.25, 0.25])
    np.testing.assert_allclose(corner_angles(triangles), np.concatenate([right, -right]))


def test_rings_go_from_face_to_face():
    """A row of quads: each ring adds the two vertices at either end."""
    faces = np.array([[2 * i, 2 * i + 1, 2 * i + 3, 2 * i + 2] for i in range(9)])
    start = np.zeros(20, bool)
    start[8] = True
    for rings, reached in ((0, [8]), (1, range(6, 12)), (2, range(4, 14)), (99, range(20))):
        assert np.flatnonzero(with_rings(faces, start, rings)).tolist() == list(reached)
    assert start.sum() == 1


@pytest.mark.parametrize("count, rings", [(0, 2), (1, 0), (3, 1), (5, 3), (200, 2)])
def test_rings_around_few_vertices_are_those_of_the_whole_mesh(count, rings):
    surface = surface_of(surfaces.random_ellipsoid(count=300))
    chosen = np.random.default_rng(count).choice(300, count)
    start = np.isin(np.arange(300), chosen)
    whole = with_rings(surface.triangles, start, rings)
    assert ring_around(surface, chosen, rings).tolist() == np.flatnonzero(whole).tolist()


def test_triangles_with_two_corners_of_a_set():
    surface = surface_of(surfaces.random_ellipsoid(count=300))
    chosen = np.random.default_rng(0).random(300) < 0.3
    corners = chosen[surface.triangles].sum(axis=1)
    assert surface.with_two_of(chosen).tolist() == np.flatnonzero(corners > 1).tolist()
    assert surface.touching(chosen).tolist() == np.flatnonzero(corners > 0).tolist()


def test_the_weighted_median_is_where_half_of_the_weight_is():
    values = np.array([3.0, 1.0, 2.0])
    assert weighted_median(values, np.ones(3)) == 2.0
    assert weighted_median(values, np.array([5.0, 1.0, 1.0])) == 3.0
    assert weighted_median(values, np.array([0.0, 5.0, 1.0])) == 1.0
    assert weighted_median(np.zeros(0), np.zeros(0)) == 0.0
