"""Standard errors that are stated of places: variance and bias of the fits they are read off."""

from types import SimpleNamespace

import numpy as np
import pytest
from exact_fields import flat_surface

import core
from core.umbilics.located import (
    BIAS_CLEAN,
    BIAS_WINDOWS,
    LARGEST,
    Located,
    deviator_errors,
    standard_errors,
    with_bias,
)
from core.umbilics.refine import NextOrder


def one_place(p=1.0, q=0.0, uncertainty=0.01, noise=0.01):
    """An umbilic in the first triangle."""
    return Located(
        singular=np.zeros(1, int),
        triangle=np.zeros(1, int),
        barycentric=np.full((1, 3), 1.0 / 3.0),
        vertex=np.full(1, -1),
        index=np.full(1, 0.5),
        elliptic=np.ones(1, bool),
        normal=np.array([[0.0, 0.0, 1.0]]),
        x=np.array([[1.0, 0.0, 0.0]]),
        y=np.array([[0.0, 1.0, 0.0]]),
        p=np.array([p], complex),
        q=np.array([q], complex),
        curvature=np.zeros(1),
        noise=np.array([noise]),
        uncertainty=np.array([uncertainty]),
        slope_error=np.zeros(1),
        clarity=np.full(1, 100.0),
        asked=np.ones(1, bool),
        seen=np.ones(1, bool),
    )


@pytest.mark.parametrize("p, q", [(1.0, 0.1j), (0.3, -1.0), (1.0, 0.8)])
def test_stated_errors_are_those_of_an_axis(p, q):
    """The zeros of p z + q conj(z) + e, for errors e whose length is the given one on average."""
    error = 0.02
    e = error * np.random.default_rng(0).normal(size=(2, 20000)) / np.sqrt(2.0)
    e = e[0] + 1j * e[1]
    determinant = abs(p) ** 2 - abs(q) ** 2
    zeros = (q * np.conj(e) - np.conj(p) * e) / determinant
    assert np.allclose(p * zeros + q * np.conj(zeros), -e)
    slope = abs(abs(p) - abs(q))
    per_axis = np.sqrt(0.5 * (np.abs(zeros) ** 2).mean())
    # The fit that shows the place errs, whatever the field in the corners around errs by.
    for noise in (0.5 * error, 2.0 * error):
        found = one_place(p, q, error / slope, noise)
        assert standard_errors(found)[0] == pytest.approx(per_axis, rel=0.02)
        assert standard_errors(found, 3.0 * found.error)[0] == pytest.approx(3 * per_axis, rel=0.02)
    flat = one_place(1.0, 1.0, noise=error)
    assert standard_errors(flat)[0] == LARGEST


@pytest.mark.parametrize(
    "focused, windows, bias",
    [(True, False, BIAS_CLEAN), (False, False, 1.0), (False, True, BIAS_WINDOWS)],
)
def test_errors_are_known_as_well_as_the_fits_were_chosen(focused, windows, bias):
    surface, _ = flat_surface(cells=3)
    around = SimpleNamespace(focused=focused)
    rings = np.zeros(1, int) if windows else None
    found, kept = one_place(), np.zeros(1, bool)

    def error(neighbourhood):
        fitted = SimpleNamespace(neighbourhood=neighbourhood, rings=rings)
        return deviator_errors(surface, found, kept, fitted, core.Progress())[0]

    assert error(around) == bias * found.error[0]
    assert error(None) == found.error[0]


@pytest.mark.parametrize("places", [1, 4, 40])
@pytest.mark.parametrize("bias", [0.0, 1.0, 3.0, 30.0])
def test_a_bias_is_told_by_what_higher_degrees_change(bias, places):
    """Meshes with so many places each, whose fits have a variance of 1, and of 5 with two degrees
    more, which add fifteen terms: of a bias, whatever its size, as much is stated as there is."""
    random = np.random.default_rng(0)
    variance, larger, terms = np.full(places, 1.0), np.full(places, 5.0), np.full(places, 15.0)
    meshes = 4000 // places
    parts = random.normal(size=(3, meshes, places, 2)) / np.sqrt(2.0)
    own, other, off = parts.view(complex)[..., 0]
    # The fit of lower degree is independent of what both differ by.
    error, change = np.abs(own + bias * off), np.abs(2.0 * other - bias * off)
    usual = 1.0 + bias**2 / 4.0
    explained = usual * random.chisquare(15, size=(meshes, places)) / 15.0
    stated = np.stack([
        with_bias(NextOrder(one, variance, larger, terms, taken))
        for one, taken in zip(change, explained, strict=True)
    ])  # fmt: skip
    ratio = np.square(error) / stated
    # That there is none a few places tell only as well as fifteen terms each do.
    assert {1: 0.4, 4: 0.55, 40: 0.8}[places] <= ratio.mean() <= 1.15
    # Of two axes 86 and 99 % lie within two and three standard errors.
    assert np.mean(ratio <= 2.0) >= 0.84
    assert np.mean(ratio <= 4.5) >= 0.98


def test_places_without_higher_fits_say_nothing_of_others():
    one = NextOrder(*np.array([[2.0], [1.0], [5.0], [15.0], [3.0]]))
    two = NextOrder(*np.array([[2.0, np.nan], [1.0, 1.0], [5.0, 5.0], [15.0, 15.0], [3.0, 9.0]]))
    (alone,), (beside, unknown) = with_bias(one), with_bias(two)
    assert alone == beside and np.isnan(unknown)
