"""The analytic surfaces themselves: every other test leans on them."""

import numpy as np
import pytest
import surfaces
from surfaces import (
    AnalyticSurface,
    cylinder,
    ellipsoid,
    icosphere,
    inverted,
    monkey_saddle,
    noisy,
    paraboloid,
    plane,
    quartic,
    random_ellipsoid,
    renumbered,
    saddle,
    seed_patch,
    similar,
    sphere,
    torus,
)

SURFACES = {
    "ellipsoid": lambda: ellipsoid(subdivisions=5),
    "random ellipsoid": lambda: random_ellipsoid(20000),
    "quartic": lambda: quartic(6),
    "sphere": lambda: sphere(1.7, 5),
    "torus": lambda: torus(columns=240, rows=96),
    "cylinder": lambda: cylinder(columns=128, rows=80),
    "paraboloid": lambda: paraboloid(cells=128),
    "monkey saddle": lambda: monkey_saddle(cells=129),
    "saddle": lambda: saddle(cells=80),
    "plane": lambda: plane(tilt=0.5),
    "patch": lambda: seed_patch(40000),
    "patch grid": lambda: seed_patch(40000, grid=True),
    "inverted ellipsoid": lambda: inverted(ellipsoid(subdivisions=5), (0.3, 4.0, 1.0), 3.0),
    "inverted patch": lambda: inverted(seed_patch(40000), (0.0, 0.5, 9.0), 3.0),
    "renumbered torus": lambda: renumbered(torus()),
    "moved": lambda: similar(
        ellipsoid(subdivisions=5), 2.5, np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1.0]]), (1, 2, 3)
    ),
}


@pytest.fixture(params=SURFACES, scope="module")
def surface(request: pytest.FixtureRequest) -> AnalyticSurface:
    return SURFACES[request.param]()


def test_frames_are_orthonormal_and_ordered(surface: AnalyticSurface) -> None:
    np.testing.assert_allclose(np.cross(surface.d1, surface.d2), surface.normal, atol=1e-12)
    assert np.all(surface.k1 >= surface.k2)


def test_windings_agree_with_the_normals(surface: AnalyticSurface) -> None:
    a, b, c = (surface.vertices[surface.triangles[:, k]] for k in range(3))
    cross = np.cross(b - a, c - a)
    area = np.linalg.norm(cross, axis=1)
    sound = area > 1e-3 * np.median(area)  # the border of a random Delaunay mesh has slivers
    facing = np.einsum("ij,ij->i", cross, surface.normal[surface.triangles[:, 0]])
    assert np.mean(facing[sound] > 0.5 * area[sound]) > 0.999


def test_normals_turn_as_the_operator_says(surface: AnalyticSurface) -> None:
    i, j = surface.triangles[:, 0], surface.triangles[:, 1]
    step = surface.vertices[j] - surface.vertices[i]
    turn = surface.normal[j] - surface.normal[i]

    def predicted(rows: np.ndarray) -> np.ndarray:
        first = surface.k1[rows] * np.einsum("ij,ij->i", surface.d1[rows], step)
        second = surface.k2[rows] * np.einsum("ij,ij->i", surface.d2[rows], step)
        return first[:, None] * surface.d1[rows] + second[:, None] * surface.d2[rows]

    error = np.linalg.norm(turn - 0.5 * (predicted(i) + predicted(j)), axis=1)
    scale = np.linalg.norm(step, axis=1) * np.maximum(abs(surface.k1[i]), abs(surface.k2[i]))
    assert np.median(error) < 0.03 * np.median(scale) + 1e-14


def test_the_gap_vanishes_only_at_the_umbilics(surface: AnalyticSurface) -> None:
    gap = surface.k1 - surface.k2
    if surface.everywhere:
        assert np.all(gap < 1e-12)
        return
    near = np.array(
        [
            np.linalg.norm(surface.vertices - point, axis=1).argmin()
            for point in surface.umbilics.position
        ],
        dtype=int,
    )
    assert np.all(gap[near] < 0.2 * np.median(gap))
    if not len(near):
        assert gap.min() > 0.1 * np.median(gap)


def test_icosphere_counts() -> None:
    vertices, triangles = icosphere(3)
    assert (len(vertices), len(triangles)) == (642, 1280)
    np.testing.assert_allclose(np.linalg.norm(vertices, axis=1), 1.0)


def test_noise_has_the_stated_size() -> None:
    true = ellipsoid(subdivisions=5)
    moved = noisy(true, 0.02, seed=1).vertices - true.vertices
    assert np.std(moved / true.local_edge[:, None]) == pytest.approx(0.02, rel=0.02)


@pytest.mark.once
@pytest.mark.parametrize(
    "surface, counts",
    [
        (surfaces.cayley(), {"star": 8, "monstar": 12}),
        (surfaces.cosines(), {"star": 8, "flat": 6}),
    ],
)
def test_implicit_surfaces_have_their_umbilics(surface, counts):
    truth = surface.umbilics()
    kinds, number = np.unique(truth.kind, return_counts=True)
    assert dict(zip(kinds.tolist(), number.tolist(), strict=True)) == counts
    assert truth.index.sum() == surface.euler


@pytest.mark.parametrize(
    "surface",
    [surfaces.random_harmonics(3), surfaces.random_field(3), surfaces.metaballs(3)],
    ids=lambda surface: surface.name,
)
def test_derivatives_of_implicit_surfaces(surface):
    points = np.random.default_rng(0).normal(size=(20, 3))
    jet = surface.jet(points)
    step = 1e-5
    for axis, shift in enumerate(step * np.eye(3)):
        after, before = surface.jet(points + shift), surface.jet(points - shift)
        slope = (after.value - before.value) / (2 * step)
        np.testing.assert_allclose(jet.gradient[:, axis], slope, rtol=1e-6, atol=1e-7)
        bend = (after.gradient - before.gradient) / (2 * step)
        np.testing.assert_allclose(jet.hessian[:, axis], bend, rtol=1e-6, atol=1e-6)
