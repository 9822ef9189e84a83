"""Maps whose lightness tells the value, and ranges that a few extremes do not spoil."""

import importlib

import numpy as np
import pytest

maps = importlib.import_module("bl_ext.user_default.umbilics.operators.drawing.colour_maps")


def oklab(linear):
    """(..., 3) OKLab of linear sRGB (..., 3), the way that the maps are made against."""
    return np.cbrt(linear @ maps._TO_LMS.T) @ maps._TO_LAB.T


def decoded(srgb):
    """(..., 3) linear sRGB of sRGB as it is stored in pictures (IEC 61966-2-1)."""
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def lightness(srgb):
    return oklab(decoded(srgb))[:, 0]


def test_oklab_of_white_and_red():
    assert oklab(np.array([1.0, 1.0, 1.0])) == pytest.approx([1.0, 0.0, 0.0], abs=1e-4)
    # Ottosson's own values.
    assert oklab(np.array([1.0, 0.0, 0.0])) == pytest.approx([0.62796, 0.22486, 0.12585], abs=1e-4)


def test_way_there_and_back():
    colours = np.random.default_rng(1).random((100, 3))
    assert np.abs(maps.linear_srgb(oklab(colours)) - colours).max() < 1e-6
    assert np.abs(maps.encoded(decoded(colours)) - colours).max() < 1e-12


def test_sequential_map_rises_evenly_in_lightness():
    step = np.diff(lightness(maps.sequential()))
    assert step.min() > 0.0
    assert step.max() / step.mean() < 1.1


def test_diverging_map_is_as_light_on_both_sides_and_palest_in_the_middle():
    light = lightness(maps.diverging())
    assert np.abs(light - light[::-1]).max() < 2e-3
    assert (np.diff(light[:128]) > 0).all()
    assert light[127] > 0.94


def test_neighbouring_steps_look_equally_far_apart():
    for colours in (maps.sequential(), maps.diverging()):
        lab = oklab(decoded(colours))
        step = np.linalg.norm(np.diff(lab, axis=0), axis=1)
        assert step.max() < 4.0 * np.median(step)


def test_ranges():
    values = np.r_[np.linspace(-1.0, 3.0, 999), 1e9, np.nan]
    low, high = maps.robust_range(values, 2.0, signed=True)
    assert low == -high
    assert 2.5 < high < 3.0
    assert maps.robust_range(np.r_[0.1, 1.0, 2.0], 0.0, signed=False) == (0.0, 2.0)
    assert maps.robust_range(np.array([np.nan]), 2.0, signed=False) == (0.0, 1.0)
    low, high = maps.robust_range(np.zeros(5), 2.0, signed=True)
    assert low < 0.0 < high


def test_values_beyond_the_range_take_its_ends_and_unknown_ones_are_grey():
    colours = maps.diverging()
    seen = maps.coloured(np.array([-9.0, 0.0, 9.0, np.nan]), -1.0, 1.0, colours)
    assert np.array_equal(seen[0], colours[0])
    assert np.array_equal(seen[2], colours[-1])
    assert seen[1].min() > 0.9
    assert np.array_equal(seen[3], maps.UNKNOWN_COLOUR)


def test_above_a_range_without_width_is_its_end():
    colours = np.eye(3)
    seen = maps.coloured(np.array([-1.0, 2.0, 2.1, 1e300]), 2.0, 2.0, colours)
    assert seen.tolist() == colours[[0, 0, 2, 2]].tolist()


def test_distinct_colours_are_distinct():
    lab = oklab(decoded(maps.distinct(8)))
    apart = np.linalg.norm(lab[:, None] - lab[None], axis=2) + np.eye(8)
    assert apart.min() > 0.08
