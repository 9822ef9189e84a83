import numpy as np
import pytest
from exact_fields import surface_of
from surfaces import ellipsoid, grid_points, random_points, seed_patch, sphere, torus

from core import ChartError, InvalidMeshError
from core.mesh.mending.repair import clean
from core.mesh.unfolding.charts import (
    charts_from_seams,
    charts_from_uv,
    corner_uv,
    require_disks,
    unfold,
)
from core.mesh.unfolding.lscm import conformal_map
from core.umbilics.methods.curvature_tensor import unfolded_along_seams, unfolded_by_uv

NO_SEAMS = np.zeros((0, 2), dtype=np.int64)


def _triangle_angles(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    corner = points[triangles]
    out, back = np.roll(corner, -1, 1) - corner, np.roll(corner, 1, 1) - corner
    if np.iscomplexobj(points):
        return np.angle(back * np.conj(out))
    return np.arctan2(
        np.linalg.norm(np.cross(out, back), axis=2), np.einsum("ijk,ijk->ij", out, back)
    )


def _rolled(points: np.ndarray, kind: str) -> np.ndarray:
    """A flat strip bent without stretching: around a cylinder or onto a cone."""
    x, y = points.T
    if kind == "cylinder":
        return np.stack([np.sin(2 * x) / 2, y, np.cos(2 * x) / 2], axis=1)
    radius, angle = np.hypot(x, y + 3.0), np.arctan2(x, y + 3.0)
    slope = 0.6  # of the cone: distance from the axis over distance from the tip
    around = angle / slope
    return np.stack(
        [
            slope * radius * np.sin(around),
            slope * radius * np.cos(around),
            np.sqrt(1 - slope**2) * radius,
        ],
        axis=1,
    )


@pytest.mark.parametrize("kind", ["cylinder", "cone"])
@pytest.mark.parametrize("layout", ["grid", "irregular"])
def test_a_developable_strip_unrolls_isometrically(kind: str, layout: str) -> None:
    """Up to the chords that its edges are: second order in their length."""
    errors = []
    for cells in (20, 40):
        low, high = (-1.2, -0.5), (1.2, 0.5)
        points, triangles = grid_points(2 * cells, cells, low, high)
        if layout == "irregular":
            inner = np.all(np.abs(points) < (1.19, 0.49), axis=1)
            moves = np.random.default_rng(2).uniform(-0.2, 0.2, size=points.shape)
            points[inner] += moves[inner] * 2.4 / (2 * cells)
        surface, _ = clean(_rolled(points, kind), triangles)
        place = unfold(surface, charts_from_seams(surface, NO_SEAMS))
        charts = charts_from_seams(surface, NO_SEAMS)
        flat = (points[:, 0] + 1j * points[:, 1])[surface.source_vertex[charts.vertex]]
        # The similarity that takes the unfolding to the strip it was made from.
        basis = np.stack([place * surface.unit, np.ones_like(place)], axis=1)
        (factor, shift), *_ = np.linalg.lstsq(basis, flat, rcond=None)
        assert abs(abs(factor) - 1.0) < 0.01
        errors.append(np.abs(basis @ np.array([factor, shift]) - flat).max())
    assert errors[0] < 0.03
    assert errors[1] < (0.35 if layout == "grid" else 0.7) * errors[0]


def test_a_flat_mesh_comes_out_similar_and_pins_are_honoured() -> None:
    points, triangles = random_points(400, (-1, -1), (1, 1), seed=1)
    flat = points[:, 0] + 1j * points[:, 1]
    vertices = np.column_stack([points, 0.3 * points[:, 0] - points[:, 1]])
    pins, pinned = np.array([3, 17]), np.array([2.0 + 1.0j, -1.0j])
    tilted = conformal_map(vertices, triangles, pins, pinned)
    assert np.array_equal(tilted[pins], pinned)
    np.testing.assert_allclose(
        _triangle_angles(tilted, triangles), _triangle_angles(vertices, triangles), atol=1e-6
    )
    lifted = np.column_stack([points, np.zeros(len(points))])
    same = conformal_map(lifted, triangles, pins, flat[pins])
    np.testing.assert_allclose(same, flat, atol=1e-9)


def test_angles_of_a_curved_patch_are_nearly_kept() -> None:
    """A cap of a sphere: the shear falls with the edges, as the map becomes conformal."""
    shear = []
    for subdivisions in (4, 5):
        mesh = sphere(subdivisions=subdivisions)
        rows = np.all(mesh.vertices[mesh.triangles][:, :, 2] > 0.2, axis=1)
        surface, _ = clean(mesh.vertices, mesh.triangles[rows])
        unfolding = unfolded_along_seams(surface, NO_SEAMS)
        shear.append(np.median(np.abs(unfolding.shear) / np.abs(unfolding.similarity)))
        assert not np.any(np.abs(unfolding.shear) > np.abs(unfolding.similarity))
    assert shear[0] < 0.02
    assert shear[1] < 0.7 * shear[0]


def test_total_area_is_kept() -> None:
    surface = surface_of(seed_patch(1500))
    charts = charts_from_seams(surface, NO_SEAMS)
    a, b, c = (unfold(surface, charts)[charts.corners[:, k]] for k in range(3))
    area = 0.5 * (np.conj(b - a) * (c - a)).imag.sum()
    assert area == pytest.approx(surface.face_normal_area[1].sum())


def test_closed_surfaces_and_rings_are_refused_with_the_remedy() -> None:
    band = torus(columns=24, rows=12)
    for mesh, words in ((ellipsoid(subdivisions=2), "closed"), (band, "handle")):
        with pytest.raises(ChartError, match="seams") as caught:
            unfolded_along_seams(surface_of(mesh), NO_SEAMS)
        assert words in str(caught.value)
        assert "method S" in str(caught.value)
    # One cut around the tube leaves a ring: two border loops.
    rows = np.arange(12) * 24
    seams = np.stack([rows, np.roll(rows, -1)], axis=1)
    with pytest.raises(ChartError, match="2 border loops"):
        unfolded_along_seams(surface_of(band), seams)


def test_a_torus_cut_twice_is_a_disk() -> None:
    mesh = torus(columns=24, rows=12)
    rows, columns = np.arange(12) * 24, np.arange(24)
    seams = np.concatenate(
        [
            np.stack([rows, np.roll(rows, -1)], axis=1),
            np.stack([columns, np.roll(columns, -1)], axis=1),
        ]
    )
    surface = surface_of(mesh)
    charts = charts_from_seams(surface, seams)
    require_disks(charts)
    assert charts.count == 1
    # 288 vertices, the two loops doubled and their crossing fourfold.
    assert len(charts.vertex) == 288 + 11 + 23 + 3
    unfolding = unfolded_along_seams(surface, seams)
    assert np.isfinite(unfolding.place).all()


def test_seams_cut_a_sphere_into_charts() -> None:
    mesh = ellipsoid(subdivisions=3)
    start, end = mesh.triangles, np.roll(mesh.triangles, -1, axis=1)
    lower = np.all(mesh.vertices[mesh.triangles][:, :, 2] < -1e-9, axis=1)
    inside = set(zip(start[lower].ravel(), end[lower].ravel(), strict=True))
    rim = np.array([edge for edge in inside if edge[::-1] not in inside])
    surface = surface_of(mesh)
    charts = charts_from_seams(surface, rim)
    assert charts.count == 2
    unfolding = unfolded_along_seams(surface, rim)
    assert np.all(np.abs(unfolding.similarity) > 0)


def test_uv_islands() -> None:
    mesh = seed_patch(300)
    surface = surface_of(mesh)
    uv = mesh.vertices[mesh.triangles][:, :, :2].copy()
    right = mesh.vertices[mesh.triangles].mean(axis=1)[:, 0] > 0
    uv[right] += 5.0
    charts = charts_from_uv(surface, corner_uv(surface, mesh.triangles, uv))
    assert charts.count >= 2
    mirrored = uv * [-1, 1]
    plain, other = (unfolded_by_uv(surface, mesh.triangles, some) for some in (uv, mirrored))
    np.testing.assert_allclose(np.abs(plain.similarity), np.abs(other.similarity))
    again = unfolded_by_uv(surface, mesh.triangles, uv[:, ::1], conformal=False)
    np.testing.assert_allclose(again.place, plain.place)


def test_uv_corners_follow_turned_triangles() -> None:
    mesh = seed_patch(200)
    triangles = mesh.triangles.copy()
    triangles[10] = triangles[10, ::-1]
    surface, _ = clean(mesh.vertices, triangles)
    uv = mesh.vertices[triangles][:, :, :2]
    corner = corner_uv(surface, triangles, uv)
    expected = mesh.vertices[surface.source_vertex[surface.triangles]]
    np.testing.assert_array_equal(corner, expected[..., 0] + 1j * expected[..., 1])


def test_many_charts_at_once() -> None:
    """Every triangle its own chart: batches, not a loop."""
    mesh = ellipsoid(subdivisions=3)
    start, end = mesh.triangles.ravel(), np.roll(mesh.triangles, -1, axis=1).ravel()
    surface = surface_of(mesh)
    unfolding = unfolded_along_seams(surface, np.stack([start, end], axis=1))
    assert unfolding.charts.count == len(mesh.triangles)
    np.testing.assert_allclose(np.abs(unfolding.similarity), 1.0, rtol=1e-6)
    np.testing.assert_allclose(np.abs(unfolding.shear), 0.0, atol=1e-6)


def test_uv_maps_that_cannot_be_read() -> None:
    mesh = seed_patch(50)
    surface = surface_of(mesh)
    uv = mesh.vertices[mesh.triangles][:, :, :2].copy()
    with pytest.raises(InvalidMeshError, match="shape"):
        corner_uv(surface, mesh.triangles, uv[1:])
    uv[3, 1, 0] = np.nan
    with pytest.raises(InvalidMeshError, match="not numbers"):
        corner_uv(surface, mesh.triangles, uv)


def test_triangles_without_area_do_not_spoil_the_map() -> None:
    points, triangles = grid_points(8, 8, (-1, -1), (1, 1))
    vertices = np.column_stack([points, np.zeros(len(points))])
    vertices[30] = vertices[31]  # collapses two triangles
    surface, _ = clean(vertices, triangles)
    unfolding = unfolded_along_seams(surface, NO_SEAMS)
    assert np.isfinite(unfolding.place).all()
    sound = surface.face_normal_area[1] > 1e-6
    np.testing.assert_allclose(np.abs(unfolding.similarity[sound]), 1.0, rtol=1e-5)
