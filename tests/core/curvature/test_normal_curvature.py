import numpy as np
import pytest
from exact_fields import surface_of
from hypothesis import given, settings
from hypothesis import strategies as st
from surfaces import (
    cylinder,
    ellipsoid,
    inverted,
    plane,
    random_ellipsoid,
    renumbered,
    similar,
    sphere,
    torus,
)

from core.curvature.from_normals import curvature_from_normals
from core.mesh.normals import vertex_normals


def test_a_sphere_has_the_curvature_of_its_radius() -> None:
    mesh = sphere(2.5, subdivisions=4)
    surface = surface_of(mesh)
    field = curvature_from_normals(surface, vertex_normals(surface))
    np.testing.assert_allclose(field.k1 / surface.unit, 0.4, rtol=1e-3)
    np.testing.assert_allclose(field.k2 / surface.unit, 0.4, rtol=1e-3)


def test_a_plane_has_none() -> None:
    surface = surface_of(plane(tilt=0.7))
    field = curvature_from_normals(surface, vertex_normals(surface))
    np.testing.assert_allclose(field.k1, 0.0, atol=1e-10)
    np.testing.assert_allclose(field.k2, 0.0, atol=1e-10)


def test_directions_of_a_cylinder() -> None:
    mesh = cylinder(columns=96, rows=60)
    surface = surface_of(mesh)
    field = curvature_from_normals(surface, mesh.normal)
    np.testing.assert_allclose(np.abs(np.einsum("ij,ij->i", field.d1, mesh.d1)), 1.0, atol=2e-3)
    np.testing.assert_allclose(field.k1 / surface.unit, 1.0, rtol=5e-3)
    np.testing.assert_allclose(field.k2 / surface.unit, 0.0, atol=5e-3)


def test_frames_are_orthonormal() -> None:
    surface = surface_of(ellipsoid(subdivisions=3))
    field = curvature_from_normals(surface, vertex_normals(surface))
    np.testing.assert_allclose(np.cross(field.d1, field.d2), field.normal, atol=1e-12)
    assert np.all(field.k1 >= field.k2)


@pytest.mark.parametrize("image", [False, True], ids=["ellipsoid", "inverted"])
def test_second_order_on_regular_meshes(image: bool) -> None:
    errors = []
    for subdivisions in (3, 4, 5):
        mesh = ellipsoid(subdivisions=subdivisions)
        if image:
            mesh = inverted(mesh, (5.0, 1.0, 2.0))
        surface = surface_of(mesh)
        field = curvature_from_normals(surface, vertex_normals(surface))
        true = mesh.curvature_on(surface)
        errors.append(np.median(np.abs(field.k1 - true.k1)))
    assert errors[1] < 0.4 * errors[0]
    assert errors[2] < 0.4 * errors[1]


def test_irregular_meshes_stay_close() -> None:
    mesh = random_ellipsoid(20000)
    surface = surface_of(mesh)
    field = curvature_from_normals(surface, vertex_normals(surface))
    true = mesh.curvature_on(surface)
    assert np.median(np.abs(field.k1 - true.k1)) < 0.05 * np.median(true.k1)


@settings(max_examples=15, deadline=None)
@given(st.floats(-6, 6), st.integers(0, 100))
def test_invariance(exponent: float, seed: int) -> None:
    """Scale, rotation, offset and numbering change nothing but the unit."""
    turn = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    mesh = torus(columns=30, rows=14)
    surface = surface_of(mesh)
    reference = curvature_from_normals(surface, vertex_normals(surface))
    scale = 10.0**exponent
    moved = similar(mesh, scale, turn, tuple(scale * np.array([3.0, -2.0, 7.0])))
    other = surface_of(moved)
    field = curvature_from_normals(other, vertex_normals(other))
    np.testing.assert_allclose(
        field.k1 / other.unit * scale, reference.k1 / surface.unit, rtol=1e-7, atol=1e-7
    )
    np.testing.assert_allclose(
        np.abs(np.einsum("ij,ij->i", field.d1, reference.d1 @ turn.T)), 1.0, atol=1e-6
    )
    shuffled = surface_of(renumbered(mesh, seed))
    field = curvature_from_normals(shuffled, vertex_normals(shuffled))
    np.testing.assert_allclose(np.sort(field.k2), np.sort(reference.k2), atol=1e-10)


def test_some_vertices_have_the_operators_that_they_have_among_all():
    surface = surface_of(ellipsoid(subdivisions=3))
    normals = vertex_normals(surface)
    asked = surface.vertices[:, 0] > 0.5
    some = curvature_from_normals(surface, normals, vertices=asked)
    for name, value in vars(curvature_from_normals(surface, normals)).items():
        np.testing.assert_allclose(getattr(some, name)[asked], value[asked], atol=1e-12)
