"""Waves of a few edges are said to be there, and the scale that is named looks past them."""

import re

import numpy as np
import pytest
from surfaces import icosphere

import core
from core.umbilics.regions.waves import words_on_waves

VERTICES, TRIANGLES = icosphere(5)


def ellipsoid(height):
    """An ellipsoid of 10,242 vertices with waves of so much of its radius, a dozen edges long."""
    points = VERTICES * (1.3, 1.1, 0.9)
    return points * (1.0 + height * np.prod(np.sin(10.0 * points), axis=1))[:, None]


def said(detection):
    return [text for text in detection.warnings if "waves" in text]


@pytest.mark.once
def test_waves_are_said_and_the_named_scale_leaves_the_umbilics_of_the_form_beneath():
    wavy = ellipsoid(0.008)
    detection = core.detect(wavy, TRIANGLES)
    (text,) = said(detection)
    assert len(detection.umbilics) > 100 and f"{len(detection.umbilics)} umbilics" in text
    length = float(re.search(r"about ([\d.]+\d)", text)[1])
    past = core.detect(wavy, TRIANGLES, core.Settings(scale=length, scale_unit="length"))
    assert len(past.umbilics) == 4 and not said(past)


def test_few_umbilics_are_no_waves():
    assert not said(core.detect(ellipsoid(0.0), TRIANGLES))
    some = core.detect(ellipsoid(0.002), TRIANGLES)
    assert len(some.umbilics) > 20 and not said(some)


def test_many_umbilics_of_a_fine_mesh_are_its_own():
    many = core.detect(ellipsoid(0.008), TRIANGLES).candidates
    assert words_on_waves(many, 100 * len(many)) and not words_on_waves(many, 150 * len(many))
