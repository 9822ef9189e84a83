"""A ship's hull and a progressive lens: what is known of them, and what is detected."""

import numpy as np
import pytest
from surfaces.design import power, progressive_lens, wigley_hull

import core


@pytest.fixture(scope="module")
def lens():
    return progressive_lens(6000)


def test_the_line_of_the_lens_is_umbilical_and_minkwitz_is_right_beside_it(lens):
    near = np.argsort(np.abs(lens.vertices[:, 0]))[:20]
    x, y = lens.vertices[near, 0], lens.vertices[near, 1]
    curvature, growth = power(y)
    np.testing.assert_allclose(-0.5 * (lens.k1 + lens.k2)[near], curvature, rtol=2e-3)
    np.testing.assert_allclose((lens.k1 - lens.k2)[near], 2.0 * np.abs(x * growth), rtol=1e-3)


def test_curvature_along_the_line_and_the_gap_beside_it_are_found(lens):
    field = core.detect(lens.vertices, lens.triangles).curvature
    x, y = lens.vertices[:, 0], lens.vertices[:, 1]
    inside = (np.abs(x) < 0.6) & (np.abs(y) < 0.6)
    curvature, growth = power(y)
    line = inside & (np.abs(x) < 0.05)
    np.testing.assert_allclose(-0.5 * (field.k1 + field.k2)[line], curvature[line], rtol=0.02)
    beside = inside & (np.abs(x) > 0.05) & (np.abs(x) < 0.15) & (growth > 0.1)
    ratio = field.gap[beside] / (2.0 * np.abs(x) * growth)[beside]
    assert abs(np.median(ratio) - 1.0) < 0.03


def test_a_deep_hull_has_its_two_stars_on_the_waterline():
    mesh = wigley_hull(50, breadth=0.3, draught=0.3)
    found = core.detect(mesh.vertices, mesh.triangles, core.Settings(crease_angle=30.0)).umbilics
    away = np.linalg.norm(found.position[:, None] - mesh.umbilics.position[None], axis=2)
    assert len(found) == 2
    assert (away.min(axis=0) < 0.1 * mesh.edge_length).all()
    assert (found.kind == "star").all()
