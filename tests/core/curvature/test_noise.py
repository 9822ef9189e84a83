"""The error of operators that come without one, from how neighbours differ."""

import numpy as np
import pytest
from exact_fields import field_on_plane, flat_surface

from core.curvature import noise as module
from core.curvature.noise import field_noise
from core.curvature.tolerances import (
    DISCRETIZATION,
    FIELD_REACH,
    NEIGHBOUR_SHARE,
    SINGLE_PRECISION,
)


def noise_of(surface, deviator, mean=0.0):
    field = field_on_plane(deviator, mean)
    return field_noise(surface, field.k1, field.k2, field.d1, field.normal)


@pytest.fixture(scope="module", params=[module._BLOCK, 64])
def square(request):
    """A square; its edges in one block, and in many."""
    before, module._BLOCK = module._BLOCK, request.param
    yield flat_surface(cells=12)
    module._BLOCK = before


def mean_edges(surface):
    own = np.repeat(np.arange(len(surface.vertices)), np.diff(surface.neighbour_start))
    length = np.linalg.norm(surface.vertices[own] - surface.vertices[surface.neighbours], axis=1)
    return np.bincount(own, length) / np.bincount(own)


def test_a_constant_field_has_the_error_of_the_mesh_alone(square):
    surface, place = square
    deviator = np.full(len(place), 0.4 * np.exp(0.7j))
    noise, radius = noise_of(surface, deviator, mean=-3.0)
    edge = mean_edges(surface)
    coarse = DISCRETIZATION * 3.2 * (3.2 * edge) ** 2 + SINGLE_PRECISION * 3.2
    np.testing.assert_allclose(noise, NEIGHBOUR_SHARE * coarse, rtol=1e-12)
    np.testing.assert_allclose(radius, FIELD_REACH * edge, rtol=1e-12)


def test_a_vertex_that_differs_is_noise_for_its_neighbours_too(square):
    """By the squares of what each differs from the mean of its neighbours, averaged once more."""
    surface, place = square
    deviator = np.ones(len(place), complex)
    odd = np.argmin(np.abs(place))
    deviator[odd] = 1.5 * np.exp(0.4j)
    noise, _ = noise_of(surface, deviator)
    start, neighbours = surface.neighbour_start, surface.neighbours
    fans = [neighbours[start[row] : start[row + 1]] for row in range(len(place))]
    square_of = [abs(deviator[row] - deviator[fan].mean()) ** 2 for row, fan in enumerate(fans)]
    largest = 0.5 * np.abs(deviator)
    coarse = DISCRETIZATION * largest * (largest * mean_edges(surface)) ** 2
    coarse += SINGLE_PRECISION * largest
    expected = [
        np.sqrt(np.mean([square_of[row], *(square_of[other] for other in fan)]) + coarse[row] ** 2)
        for row, fan in enumerate(fans)
    ]
    np.testing.assert_allclose(noise, NEIGHBOUR_SHARE * np.array(expected), rtol=1e-9)


def test_frames_do_not_matter(square):
    """Every d1 may be the opposite one, and tangent planes may be turned against each other."""
    surface, place = square
    field = field_on_plane(np.exp(1j * place.real), mean=1.0)
    before, _ = field_noise(surface, field.k1, field.k2, field.d1, field.normal)
    flipped = np.where(np.arange(len(place))[:, None] % 2, field.d1, -field.d1)
    after, _ = field_noise(surface, field.k1, field.k2, flipped, field.normal)
    np.testing.assert_allclose(after, before, rtol=1e-12)
    odd = (np.arange(len(place)) % 2)[:, None]
    # A plane turned about the direction itself leaves it where it is.
    level = field_on_plane(np.ones(len(place), complex), mean=1.0)
    for angle in (0.5, 2.0):
        across = np.cross(level.normal, level.d1)
        tilted = np.where(odd, np.cos(angle) * level.normal + np.sin(angle) * across, level.normal)
        turned, upright = (
            field_noise(surface, level.k1, level.k2, level.d1, normal)[0]
            for normal in (tilted, level.normal)
        )
        np.testing.assert_allclose(turned, upright, rtol=1e-9)
    # Normals that are opposite leave the rotation open; the field stays finite.
    upside = np.where(np.arange(len(place))[:, None] % 2, field.normal, -field.normal)
    assert np.isfinite(field_noise(surface, field.k1, field.k2, field.d1, upside)[0]).all()
