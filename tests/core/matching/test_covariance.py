"""Standard errors of fits whose residuals are wrong together at neighbouring samples."""

import numpy as np
import pytest

from core.matching.covariance import clustered_covariance


@pytest.mark.once
@pytest.mark.parametrize("width", [0.0, 0.002, 0.005])
def test_the_errors_are_those_of_repeated_fits(width):
    """Of lines fitted to noise that is white, or smooth over less than a part's length."""
    random = np.random.default_rng(4)
    places = random.random((1500, 1))
    design = np.concatenate([np.ones_like(places), places - 0.5], axis=1)
    knots = np.linspace(-0.1, 1.1, 1200)
    kernel = np.exp(-0.5 * ((places - knots) / max(width, 1e-9)) ** 2)
    found, stated = [], []
    for _ in range(150):
        white = 0.1 * random.normal(size=len(places))
        residual = white + (kernel @ random.normal(size=len(knots)) if width else 0.0)
        fit = np.linalg.lstsq(design, residual, rcond=None)[0]
        found.append(fit)
        stated.append(np.diag(clustered_covariance(design, residual - design @ fit, places)))
    true = np.sqrt(np.mean(np.square(found), axis=0))
    said = np.sqrt(np.mean(stated, axis=0))
    np.testing.assert_allclose(said / true, 1.0, atol=0.25)


def test_white_residuals_have_the_errors_of_plain_least_squares():
    random = np.random.default_rng(0)
    places = random.random((4000, 3))
    design = random.normal(size=(4000, 3)) * (1.0, 3.0, 0.2)
    residual = 0.3 * random.normal(size=4000)
    plain = 0.3 * np.sqrt(np.diag(np.linalg.inv(design.T @ design)))
    said = np.sqrt(np.diag(clustered_covariance(design, residual, places)))
    np.testing.assert_allclose(said / plain, 1.0, atol=0.3)


def test_fewer_samples_than_parts_are_no_fault():
    places = np.arange(7.0)[:, None]
    design = np.concatenate([np.ones_like(places), places], axis=1)
    covariance = clustered_covariance(design, np.ones(7), places)
    assert np.isfinite(covariance).all()
