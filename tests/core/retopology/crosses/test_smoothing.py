"""Over which length fields are smoothed, and how far directions are believed."""

from dataclasses import replace

import numpy as np
import pytest
from exact_fields import surface_of
from surfaces import ellipsoid, sphere

from core.fields.transport import tangents
from core.retopology.crosses.cross_field import QUAD_EDGE
from core.retopology.crosses.smoothing import (
    LONGEST,
    SHORTEST,
    curvature_data,
    smoothing_length,
    smoothing_lengths,
    smoothness_of,
)


@pytest.fixture(scope="module")
def ball():
    mesh = sphere(subdivisions=4)
    surface = surface_of(mesh)
    return surface, mesh.curvature_on(surface)


def believed(surface, field, undirected=None):
    e1, e2 = tangents(field.normal)
    axis = np.ascontiguousarray((e1 + 1j * e2).T)
    return curvature_data(surface, field, field.normal, axis, undirected, 2)


def with_gap(field, gap, noise):
    mean = 0.5 * (field.k1 + field.k2)
    return replace(field, k1=mean + 0.5 * gap, k2=mean - 0.5 * gap, noise=noise + 0.0 * mean)


def test_lengths_are_in_radii_of_the_sphere_of_the_same_area(ball):
    surface, _ = ball
    assert np.isclose(smoothing_length(surface, 0.0), SHORTEST, rtol=0.01)
    assert np.isclose(smoothing_length(surface, 1.0), LONGEST, rtol=0.01)
    half = smoothing_length(surface, 0.5)
    assert np.isclose(half**2, smoothing_length(surface, 0.0) * smoothing_length(surface, 1.0))
    # That of quads is the side of one of 2,000 on it.
    side = np.sqrt(surface.face_normal_area[1].sum() / 2000.0)
    assert np.isclose(smoothing_length(surface, QUAD_EDGE), side, rtol=0.05)
    area = np.full(len(surface.vertices), 0.25)
    assert np.allclose(
        smoothing_lengths(surface, 4.0 * area, 0.3), 2.0 * smoothing_lengths(surface, area, 0.3)
    )


@pytest.mark.parametrize("smoothness", [0.0, 0.1, 0.65, 1.0])
def test_the_smoothness_of_a_length_is_the_one_that_makes_it(ball, smoothness):
    surface, _ = ball
    length = smoothing_length(surface, smoothness)
    assert np.isclose(smoothness_of(surface, length), smoothness, atol=1e-12)
    assert smoothness_of(surface, 0.5 * SHORTEST) == 0.0
    assert smoothness_of(surface, 2.0 * LONGEST) == 1.0


def test_directions_count_by_their_errors_and_by_the_gap(ball):
    """Half where the gap is four errors, nearly wholly where it is usual and exact."""
    surface, field = ball
    gap = np.full(len(field.k1), 0.1)
    exact, _ = believed(surface, with_gap(field, gap, 1e-9))
    assert np.allclose(exact, 1.0 / (1.0 + 0.15**2))
    four, _ = believed(surface, with_gap(field, gap, 0.025))
    assert np.allclose(four, 0.5, atol=0.01)
    # A direction of a small gap among large ones, and one of none.
    gap[:3] = 0.015, 0.0, np.nan
    some, powers = believed(surface, with_gap(field, gap, 1e-9))
    assert np.isclose(some[0], 0.5, atol=0.01)
    assert some[1] == some[2] == 0.0 and powers[2] == 1.0
    assert np.isfinite(powers).all()


def test_powers_turn_as_often_as_the_symmetry_says():
    mesh = ellipsoid(subdivisions=3)
    surface = surface_of(mesh)
    field = mesh.curvature_on(surface)
    e1, e2 = tangents(field.normal)
    _, powers = believed(surface, field)
    angle = 0.5 * np.angle(powers)
    again = np.cos(angle)[:, None] * e1 + np.sin(angle)[:, None] * e2
    assert np.abs(np.einsum("nc,nc->n", again, field.d1)).min() > 1.0 - 1e-9


def test_within_regions_nothing_is_believed(ball):
    surface, field = ball
    field = with_gap(field, np.full(len(field.k1), 0.1), 1e-9)
    undirected = surface.vertices[surface.triangles].mean(axis=1)[:, 2] > 0.3
    confidence, _ = believed(surface, field, undirected)
    rim = np.zeros(len(confidence), bool)
    rim[surface.triangles[~undirected]] = True
    assert (confidence > 0.9).tolist() == rim.tolist()
    assert (confidence[~rim] == 0.0).all() and (~rim).any()
