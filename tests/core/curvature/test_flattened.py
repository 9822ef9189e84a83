"""Fits over the sphere made a plane, and how their errors grow outwards."""

import numpy as np
import pytest
from fitted_heights import fit_heights

from core.curvature.fits.error_growth import error_growth
from core.curvature.fits.flattened import (
    fit_flattened,
    flattened,
    nearest_spheres,
    round_operator,
)
from core.curvature.fits.monge import operator_at

AXES = np.eye(3)[:, :, None]
CUBIC = {(2, 0): 0.9, (1, 1): 0.3, (0, 2): 0.5, (3, 0): 0.4, (2, 1): -0.3, (1, 2): 0.2, (0, 3): 0.6}


def disc(count, radius, seed=0):
    random = np.random.default_rng(seed)
    away, angle = radius * np.sqrt(random.uniform(size=count)), random.uniform(0, 2 * np.pi, count)
    return away * np.cos(angle), away * np.sin(angle)


@pytest.mark.parametrize("bend", [0.8, -1.5, 0.0])
def test_a_sphere_is_flat_and_comes_back(bend):
    x, y = disc(200, 0.5)
    z = bend * (x * x + y * y) / (1.0 + np.sqrt(1.0 - bend * bend * (x * x + y * y)))
    columns = tuple(value[:, None] for value in (x, y, z))
    assert nearest_spheres(*columns) == pytest.approx(bend, abs=1e-12)
    u, v, height, shrink = flattened(*columns, np.array([bend]))
    assert np.abs(height).max() < 1e-12 and (shrink > 0.5).all()
    level, one = {(0, 0): np.zeros(200)}, np.ones(200)
    operator = round_operator(level, one, bend * one, u[:, 0], v[:, 0])
    np.testing.assert_allclose(operator.place, [x, y, z], atol=1e-12)
    np.testing.assert_allclose(operator.mean, -bend, atol=1e-12)
    np.testing.assert_allclose(operator.scale * shrink[:, 0], 1.0)
    middle = np.array([0.0, 0.0, 1.0 / bend if bend else np.inf])
    if bend:
        normal = operator.normal(np.repeat(AXES, 200, axis=2))
        np.testing.assert_allclose(
            normal * np.sign(bend), (middle - operator.place.T) * abs(bend), atol=1e-12
        )


def test_a_sphere_is_known_from_any_window():
    """Tilted and seen in a slanting one: the term of the squares is 1 / height of its middle."""
    x, y = disc(200, 0.4)
    x, y = x + 0.2, 0.3 * y + 0.6 * x
    middle = np.array([0.4, -0.3, 1.2])
    z = middle[2] - np.sqrt(middle @ middle - (x - middle[0]) ** 2 - (y - middle[1]) ** 2)
    found = nearest_spheres(x[:, None], y[:, None], z[:, None])
    assert found == pytest.approx(1.0 / middle[2], rel=1e-9)


def test_the_operator_is_that_of_the_surface():
    """A cubic graph, which is no polynomial once it is flattened: on a small window the fit tells
    its shape operator away from the middle, frame and all. Over a plane it is exact, and chosen."""
    x, y = disc(800, 0.12)
    z = sum(c * x**a * y**b for (a, b), c in CUBIC.items())
    for degree, error in ((4, 3e-2), (5, 3e-3)):
        columns = x[:, None], y[:, None], z[:, None]
        (chosen,) = fit_flattened(*columns, [degree])
        assert chosen.bend == 0.0 and chosen.residual < 1e-9
        (flat,) = fit_flattened(*columns, [degree], planar=np.array([False]))
        assert flat.bend != 0.0 and flat.residual > 1e-8
        place = np.array([[0.03], [-0.02], [0.0]])
        place[2] = sum(c * place[0] ** a * place[1] ** b for (a, b), c in CUBIC.items())
        u, v, _, _ = flattened(*place, flat.bend)
        found = round_operator(
            flat.heights.coefficients, flat.radius, flat.bend, u / flat.radius, v / flat.radius
        )
        truth = operator_at({t: np.array([c]) for t, c in CUBIC.items()}, place[0], place[1])
        np.testing.assert_allclose(found.place, place, atol=error / 100)
        np.testing.assert_allclose(found.mean, truth.mean, atol=error)
        np.testing.assert_allclose(found.normal(AXES), truth.normal(AXES), atol=error / 10)
        first = found.tangent(1.0, 0.0, AXES)[0]
        np.testing.assert_allclose(first @ found.normal(AXES)[0], 0.0, atol=1e-12)
        np.testing.assert_allclose(np.linalg.norm(first), 1.0)
        turn = first @ truth.tangent(1.0, 0.0, AXES)[0] + 1j * (
            first @ truth.tangent(0.0, 1.0, AXES)[0]
        )
        np.testing.assert_allclose(
            found.deviator * turn**2, truth.real + 1j * truth.imaginary, atol=2 * error
        )


def test_wide_windows_on_a_bumpy_sphere_know_the_deviator_better():
    """r = 1 + a harmonic of degree three, over windows of half a radius: what a plane's heights of
    degree five cut off, the sphere's own, is nine tenths of their error."""
    x, y = disc(1500, 0.55, seed=3)
    direction = np.stack([x, y, np.sqrt(1.0 - x * x - y * y)])
    height = 1.0 + 0.03 * (direction[0] ** 3 - 3.0 * direction[0] * direction[1] ** 2)
    points = direction * height
    x, y, z = (points[k][:, None] for k in range(3))
    z = z - 1.0
    (flat,) = fit_flattened(x, y, z, [5])
    assert flat.bend == pytest.approx(-1.0, abs=0.1)
    radius = np.sqrt((x * x + y * y).mean())
    plain = fit_heights(x / radius, y / radius, z / radius, None, 5)
    middle = np.zeros(1)
    over_sphere = round_operator(flat.heights.coefficients, flat.radius, flat.bend, middle, middle)
    over_plane = operator_at(plain.coefficients, middle, middle)
    # The harmonic has an umbilic there.
    error = np.abs(over_plane.real + 1j * over_plane.imaginary) / radius
    assert np.abs(over_sphere.deviator) < 0.1 * error
    assert flat.heights.gap_error / flat.radius < 0.2 * plain.gap_error / radius


def test_lower_degrees_of_the_same_sums_are_fits_of_their_own():
    x, y = disc(300, 0.3)
    z = 0.5 * (x * x + y * y) + x**3 + np.random.default_rng(1).normal(size=300) * 1e-3
    columns = [value[:, None] for value in (x, y, z)]
    both = fit_flattened(*columns, [4, 5])
    for degree, found in zip((4, 5), both, strict=True):
        (alone,) = fit_flattened(*columns, [degree])
        assert set(found.heights.coefficients) == set(alone.heights.coefficients)
        for term, value in alone.heights.coefficients.items():
            np.testing.assert_allclose(found.heights.coefficients[term], value, rtol=1e-7)
        np.testing.assert_allclose(found.heights.gap_error, alone.heights.gap_error, rtol=1e-7)


@pytest.mark.parametrize("over", [{}, {"focus": 0.7}, {"planar": np.array([True, True])}])
def test_fits_ask_only_for_the_samples_that_are_meant(over):
    """Others fill the shorter up, wherever they lie."""
    x, y = disc(400, 0.3)
    z = 0.5 * (x * x + y * y) + x**3 + np.random.default_rng(1).normal(size=400) * 1e-3
    held = np.array([400, 317])
    columns = [np.column_stack([value, value]) for value in (x, y, z)]
    for value in columns:
        value[held[1] :, 1] = 3.0
    (both,) = fit_flattened(*columns, [4], **over, held=held)
    for row, count in enumerate(held):
        alone = {name: value[:1] if name == "planar" else value for name, value in over.items()}
        (own,) = fit_flattened(*(value[:count, None] for value in (x, y, z)), [4], **alone)
        np.testing.assert_allclose(both.bend[row], own.bend[0], rtol=1e-9)
        np.testing.assert_allclose(both.residual[row], own.residual[0], rtol=1e-9)
        for term, value in own.heights.coefficients.items():
            found = both.heights.coefficients[term][row]
            np.testing.assert_allclose(found, value[0], rtol=1e-7, atol=1e-9)


def test_a_focus_weighs_samples_by_their_distance_and_residuals_have_their_unit():
    x, y = disc(3000, 0.3)
    z = 0.5 * x * x - y**3 + np.random.default_rng(1).normal(size=3000) * 1e-3
    columns, over = [value[:, None] for value in (x, y, z)], {"planar": np.array([True])}
    (even,) = fit_flattened(*columns, [4], **over)
    assert even.residual == pytest.approx(1e-3, rel=0.05)
    (near,) = fit_flattened(*columns, [4], 0.7, **over)
    square = x * x + y * y
    radius = np.sqrt(square.mean())
    assert near.radius == pytest.approx(radius)
    root = (1.0 + square / (0.7 * square.mean())) ** -1.5
    terms = near.heights.coefficients
    design = np.stack([(x / radius) ** a * (y / radius) ** b for a, b in terms], axis=1)
    wanted = np.linalg.lstsq(root[:, None] * design, root * z / radius, rcond=None)[0]
    np.testing.assert_allclose(np.concatenate(list(terms.values())), wanted, rtol=1e-6, atol=1e-9)


def test_what_is_beyond_half_the_sphere_has_no_say():
    random = np.random.default_rng(2)
    points = random.normal(size=(600, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    x, y, z = (points[:, k][:, None] for k in range(3))
    near = z[:, 0] > 0.0
    moved = z.copy()
    over = {"planar": np.array([False])}
    (whole,) = fit_flattened(x, y, moved - 1.0, [4], **over)
    (part,) = fit_flattened(x[near], y[near], moved[near] - 1.0, [4], **over)
    for term, value in part.heights.coefficients.items():
        np.testing.assert_allclose(whole.heights.coefficients[term], value, atol=1e-9)


@pytest.mark.once
@pytest.mark.parametrize("degree", [3, 4, 5])
def test_errors_grow_as_those_of_fits_to_noise_do(degree):
    x, y = disc(4000, 1.0, seed=5)
    fits = 600
    noise = np.random.default_rng(6).normal(size=(len(x), fits))
    radius = np.sqrt((x * x + y * y).mean())
    one = np.ones((1, fits))
    x, y = (value[:, None] * one / radius for value in (x, y))
    fit = fit_heights(x, y, noise, None, degree)
    c = {term: 1e-6 * value for term, value in fit.coefficients.items()}

    def variance(away):
        at = np.full(fits, away)
        operator = operator_at(c, at, np.zeros(fits))
        return (operator.real**2 + operator.imaginary**2).mean()

    for away in (0.35, 0.7, 1.0):
        growth = float(error_growth(degree, np.array([away]))[0])
        assert variance(away) / variance(0.0) == pytest.approx(growth, rel=0.2)
