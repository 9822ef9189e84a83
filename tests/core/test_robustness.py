"""Whatever the mesh: a sound detection, or one of the core's own errors with a sentence."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mesh_files import PACKAGED
from surfaces import ellipsoid, icosphere, noisy, seed_patch, torus

import core
from core.mesh.mending.repair import clean
from core.mesh.surface import Surface

# Every mesh here is one that detection must get through; anything but these is a failure.
REFUSED = core.InvalidMeshError
ALWAYS_FINITE = ("position", "normal", "barycentric", "index", "curvature", "uncertainty", "noise")


def check(vertices: np.ndarray, triangles: np.ndarray, choices: core.Settings | None = None):
    """Detect, and hold the result to everything that is true of every mesh."""
    try:
        detection = core.detect(vertices, triangles, choices)
    except REFUSED as error:
        assert str(error).strip().endswith(".")
        return None
    n, m = len(vertices), len(triangles)
    for found in (detection.candidates, detection.umbilics):
        k = len(found)
        for name in ALWAYS_FINITE:
            assert np.isfinite(getattr(found, name)).all(), name
        assert not np.isnan(found.persistence).any()
        assert ((found.triangle >= 0) & (found.triangle < m)).all()
        assert (found.barycentric >= -1e-9).all()
        assert np.allclose(found.barycentric.sum(axis=1), 1.0)
        assert np.isin(found.kind, core.KINDS).all()
        assert np.allclose(np.linalg.norm(found.normal, axis=1), 1.0)
        assert found.separatrix.shape == (k, 3, 3)
        corners = np.asarray(vertices, dtype=float)[triangles[found.triangle]]
        low, high = corners.min(axis=1), corners.max(axis=1)
        # Round-off of coordinates that lie far from the origin.
        slack = 1e-9 * np.abs(vertices[np.isfinite(vertices).all(axis=1)]).max()
        assert (found.position >= low - slack).all() and (found.position <= high + slack).all()
    assert detection.triangle_index.shape == (m,)
    assert (2 * detection.triangle_index == np.rint(2 * detection.triangle_index)).all()
    surface, _ = clean(vertices, triangles)
    used = np.zeros(n, dtype=bool)
    used[surface.source_vertex] = True
    used[surface.joined[:, 0]] = used[surface.joined[:, 1]]
    for name in ("k1", "k2", "d1", "d2", "normal"):
        values = getattr(detection.curvature, name)
        assert len(values) == n
        assert np.isfinite(values[used]).all(), name
        assert np.isnan(values[~used]).all(), name
    for region in detection.regions:
        assert np.isfinite([region.area, region.index, region.curvature]).all()
        assert len(np.unique(region.triangles)) == len(region.triangles) > 0
    for value in (detection.index_sum, detection.persistence_level):
        assert np.isfinite(value)
    assert all(text.strip().endswith(".") for text in detection.warnings)
    check_sums(surface, detection)
    return detection


def check_sums(surface: Surface, detection: core.Detection) -> None:
    """The indices of every closed component sum to its Euler characteristic, exactly."""
    # Parts of a triangle that was split have their sum.
    rows, first = np.unique(surface.source_triangle, return_index=True)
    index = detection.triangle_index[rows]
    component = surface.component[surface.triangles[first, 0]]
    sums = np.bincount(component, weights=index, minlength=len(surface.closed))
    closed = surface.closed
    assert (sums[closed] == surface.euler_characteristic[closed]).all()
    if closed.all():
        assert detection.index_sum == detection.expected_index_sum == sums.sum()


finite = st.floats(-1e3, 1e3)
seeds = st.integers(0, 2**32 - 1)


@pytest.mark.slow
@settings(max_examples=60)
@given(seeds, st.integers(3, 40), st.integers(1, 80))
def test_random_soups(seed, points, count):
    random = np.random.default_rng(seed)
    check(random.normal(size=(points, 3)), random.integers(0, points, (count, 3)))


@pytest.mark.slow
@settings(max_examples=30)
@given(seeds, st.integers(3, 12), st.integers(1, 20), st.integers(1, 4))
def test_soups_on_a_coarse_grid(seed, points, count, cells):
    """Coincident vertices, collinear corners and triangles without area."""
    random = np.random.default_rng(seed)
    vertices = random.integers(0, cells + 1, (points, 3)).astype(float)
    check(vertices, random.integers(0, points, (count, 3)))


def damaged(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """An ellipsoid or torus with a random choice of damage."""
    random = np.random.default_rng(seed)
    base = ellipsoid(subdivisions=2) if seed % 2 else torus(columns=24, rows=12)
    vertices, triangles = base.vertices.copy(), base.triangles.copy()
    damage = random.random(7) < 0.4
    if damage[0]:  # faces gone
        triangles = triangles[random.random(len(triangles)) > random.choice([0.02, 0.5])]
    if damage[1]:  # faces turned
        turned = random.random(len(triangles)) < 0.1
        triangles[turned] = triangles[turned][:, ::-1]
    if damage[2]:  # vertices twice
        extra = random.integers(0, len(triangles), 5)
        corner = random.integers(0, 3, 5)
        old = triangles[extra, corner]
        triangles[extra, corner] = len(vertices) + np.arange(5)
        vertices = np.concatenate([vertices, vertices[old]])
    if damage[3]:  # vertices on top of each other
        pair = random.integers(0, len(vertices), (2, 8))
        vertices[pair[0]] = vertices[pair[1]]
    if damage[4]:  # faces twice, and ones that join what is far apart
        bridges = random.integers(0, len(vertices), (4, 3))
        triangles = np.concatenate([triangles, triangles[:6], bridges])
    if damage[5]:  # not numbers
        vertices[random.integers(0, len(vertices), 3), random.integers(0, 3, 3)] = random.choice(
            [np.nan, np.inf, -np.inf], 3
        )
    if damage[6]:  # noise as large as the edges
        vertices = vertices + random.normal(scale=0.3, size=vertices.shape)
    return vertices, triangles


@pytest.mark.slow
@settings(max_examples=60)
@given(seeds)
def test_damaged_meshes(seed):
    check(*damaged(seed))


@pytest.mark.slow
@settings(max_examples=20)
@given(
    seeds,
    st.sampled_from(["conformal", "projection"]),
    st.sampled_from(["jets", "normals"]),
    st.sampled_from([core.AUTO, 2.0, 5.0]),
    st.sampled_from([core.AUTO, 0.0, 0.5]),
    st.sampled_from([0, 2]),
    st.sampled_from([180.0, 30.0]),
    st.booleans(),
)
def test_damaged_meshes_with_any_settings(
    seed, parametrization, curvature, scale, persistence, passes, crease, regions
):
    choices = core.Settings(
        parametrization=parametrization,
        curvature=curvature,
        scale=scale,
        persistence=persistence,
        normal_smoothing=passes,
        crease_angle=crease,
        regions=regions,
    )
    check(*damaged(seed), choices)


@pytest.mark.parametrize("exponent", [-300, -150, -30, 30, 140, 300])
def test_extreme_scales(exponent):
    base = ellipsoid(subdivisions=3)
    with np.errstate(over="ignore"):
        detection = check(base.vertices * 10.0**exponent, base.triangles)
    assert detection is not None
    assert detection.umbilics.counts()["lemon"] == 4


@pytest.mark.once
def test_extreme_proportions():
    base = ellipsoid(subdivisions=2)
    for axis in range(3):
        for factor in (0.0, 1e-9, 1e9):
            stretch = np.ones(3)
            stretch[axis] = factor
            check(base.vertices * stretch, base.triangles)


@pytest.mark.once
def test_far_from_the_origin():
    base = ellipsoid(subdivisions=3)
    for away in (1e3, 1e9, 1e15, 1e17):
        check(base.vertices + away, base.triangles)


TETRAHEDRON = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
OF_TETRAHEDRON = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])


@pytest.mark.once
def test_tiny_components():
    one = check(TETRAHEDRON, OF_TETRAHEDRON)
    assert one.expected_index_sum == 2.0
    check(TETRAHEDRON, OF_TETRAHEDRON[:1])
    check(TETRAHEDRON, OF_TETRAHEDRON[:2])
    check(TETRAHEDRON, OF_TETRAHEDRON[:3])
    check(0.0 * TETRAHEDRON, OF_TETRAHEDRON)
    base = ellipsoid(subdivisions=3)
    vertices = [base.vertices] + [0.01 * TETRAHEDRON + [5.0, i, 0.0] for i in range(20)]
    triangles = [base.triangles]
    triangles += [OF_TETRAHEDRON + len(base.vertices) + 4 * i for i in range(20)]
    detection = check(np.concatenate(vertices), np.concatenate(triangles))
    assert detection.expected_index_sum == 2.0
    assert any("20 pieces of fewer than" in text for text in detection.warnings)


@pytest.mark.slow
@settings(max_examples=12)
@given(seeds, st.sampled_from([0.01, 0.05, 0.3, 1.0]))
def test_sums_hold_under_any_noise(seed, fraction):
    for base in (ellipsoid(subdivisions=3), torus(columns=30, rows=14)):
        surface = noisy(base, fraction, seed % 1000)
        check(surface.vertices, surface.triangles)


def test_constant_and_random_positions():
    _, triangles = icosphere(2)
    n = triangles.max() + 1
    check(np.zeros((n, 3)), triangles)
    check(np.random.default_rng(0).normal(size=(n, 3)), triangles)
    line = np.zeros((n, 3))
    line[:, 0] = np.arange(n)
    check(line, triangles)


@pytest.mark.once
def test_single_precision_positions():
    base = seed_patch(2000)
    check(base.vertices.astype(np.float32), base.triangles)


MESHES = [
    "InterpolatingOnSTL_vtk.stl", "beetle_bff.obj", "boat_os.obj", "bunny_hr_os.obj",
    "chair_model_tm.obj", "double-torus_gpjs.obj", "dragon_vrip_res4.ply", "face_gpjs.obj",
    "fan3_gc.obj", "fandisk.obj", "goblet_vtk.stl", "hand_closed_os.obj",
    "hourglass_ico_gc.obj", "makehuman_hm08_base.obj", "moebius_gc.obj", "not_convex_tm.obj",
    "openscad-nonmanifold_mf.obj", "plane_holes_os.obj", "platonic_shelf_gc.obj",
    "rangemap_lato000_ml.ply", "rocker-arm.obj", "ship_wigley_of.stl", "skull_os.obj",
    "soup_tm.stl", "spot_os.obj", "spot_quad_control_os.obj", "stanford-bunny.obj",
    "suzanne.obj", "sword_quaddom_os.obj", "teapot_npm.obj", "torso_vtk.obj",
    "triple_vierbein_gc.obj", "wingnut_os.obj", *PACKAGED,
]  # fmt: skip

# What a user must be told about these.
WARNED = {
    "chair_model_tm.obj": ["three or more triangles", "duplicate"],
    "dragon_vrip_res4.ply": ["three or more triangles", "duplicate"],
    "fan3_gc.obj": ["three or more triangles"],
    "hourglass_ico_gc.obj": ["pinched"],
    "moebius_gc.obj": ["one-sided"],
}


@pytest.mark.slow
@pytest.mark.parametrize("name", MESHES)
def test_real_meshes(name, real_mesh):
    detection = check(*real_mesh(name))
    assert detection is not None
    for words in WARNED.get(name, []):
        assert any(words in text for text in detection.warnings), detection.warnings


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    ["spot_os.obj", "rocker-arm.obj", "double-torus_gpjs.obj", "hand_closed_os.obj", "cortex"],
)
def test_sums_of_noisy_real_meshes(name, real_mesh):
    vertices, triangles = real_mesh(name)
    corners = vertices[triangles]
    edge = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).mean()
    random = np.random.default_rng(0)
    for fraction in (0.05, 0.3):
        check(vertices + random.normal(scale=fraction * edge, size=vertices.shape), triangles)
