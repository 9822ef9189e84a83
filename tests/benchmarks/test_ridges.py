"""The benchmarks of ridges and features: what is scored, and the page's figures."""

import numpy as np
import pytest
from scipy.spatial import cKDTree
from surfaces import ellipsoid

import core
from benchmarks.features import Figures, figures, row_of
from benchmarks.ridge_surfaces import meshed, surfaces
from benchmarks.ridges import Score, sampled, scored, with_noise


def line(*points):
    return np.array(points, float)


def test_a_line_is_near_missed_or_false():
    truth = [line((0, 0, 0), (10, 0, 0))]
    near = line((0, 0.5, 0), (5, 0.5, 0))
    far = line((0, 0, 4), (2, 0, 4))
    score = scored([near, far], truth, 1.0, 1.0)
    assert score.distance == pytest.approx(0.5, abs=0.01)
    # Up to (5, 0, 0) and as far again as half an edge to its side is within an edge.
    assert score.missed == pytest.approx(0.5 - np.sqrt(0.75) / 10, abs=0.02)
    assert score.false == pytest.approx(0.2)
    nothing = scored([], truth, 1.0, 1.0)
    assert nothing.missed == 1.0 and nothing.false == 0.0
    no_truth = scored([far], [], 1.0, 4.0)
    assert Score(np.nan, np.nan, np.nan, no_truth.false).cells() == ("", "", "", "50.0")


def test_samples_stand_for_the_whole_length():
    points, length = sampled([line((0, 0, 0), (1, 0, 0), (1, 2, 0))], 0.3)
    assert length.sum() == pytest.approx(3.0)
    assert length.max() <= 0.3
    assert np.average(points, axis=0, weights=length) == pytest.approx([5 / 6, 2 / 3, 0])


@pytest.mark.parametrize("surface", surfaces(), ids=lambda surface: surface.name)
def test_meshes_lie_on_their_surfaces_and_exact_slopes_agree_with_differences(surface):
    vertices, triangles = meshed(surface, "icosphere")
    value, gradient = surface.value(vertices), surface.gradient(vertices)
    assert np.abs(value / np.linalg.norm(gradient, axis=1)).max() < 1e-9
    a, b, c = np.moveaxis(vertices[triangles], 1, 0)
    assert np.einsum("tc,tc->", np.cross(b - a, c - a), gradient[triangles[:, 0]]) > 0
    points = vertices[::997]
    step = 1e-5 * np.random.default_rng(0).normal(size=points.shape)
    change = surface.gradient(points + step) - surface.gradient(points - step)
    expected = 2 * np.einsum("nij,nj->ni", surface.hessian(points), step)
    np.testing.assert_allclose(change, expected, rtol=1e-4, atol=1e-8)
    rise = surface.value(points + step) - surface.value(points - step)
    slope = 2 * np.einsum("ni,ni->n", surface.gradient(points), step)
    np.testing.assert_allclose(rise, slope, rtol=1e-4, atol=1e-9)


@pytest.mark.slow
def test_the_short_crests_at_the_corners_of_a_stretched_quartic_are_found_under_noise():
    """They are no longer than two radii of fits that are wide enough for the noise."""
    surface = surfaces()[-1]
    vertices, triangles = meshed(surface, "icosphere")
    moved = with_noise(vertices, triangles, 0.05)
    lines = core.Guide(moved, triangles, core.detect(moved, triangles)).ridges()
    edge = np.linalg.norm(vertices[triangles[:, 0]] - vertices[triangles[:, 1]], axis=1).mean()
    signs = np.array([(1, 1, 1), (1, -1, 1), (-1, 1, 1), (-1, -1, 1)])
    # By the exact zeros, which take too long for a test.
    away, _ = cKDTree(lines.position).query(signs * (1.79, 1.15, 0.0))
    assert len(lines) == 6 and away.max() < edge


def test_figures_of_a_plan():
    mesh = ellipsoid(subdivisions=4)
    detection = core.detect(mesh.vertices, mesh.triangles)
    guide = core.Guide(mesh.vertices, mesh.triangles, detection)
    found = figures(guide, core.GuidanceSettings(smoothness=0.3))
    assert found.poles == 8 and found.near == 0 and found.angle < 2.0
    assert Figures(8, 1.0, 0).beats(Figures(9, 1.0, 0)) and Figures(8, 2.0, 0).beats(
        Figures(8, 2.6, 0)
    )
    for other in (Figures(8, 1.4, 0), Figures(7, 9.0, 0), Figures(8, 0.9, 0)):
        assert not Figures(8, 1.0, 0).beats(other)
    row = row_of("ellipsoid", mesh.vertices, mesh.triangles)
    assert row[:4] == ("ellipsoid", "5,120", "0", "0") and len(row) == 11 and row[-1] == ""
