"""Where the noise is above the shape: nothing is invented there, and it is said."""

from __future__ import annotations

import numpy as np
import pytest
import surfaces

import core
from core.umbilics.regions.drowned import drowned_words

WORDS = "of the surface the two curvatures differ by no more than their error"


def said(detection: core.Detection) -> list[str]:
    return [text for text in detection.warnings if WORDS in text]


@pytest.mark.once
@pytest.mark.parametrize("seed", [1, 2])
def test_tips_of_a_noisy_ellipsoid_are_no_spheres(seed):
    # Fits over three rings show nothing at the tips but noise, those over ten the umbilics.
    surface = surfaces.noisy(surfaces.ellipsoid(subdivisions=4), 0.1, seed=seed)
    detection = core.detect(surface.vertices, surface.triangles)
    assert len(detection.regions) == 0
    assert list(detection.umbilics.index) == [0.5] * 4 and detection.index_sum == 2.0
    away = detection.umbilics.position[:, None] - surface.umbilics.position
    assert np.linalg.norm(away, axis=2).min(axis=0).max() < 3.0 * surface.edge_length


@pytest.mark.slow
def test_a_drowned_area_is_said_with_its_share():
    surface = surfaces.ellipsoid((1.01, 1.0, 0.99), subdivisions=4)
    clean = core.detect(surface.vertices, surface.triangles)
    assert len(clean.umbilics) == 4 and not said(clean)
    rough = surfaces.noisy(surface, 0.4, seed=1)
    (text,) = said(core.detect(rough.vertices, rough.triangles))
    share = int(text.split()[1])
    assert 50 <= share <= 100


@pytest.mark.once
@pytest.mark.parametrize("noise", [0.0, 0.02, 0.2])
def test_nothing_is_said_where_the_shape_stands_out(noise):
    for surface in (surfaces.ellipsoid(subdivisions=4), surfaces.torus(columns=60, rows=24)):
        rough = surfaces.noisy(surface, noise, seed=1)
        assert not said(core.detect(rough.vertices, rough.triangles))


@pytest.mark.once
def test_a_sphere_is_not_drowned():
    surface = surfaces.noisy(surfaces.sphere(subdivisions=4), 0.1, seed=0)
    detection = core.detect(surface.vertices, surface.triangles)
    assert len(detection.regions) == 1 and not said(detection)


def test_small_shares_are_not_rounded_to_nothing():
    assert drowned_words(0.004).startswith("On less than 1 % of the surface")
    assert drowned_words(0.126).startswith("On 13 % of the surface")
