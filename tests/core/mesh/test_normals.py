import numpy as np
import pytest
from exact_fields import surface_of
from hypothesis import given, settings
from hypothesis import strategies as st
from surfaces import cylinder, ellipsoid, noisy, plane, seed_patch, similar, sphere

import core
from core.curvature.fitted_normals import _intercepts, fitted_normals
from core.mesh import normals as normals_module
from core.mesh.mending.repair import clean
from core.mesh.normals import Smoothing, smooth_normals, vertex_normals
from core.mesh.rings import ring_around


def test_exact_on_a_sphere() -> None:
    mesh = sphere(subdivisions=3)
    surface = surface_of(mesh)
    np.testing.assert_allclose(vertex_normals(surface), mesh.normal, atol=1e-12)


@settings(max_examples=20, deadline=None)
@given(st.floats(-6, 6))
def test_scale_does_not_matter(exponent: float) -> None:
    mesh = ellipsoid(subdivisions=2)
    scaled = similar(mesh, 10.0**exponent)
    np.testing.assert_allclose(
        vertex_normals(surface_of(mesh)), vertex_normals(surface_of(scaled)), atol=1e-9
    )


def test_triangles_without_area_keep_normals_finite() -> None:
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0.5, 0, 0], [0.5, 1, 0], [2, 0, 0], [3, 0, 0.0]])
    triangles = np.array([[0, 2, 3], [2, 1, 3], [0, 1, 2], [1, 4, 5]])
    surface, _ = clean(vertices, triangles)
    normal = vertex_normals(surface)
    np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1.0)
    np.testing.assert_allclose(normal[surface.source_vertex == 3], [[0, 0, 1.0]])


def test_smoothing_leaves_a_plane_and_a_sphere_as_they_are() -> None:
    flat = surface_of(plane(tilt=0.3))
    normal = vertex_normals(flat)
    np.testing.assert_allclose(smooth_normals(flat, normal, 5), normal, atol=1e-14)
    mesh = sphere(subdivisions=4)
    smooth = smooth_normals(surface_of(mesh), mesh.normal, 3)
    np.testing.assert_allclose(smooth, mesh.normal, atol=0.02)


def test_no_pass_changes_nothing_and_does_not_share_memory() -> None:
    surface = surface_of(ellipsoid(subdivisions=1))
    normal = vertex_normals(surface)
    copy = smooth_normals(surface, normal, 0)
    assert np.array_equal(copy, normal)
    assert not np.shares_memory(copy, normal)


def test_smoothing_takes_noise_away() -> None:
    mesh = ellipsoid(subdivisions=5)
    surface = surface_of(noisy(mesh, 0.05, seed=3))
    raw = vertex_normals(surface)
    errors = [
        np.linalg.norm(smooth_normals(surface, raw, passes) - mesh.normal, axis=1).mean()
        for passes in (0, 1, 3)
    ]
    assert errors[1] < 0.6 * errors[0]
    assert errors[2] < 0.7 * errors[1]


@pytest.mark.parametrize("passes", [1, 4])
def test_smoothed_normals_of_a_cylinder_stay_horizontal(passes: int) -> None:
    mesh = cylinder()
    smooth = smooth_normals(surface_of(mesh), mesh.normal, passes)
    np.testing.assert_allclose(smooth[:, 2], 0.0, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(smooth, axis=1), 1.0)


def linear_on_a_plane(surface):
    """Normals of a flat surface that turn at a constant rate, and their own plane."""
    x, y = surface.vertices[:, 0], surface.vertices[:, 1]
    return np.stack([0.02 * x + 0.01 * y, -0.03 * x, np.ones(len(x))], axis=1)


def test_a_linear_fit_keeps_what_changes_linearly_also_at_a_ragged_border() -> None:
    patch = seed_patch(600, seed=3)
    flat, _ = clean(patch.vertices * (1.0, 1.0, 0.0), patch.triangles)
    linear = linear_on_a_plane(flat)
    up = np.tile([0.0, 0.0, 1.0], (len(linear), 1))
    matrix = _intercepts(flat, up)
    fixed = np.abs(matrix @ linear - linear).max(axis=1)
    # All but corners of the hull whose few neighbours lie in a line.
    assert np.mean(fixed < 1e-12) > 0.97
    assert np.abs(np.asarray(matrix.sum(axis=1)) - 1.0).max() < 1e-12
    assert np.abs(smooth_normals(flat, linear, 1)[:, :2] - linear[:, :2]).max() > 1e-3


def test_a_linear_fit_takes_noise_away_and_stays_within_bounds() -> None:
    mesh = ellipsoid(subdivisions=4)
    surface = surface_of(noisy(mesh, 0.05, seed=3))
    raw = vertex_normals(surface)
    errors = [
        np.linalg.norm(fitted_normals(surface, raw, passes) - mesh.normal, axis=1).mean()
        for passes in (0, 1, 3)
    ]
    assert errors[2] < errors[1] < 0.7 * errors[0]
    many = fitted_normals(surface, raw, 200)
    np.testing.assert_allclose(np.linalg.norm(many, axis=1), 1.0, atol=1e-12)


def test_the_setting_chooses_the_filter() -> None:
    mesh = noisy(seed_patch(1500, seed=2), 0.05, seed=3)
    found = [
        core.detect(
            mesh.vertices,
            mesh.triangles,
            core.Settings(curvature="normals", normal_smoothing=3, normal_filter=name),
        )
        for name in ("mean", "fit")
    ]
    assert np.nanmax(np.abs(found[0].curvature.k1 - found[1].curvature.k1)) > 0.01


def test_the_blocks_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    surface = surface_of(noisy(ellipsoid(subdivisions=3), 0.1))
    normals = vertex_normals(surface)
    smoothed = smooth_normals(surface, normals, 3)
    monkeypatch.setattr(normals_module, "BLOCK", 50)
    np.testing.assert_allclose(vertex_normals(surface), normals, atol=1e-14)
    np.testing.assert_array_equal(smooth_normals(surface, normals, 3), smoothed)


@pytest.mark.parametrize("passes", [1, 3])
def test_smoothing_around_some_gives_them_what_smoothing_all_does(passes: int) -> None:
    surface = surface_of(noisy(ellipsoid(subdivisions=3), 0.1))
    normals, some = vertex_normals(surface), np.array([3, 70, 71, 500])
    around = Smoothing(surface).smoothed_at(normals, passes, some)
    np.testing.assert_array_equal(around[some], smooth_normals(surface, normals, passes)[some])
    far = np.setdiff1d(np.arange(len(normals)), ring_around(surface, some, passes))
    np.testing.assert_array_equal(around[far], normals[far])
