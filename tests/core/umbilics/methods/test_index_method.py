import numpy as np
import pytest
from exact_fields import field_on_plane, flat_surface, points_of, surface_of
from hypothesis import given, settings
from hypothesis import strategies as st
from surfaces import ellipsoid, inverted, quartic, seed_patch, sphere, torus

from core.umbilics.methods.vertex_index import detect_by_index


@pytest.mark.parametrize("power", [-2, -1, 1, 2])
def test_index_of_powers(power: int) -> None:
    """The directions of D = z^k turn k/2 times around 0; one ring around 0 sees it all."""
    surface, z = flat_surface(cells=20)
    centre = np.flatnonzero(np.abs(z) < 1e-12)
    value = np.where(np.abs(z) > 0, z, 1.0)
    deviator = value**power if power > 0 else np.conj(value) ** -power
    raw = detect_by_index(surface, field_on_plane(deviator))
    at_centre = raw.vertex == centre[0]
    assert raw.index[at_centre] == pytest.approx(0.5 * power)
    assert np.all(np.abs(z[raw.vertex]) < 0.2)


@settings(max_examples=25, deadline=None)
@given(
    st.complex_numbers(max_magnitude=0.7),
    st.floats(0, 2 * np.pi),
    st.sampled_from([1, -1]),
)
def test_one_zero_shows_at_one_to_three_vertices(place: complex, turn: float, sign: int) -> None:
    surface, z = flat_surface()
    deviator = (z - place) * np.exp(1j * turn)
    if sign < 0:
        deviator = np.conj(deviator)
    raw = detect_by_index(surface, field_on_plane(deviator, mean=2.0))
    assert 1 <= len(raw) <= 5  # more than three only where the zero lies on an edge or vertex
    assert np.all(raw.index == 0.5 * sign)
    assert np.all(np.abs(z[raw.vertex] - place) < 2 * 0.1 * 1.5)


def test_hits_name_a_triangle_with_the_vertex() -> None:
    mesh = ellipsoid(subdivisions=4)
    surface = surface_of(mesh)
    raw = detect_by_index(surface, mesh.curvature_on(surface))
    corner = raw.barycentric.argmax(axis=1)
    assert np.array_equal(surface.triangles[raw.triangle, corner], raw.vertex)
    assert np.all(raw.barycentric.max(axis=1) == 1.0)


@pytest.mark.parametrize(
    "mesh",
    [ellipsoid(subdivisions=5), inverted(ellipsoid(subdivisions=5), (5.0, 1.0, 0.5)), quartic(6)],
    ids=lambda mesh: mesh.name,
)
def test_closed_surfaces(mesh) -> None:
    surface = surface_of(mesh)
    raw = detect_by_index(surface, mesh.curvature_on(surface))
    points = points_of(surface, raw.triangle, raw.barycentric)
    distance = np.linalg.norm(points[:, None] - mesh.umbilics.position[None], axis=2)
    edge = mesh.local_edge[raw.vertex]
    assert np.all(distance.min(axis=1) < 2.0 * edge)
    nearest = distance.argmin(axis=1)
    assert set(nearest) == set(range(len(mesh.umbilics)))
    lone = np.abs(mesh.umbilics.index[nearest]) == 0.5
    assert np.all(raw.index[lone] == mesh.umbilics.index[nearest[lone]])
    assert not raw.warnings


def test_nothing_on_a_torus() -> None:
    mesh = torus()
    surface = surface_of(mesh)
    assert len(detect_by_index(surface, mesh.curvature_on(surface))) == 0


def test_border_vertices_are_counted() -> None:
    mesh = seed_patch(2000)
    surface = surface_of(mesh)
    raw = detect_by_index(surface, mesh.curvature_on(surface))
    assert not np.any(surface.border[raw.vertex])
    assert str(np.count_nonzero(surface.border)) in raw.warnings[0]


def test_a_sphere_is_not_an_error() -> None:
    mesh = sphere(subdivisions=3)
    surface = surface_of(mesh)
    detect_by_index(surface, mesh.curvature_on(surface))
