import numpy as np
import pytest
from exact_fields import field_on_plane, flat_surface, points_of, surface_of
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from surfaces import ellipsoid, noisy, paraboloid, renumbered, seed_patch

import core
from core import CurvatureField
from core.curvature.from_normals import curvature_from_normals
from core.fields.transport import tangents
from core.mesh.mending.repair import clean
from core.mesh.normals import vertex_normals
from core.umbilics.methods.curvature_tensor import (
    detect_by_curvature_tensor,
    unfolded_along_seams,
    unfolded_by_uv,
    zeros_in_triangles,
)
from core.umbilics.methods.shape_operators import face_deviators, zero_crossings

NO_SEAMS = np.zeros((0, 2), dtype=np.int64)


@pytest.mark.once
@settings(max_examples=30, deadline=None)
@given(
    st.lists(
        st.tuples(st.complex_numbers(max_magnitude=0.9), st.booleans()), min_size=1, max_size=4
    ),
    st.floats(0, 6.3),
)
def test_s_and_c_agree_on_a_flat_chart(zeros, turn: float) -> None:
    """Proposition 3.5: in conformal coordinates operator and curvature tensor are one."""
    places = np.array([place for place, _ in zeros])
    # Zeros in one triangle are not what a linear interpolation can tell apart.
    apart = np.abs(places[:, None] - places[None]) + np.eye(len(places))
    assume(apart.min() > 0.3)
    surface, z = flat_surface(cells=23)
    # On an edge round-off may give the published test to both triangles, or to none.
    assume(all(np.abs(_edge_coordinates(place, cells=23)).min() > 1e-6 for place in places))
    deviator = np.full(len(z), np.exp(1j * turn))
    for place, conjugate in zeros:
        factor = z - place
        deviator = deviator * (np.conj(factor) if conjugate else factor)
    field = field_on_plane(deviator, mean=1.0)
    by_s = by_triangles(surface, field, "projection")
    unfolding = unfolded_along_seams(surface, NO_SEAMS)
    by_c = detect_by_curvature_tensor(surface, field, unfolding)
    points_s = points_of(surface, by_s[0], by_s[1])
    points_c = points_of(surface, by_c.triangle, by_c.barycentric)
    inner = np.all(np.abs(points_c[:, :2]) < 0.97, axis=1)
    for point in points_c[inner]:
        assert np.min(np.linalg.norm(points_s - point, axis=1), initial=9.0) < 1e-6
    for point in points_s[np.all(np.abs(points_s[:, :2]) < 0.97, axis=1)]:
        assert np.min(np.linalg.norm(points_c - point, axis=1), initial=9.0) < 1e-6


def _edge_coordinates(place: complex, cells: int) -> np.ndarray:
    """How far a place of `flat_surface` is from the next edges along x, y and across the
    diagonals, in cells."""
    x, y = (cells * (0.5 + 0.5 * part) for part in (place.real, place.imag))
    along = np.array([x, y, x - y, x + y])
    return along - np.round(along)


@pytest.mark.parametrize("seed", range(3))
def test_s_and_c_agree_on_a_random_field(seed: int) -> None:
    surface, z = flat_surface(cells=23)
    random = np.random.default_rng(seed)
    field = field_on_plane(random.normal(size=len(z)) + 1j * random.normal(size=len(z)))
    triangle, weights, index = by_triangles(surface, field, "conformal")
    raw = detect_by_curvature_tensor(surface, field, unfolded_along_seams(surface, NO_SEAMS))
    assert len(triangle) > 50
    np.testing.assert_array_equal(np.sort(raw.triangle), np.sort(triangle))
    order, other = np.argsort(raw.triangle), np.argsort(triangle)
    np.testing.assert_array_equal(raw.index[order], index[other])
    np.testing.assert_allclose(raw.barycentric[order], weights[other], atol=1e-7)


def by_triangles(surface, field, parametrization):
    """The paper's own test of each triangle."""
    return zero_crossings(
        lambda rows: face_deviators(surface, field, rows, parametrization).values,
        len(surface.triangles),
    )


def test_s_and_c_agree_on_a_rolled_sheet() -> None:
    """A developable chart that is not flat in space: a field given on a cylinder."""
    flat, z = flat_surface(cells=61)
    x, y = z.real, z.imag
    vertices = np.stack([np.sin(x), y, np.cos(x)], axis=1)
    surface, _ = clean(vertices, flat.triangles)
    deviator = (z - 0.21 - 0.13j) * np.conj(z + 0.4 - 0.31j)
    angle, gap = 0.5 * np.angle(deviator), np.abs(deviator)
    normal = np.stack([np.sin(x), 0 * x, np.cos(x)], axis=1)
    around = np.stack([np.cos(x), 0 * x, -np.sin(x)], axis=1)
    d1 = np.cos(angle)[:, None] * around + np.sin(angle)[:, None] * np.array([0.0, 1.0, 0.0])
    field = CurvatureField(
        gap / 2, -gap / 2, d1, np.cross(normal, d1), normal, np.full(len(z), np.nan)
    )
    raw = detect_by_curvature_tensor(surface, field, unfolded_along_seams(surface, NO_SEAMS))
    triangle, weights, index = by_triangles(surface, field, "conformal")
    assert np.array_equal(np.sort(raw.triangle), np.sort(triangle))
    assert sorted(raw.index) == sorted(index) == [-0.5, 0.5]
    order, other = np.argsort(raw.triangle), np.argsort(triangle)
    np.testing.assert_allclose(raw.barycentric[order], weights[other], atol=5e-3)


def test_a_zero_on_an_edge_or_a_vertex_is_found_once() -> None:
    for cells in (10, 11):
        surface, z = flat_surface(cells=cells)
        unfolding = unfolded_along_seams(surface, NO_SEAMS)
        for place in (
            0.0,
            z[z.size // 3],
            0.5 * (z[surface.triangles[7, 0]] + z[surface.triangles[7, 1]]),
        ):
            if max(abs(place.real), abs(place.imag)) > 0.95:
                continue
            for turn in (1.0, 1j, np.exp(0.3j)):
                field = field_on_plane((z - place) * turn, mean=1.0)
                raw = detect_by_curvature_tensor(surface, field, unfolding)
                points = points_of(surface, raw.triangle, raw.barycentric)
                assert len(raw) == 1
                assert abs(points[0, 0] + 1j * points[0, 1] - place) < 1e-7


def test_the_index_within_a_chart_is_that_of_its_border() -> None:
    """However wild the field, what the triangles count is what its border sees."""
    surface, z = flat_surface(cells=15)
    random = np.random.default_rng(5)
    deviator = random.normal(size=len(z)) + 1j * random.normal(size=len(z))
    raw = detect_by_curvature_tensor(
        surface, field_on_plane(deviator), unfolded_along_seams(surface, NO_SEAMS)
    )
    loop = np.flatnonzero(surface.border)
    loop = loop[np.argsort(np.angle(z[loop]))]
    jumps = np.angle(np.roll(deviator[loop], -1) * np.conj(deviator[loop]))
    assert raw.index.sum() == pytest.approx(jumps.sum() / (4 * np.pi))


@given(st.lists(st.complex_numbers(max_magnitude=1e3), min_size=3, max_size=3))
def test_weights_are_barycentric(values: list[complex]) -> None:
    rows, weights, index = zeros_in_triangles(np.array([values]))
    assert np.all(weights >= 0)
    np.testing.assert_allclose(weights.sum(axis=1), 1.0)
    assert set(np.abs(index)) <= {0.5}
    assert len(rows) == len(index)


@pytest.mark.slow
@pytest.mark.parametrize("mesh", [seed_patch(21600), renumbered(seed_patch(21600), 1)],
                         ids=["patch", "renumbered"])  # fmt: skip
def test_the_patch_with_exact_operators(mesh) -> None:
    surface = surface_of(mesh)
    unfolding = unfolded_along_seams(surface, NO_SEAMS)
    raw = detect_by_curvature_tensor(surface, mesh.curvature_on(surface), unfolding)
    points = points_of(surface, raw.triangle, raw.barycentric)
    inner = np.all(np.abs(points[:, :2]) < 1.1, axis=1)
    assert np.count_nonzero(inner) == 3
    distance = np.linalg.norm(points[inner][:, None] - mesh.umbilics.position[None], axis=2)
    assert np.all(distance.min(axis=0) < 0.2 * mesh.edge_length)
    assert np.array_equal(raw.index[inner], mesh.umbilics.index[distance.argmin(axis=1)])


def test_a_paraboloid_by_seams_and_by_a_conformal_island() -> None:
    mesh = paraboloid(cells=40)
    surface = surface_of(mesh)
    field = mesh.curvature_on(surface)
    uv = mesh.vertices[mesh.triangles][:, :, :2]
    for unfolding in (
        unfolded_along_seams(surface, NO_SEAMS),
        unfolded_by_uv(surface, mesh.triangles, uv, conformal=True),
        unfolded_by_uv(surface, mesh.triangles, uv),
    ):
        raw = detect_by_curvature_tensor(surface, field, unfolding)
        points = points_of(surface, raw.triangle, raw.barycentric)
        distance = np.linalg.norm(points[:, None] - mesh.umbilics.position[None], axis=2)
        assert len(raw) == 2
        assert np.all(distance.min(axis=0) < 0.3 * mesh.edge_length)
        assert np.all(raw.index == 0.5)


def test_conformal_scale_of_an_isometric_chart_is_one() -> None:
    surface, z = flat_surface(cells=10)
    raw = detect_by_curvature_tensor(
        surface, field_on_plane(z - 0.03), unfolded_along_seams(surface, NO_SEAMS)
    )
    np.testing.assert_allclose(raw.conformal_scale, 1.0, rtol=1e-9)
    assert raw.warnings == []


def test_distorted_triangles_are_reported() -> None:
    mesh = ellipsoid(axes=(9.0, 1.1, 1.0), subdivisions=4)
    top = mesh.vertices[mesh.triangles].mean(axis=1)[:, 0] > -8.0
    surface, _ = clean(mesh.vertices, mesh.triangles[top])
    field = curvature_from_normals(surface, vertex_normals(surface))
    raw = detect_by_curvature_tensor(surface, field, unfolded_along_seams(surface, NO_SEAMS))
    assert "shrunk" in raw.warnings[0]
    assert np.nanmin(raw.conformal_scale) < 0.02


def test_frames_do_not_matter() -> None:
    """Any orthonormal frame of the same operator gives the same points."""
    mesh = noisy(seed_patch(900), 0.05)
    surface = surface_of(mesh)
    field = curvature_from_normals(surface, vertex_normals(surface))
    unfolding = unfolded_along_seams(surface, NO_SEAMS)
    sign = np.random.default_rng(0).choice([-1.0, 1.0], size=(len(field.k1), 1))
    turned = CurvatureField(
        field.k1, field.k2, field.d1 * sign, field.d2 * sign, field.normal, field.noise
    )
    one, two = (detect_by_curvature_tensor(surface, some, unfolding) for some in (field, turned))
    assert np.array_equal(one.triangle, two.triangle)
    np.testing.assert_allclose(one.barycentric, two.barycentric, atol=1e-9)
    assert all(np.allclose(np.linalg.norm(axis, axis=1), 1) for axis in tangents(field.normal))


def test_islands_from_the_front_door() -> None:
    """Two islands, each squeezed: unfolded anew the distortion is gone, as they lie it is not."""
    mesh = seed_patch(5400)
    uv = mesh.vertices[mesh.triangles][:, :, :2] * [1.0, 0.2]
    uv[mesh.vertices[mesh.triangles].mean(axis=1)[:, 0] > 0.5] += 9.0
    found = {}
    for charts in ("islands", "uv"):
        settings = core.Settings(method="C", charts=charts, curvature="given")
        found[charts] = core.detect(
            mesh.vertices, mesh.triangles, settings, given=mesh.curvature, uv=uv
        )
        points = found[charts].umbilics.position
        distance = np.linalg.norm(points[:, None] - mesh.umbilics.position[None], axis=2)
        assert np.all(distance.min(axis=0) < 2.0 * mesh.edge_length)
    sheared = [next((w for w in one.warnings if "sheared" in w), "") for one in found.values()]
    count = [int(text.split(" sheared")[0].split()[-1]) for text in sheared]
    assert count[0] < 0.05 * count[1]


def test_without_a_uv_map_the_remedy_is_named() -> None:
    mesh = paraboloid(cells=10)
    for charts in ("islands", "uv"):
        with pytest.raises(core.ChartError, match="unwrap"):
            core.detect(mesh.vertices, mesh.triangles, core.Settings(method="C", charts=charts))
