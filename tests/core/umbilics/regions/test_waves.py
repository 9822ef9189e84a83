"""Waves of a few edges are said to be there, and the scale that is named looks past them."""

import dataclasses
import re
from functools import cache

import numpy as np
import pytest
from surfaces import icosphere

import core
from core.umbilics.regions.waves import words_on_waves

VERTICES, TRIANGLES = icosphere(5)
HIGH = 0.008


def ellipsoid(height):
    """An ellipsoid of 10,242 vertices with waves of so much of its radius, a dozen edges long."""
    points = VERTICES * (1.3, 1.1, 0.9)
    return points * (1.0 + height * np.prod(np.sin(10.0 * points), axis=1))[:, None]


@cache
def wavy():
    """What is found on high waves."""
    return core.detect(ellipsoid(HIGH), TRIANGLES)


def said(detection):
    return [text for text in detection.warnings if "waves" in text]


@pytest.mark.once
def test_waves_are_said_and_the_named_scale_leaves_the_umbilics_of_the_form_beneath():
    detection = wavy()
    (text,) = said(detection)
    assert len(detection.umbilics) > 100 and f"{len(detection.umbilics)} umbilics" in text
    length = float(re.search(r"about ([\d.]+\d)", text)[1])
    settings = core.Settings(scale=length, scale_unit="length")
    past = core.detect(ellipsoid(HIGH), TRIANGLES, settings)
    assert len(past.umbilics) == 4 and not said(past)


def test_few_umbilics_are_no_waves():
    assert not said(core.detect(ellipsoid(0.0), TRIANGLES))
    some = core.detect(ellipsoid(0.002), TRIANGLES)
    assert len(some.umbilics) > 20 and not said(some)


def test_many_umbilics_of_a_fine_mesh_are_its_own():
    many = wavy().candidates
    assert words_on_waves(many, 100 * len(many)) and not words_on_waves(many, 150 * len(many))


def test_a_hundred_certain_and_resolved_ones_on_few_vertices_are_waves():
    """In a row, each two from the next but for the last, which a median does not see."""
    count = 100
    place = np.zeros((count, 3))
    place[:, 0] = 2.0 * np.arange(count)
    place[-1] += 50.0
    every = dataclasses.replace(
        wavy().candidates.select(np.arange(count)),
        position=place,
        certain=np.ones(count, bool),
        resolved=np.ones(count, bool),
    )
    (text,) = words_on_waves(every, 11_999)
    assert "100 umbilics" in text and text.endswith("a Length of about 8.")
    assert words_on_waves(every, 12_000) == ()
    assert words_on_waves(every.select(np.arange(99)), 1_000) == ()
    one = np.arange(count) == 0
    for name in ("certain", "resolved"):
        assert words_on_waves(dataclasses.replace(every, **{name: ~one}), 1_000) == ()
