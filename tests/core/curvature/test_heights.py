"""Polynomial heights: exact on polynomials, honest about what they do not know."""

import numpy as np
import pytest
from fitted_heights import fit_heights

from core.curvature.fits.height_fit import heights_at


def samples(count: int, fits: int, seed: int = 0):
    random = np.random.default_rng(seed)
    return random.uniform(-1, 1, (2, count, fits))


@pytest.mark.parametrize("degree", [2, 3, 4, 5])
@pytest.mark.parametrize("weighted", [False, True])
def test_a_polynomial_of_the_degree_is_recovered(degree, weighted):
    x, y = samples(40, 7)
    random = np.random.default_rng(1)
    terms = [(t - b, b) for t in range(degree + 1) for b in range(t + 1)]
    truth = {term: random.standard_normal(7) for term in terms}
    z = sum(c * x**a * y**b for (a, b), c in truth.items())
    weights = random.uniform(0.1, 2, x.shape) if weighted else None
    fit = fit_heights(x, y, z, weights, degree)
    for term, coefficient in truth.items():
        np.testing.assert_allclose(fit.coefficients[term], coefficient, atol=1e-9)
    assert fit.determined.all()
    assert fit.residual.max() < 1e-7


def test_it_is_the_weighted_least_squares_solution():
    x, y = samples(25, 3)
    random = np.random.default_rng(2)
    z, weights = random.standard_normal((2, 25, 3))
    weights = np.abs(weights)
    fit = fit_heights(x, y, z, weights, 3)
    terms = list(fit.coefficients)
    for k in range(3):
        design = np.stack([x[:, k] ** a * y[:, k] ** b for a, b in terms], axis=1)
        root = np.sqrt(weights[:, k])
        expected = np.linalg.lstsq(design * root[:, None], z[:, k] * root, rcond=None)[0]
        np.testing.assert_allclose([fit.coefficients[t][k] for t in terms], expected, atol=1e-8)


def test_the_error_estimate_is_the_spread_under_noise():
    x, y = samples(30, 1)
    fits = 4000
    x, y = np.repeat(x, fits, axis=1), np.repeat(y, fits, axis=1)
    noise = 0.01 * np.random.default_rng(3).standard_normal(x.shape)
    fit = fit_heights(x, y, x**2 + noise, None, 3)
    deviator = 2 * (fit.coefficients[2, 0] - fit.coefficients[0, 2]) - 2.0
    deviator = np.hypot(deviator, 2 * fit.coefficients[1, 1])
    np.testing.assert_allclose(fit.residual.mean(), 0.01, rtol=0.03)
    spread = np.sqrt((deviator**2).mean())
    np.testing.assert_allclose(np.sqrt((fit.gap_error**2).mean()), spread, rtol=0.05)


def test_points_on_a_line_are_called_undetermined():
    x, _ = samples(20, 2)
    y = np.zeros_like(x)
    y[:, 1] = samples(20, 2)[1][:, 1]
    fit = fit_heights(x, y, x * x, None, 3)
    assert list(fit.determined) == [False, True]
    assert all(np.isfinite(values).all() for values in fit.coefficients.values())


def test_heights_at_places_are_those_of_the_terms():
    random = np.random.default_rng(4)
    coefficients = {(a, b): random.normal(size=7) for a in range(4) for b in range(3)}
    x, y = random.normal(size=(2, 5, 7))
    wanted = sum(value * x**a * y**b for (a, b), value in coefficients.items())
    np.testing.assert_allclose(heights_at(coefficients, x, y), wanted, rtol=1e-10)
    np.testing.assert_allclose(heights_at(coefficients, x[0], y[0]), wanted[0], rtol=1e-10)
