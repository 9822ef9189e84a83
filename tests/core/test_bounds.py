"""Work and memory are bounded by the size of the mesh, and all of it can be stopped."""

import tracemalloc

import numpy as np
import pytest
import surfaces
from exact_fields import surface_of
from hypothesis import given, settings
from hypothesis import strategies as st

import core
from core.mesh.borders import distance_to_border
from core.mesh.mending.repair import clean
from core.mesh.rings import adjacency, grow, rings_across, selection

TETRAHEDRON = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
OF_TETRAHEDRON = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])


def sheet(stray: float) -> tuple[np.ndarray, np.ndarray]:
    """A wavy square with one corner moved that far away."""
    points, triangles = surfaces.grid_points(21, 21, (-1.0, -1.0), (1.0, 1.0))
    height = 0.3 * np.sin(5 * points[:, 0]) * np.cos(4 * points[:, 1])
    vertices = np.column_stack([points, height])
    vertices[np.argmin(points.sum(axis=1))] += (-stray, 0.0, 0.0)
    return vertices, triangles


def to_segments(points: np.ndarray, tails: np.ndarray, heads: np.ndarray) -> np.ndarray:
    """Exact distances from points to the nearest of some segments."""
    along, from_tail = heads - tails, points[:, None] - tails
    square = np.maximum(np.einsum("ec,ec->e", along, along), 1e-300)
    share = np.clip(np.einsum("pec,ec->pe", from_tail, along) / square, 0.0, 1.0)
    return np.linalg.norm(from_tail - share[..., None] * along, axis=2).min(axis=1)


@given(st.integers(0, 2**32 - 1), st.sampled_from([0.0, 3.0, 1e3, 1e6]), st.floats(0.1, 3.0))
@settings(max_examples=30)
def test_distance_to_a_border_within_half_a_step(seed, stray, steps):
    vertices, triangles = sheet(stray)
    surface, _ = clean(vertices, triangles)
    random = np.random.default_rng(seed)
    points = surface.vertices[random.integers(0, len(vertices), 20)]
    points = points + random.normal(scale=0.01 / surface.unit, size=points.shape)
    step, farthest = 0.1 * steps / surface.unit, 0.4 / surface.unit
    open_edges = np.flatnonzero(surface.twin < 0)
    tails = surface.vertices[surface.triangles.ravel()[open_edges]]
    heads = surface.vertices[np.roll(surface.triangles, -1, axis=1).ravel()[open_edges]]
    exact = to_segments(points, tails, heads)
    found = distance_to_border(surface, points, step, farthest)
    near = np.isfinite(found)
    assert (found[near] <= farthest).all()
    assert near[exact <= farthest - step / 2].all()
    assert not near[exact > farthest * (1 + 1e-9)].any()
    assert (found[near] >= exact[near] * (1 - 1e-6)).all()
    assert (found[near] <= np.hypot(exact[near], step / 2) * (1 + 1e-6) + 1e-12).all()


def peak(away: float) -> int:
    """Bytes that a detection on the sheet takes at most."""
    tracemalloc.start()
    detection = core.detect(*sheet(away))
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert len(detection.curvature.k1) == 484
    return most


@pytest.fixture(scope="module")
def usual_peak():
    core.detect(*sheet(0.0))
    return peak(1.0)


@pytest.mark.slow
@pytest.mark.parametrize("stray", [1e4, 1e8, 1e300])
def test_one_stray_vertex_costs_no_memory(stray, usual_peak):
    assert peak(stray) < 3 * usual_peak


def test_a_border_of_edges_without_a_length_is_followed():
    vertices, triangles = sheet(0.0)
    surface, _ = clean(vertices, triangles)
    on_border = surface.vertices[surface.border][:3]
    assert (distance_to_border(surface, on_border, 0.0, 0.1) < 1e-9).all()


@pytest.mark.slow
@pytest.mark.parametrize("rings", [30.0, 1e6, 1e300])
def test_rings_beyond_the_mesh_are_the_whole_mesh(rings):
    for vertices, triangles in (
        (TETRAHEDRON, OF_TETRAHEDRON),
        (surfaces.ellipsoid(subdivisions=2).vertices, surfaces.icosphere(2)[1]),
    ):
        whole = core.detect(vertices, triangles, core.Settings(scale=24.0)).curvature
        found = core.detect(vertices, triangles, core.Settings(scale=rings)).curvature
        np.testing.assert_allclose(found.k1, whole.k1, rtol=1e-9, atol=1e-9)


def test_so_many_rings_hold_every_component():
    mesh = surfaces.torus(columns=24, rows=12)
    both = np.concatenate([mesh.triangles, OF_TETRAHEDRON + len(mesh.vertices)])
    surface, _ = clean(np.concatenate([mesh.vertices, TETRAHEDRON + 9.0]), both)
    n, rings = len(surface.vertices), rings_across(surface)
    assert rings <= 2 * 18
    for rows, reach in grow(selection(np.arange(n)[:, None], n), adjacency(surface), rings):
        size = np.bincount(surface.component)[surface.component[rows]]
        np.testing.assert_array_equal(np.diff(reach.indptr), size)


@pytest.mark.slow
@pytest.mark.parametrize("crease_angle", [180.0, 20.0])
@pytest.mark.parametrize("scale", [3.0, 7.0, 40.0])
def test_gathered_in_parts_the_samples_are_the_same(scale, crease_angle, monkeypatch):
    mesh = surfaces.ellipsoid(subdivisions=2)
    choices = core.Settings(scale=scale, crease_angle=crease_angle)
    at_once = core.detect(mesh.vertices, mesh.triangles, choices).curvature
    monkeypatch.setattr("core.mesh.rings.MOST_GATHERED", 200)
    in_parts = core.detect(mesh.vertices, mesh.triangles, choices).curvature
    np.testing.assert_allclose(in_parts.k1, at_once.k1, rtol=1e-7, atol=1e-7)
    np.testing.assert_allclose(in_parts.k2, at_once.k2, rtol=1e-7, atol=1e-7)


def test_memory_is_bounded_where_rings_hold_the_whole_mesh(monkeypatch):
    monkeypatch.setattr("core.mesh.rings.MOST_GATHERED", 1 << 16)
    surface = surface_of(surfaces.ellipsoid(subdivisions=3))
    n = len(surface.vertices)
    start, graph = selection(np.arange(n)[:, None], n), adjacency(surface)
    assert max(reach.nnz for _, reach in grow(start, graph, 60)) <= 1 << 16
    rows = np.concatenate([rows for rows, _ in grow(start, graph, 60)])
    np.testing.assert_array_equal(np.sort(rows), np.arange(n))


@pytest.mark.parametrize(
    "choices",
    [
        core.Settings(scale=1e6),
        core.Settings(scale=1e6, crease_angle=20.0),
        core.Settings(scale=1e6, scale_unit="length"),
        core.Settings(normal_smoothing=1000),
    ],
    ids=str,
)
def test_every_long_loop_asks_whether_to_stop(choices):
    mesh = surfaces.ellipsoid(subdivisions=2)
    asked = 0

    def stop() -> bool:
        nonlocal asked
        asked += 1
        return asked > 12

    with pytest.raises(core.CancelledError):
        core.detect(mesh.vertices, mesh.triangles, choices, core.Progress(None, stop))
    assert asked == 13 or choices.normal_smoothing == 0


@pytest.mark.parametrize("scale", [0.0, 1e-300, 1.0, 1e300])
def test_a_scale_in_length_among_edges_without_a_length(scale):
    choices = core.Settings(scale=scale, scale_unit="length")
    doubles = np.arange(4, 4 + 18).reshape(-1, 3)
    vertices = np.concatenate([TETRAHEDRON, np.zeros((18, 3))])
    mostly = np.concatenate([OF_TETRAHEDRON, doubles])
    detection = core.detect(vertices, mostly, choices)
    assert np.isfinite(detection.curvature.k1).all()
    # Two pieces, each in one point: no edge has a length at all.
    points = np.repeat([[0.0, 0, 0], [1.0, 0, 0]], 3, axis=0)
    nowhere = core.detect(points, np.arange(6).reshape(2, 3), choices)
    assert np.isfinite(nowhere.curvature.k1).all()
