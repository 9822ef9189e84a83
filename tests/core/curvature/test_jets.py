"""Osculating jets and the scale they are fitted at, against exact shape operators."""

import dataclasses

import numpy as np
import pytest
import surfaces
from exact_fields import surface_of

import core
from core.base.progress import Progress
from core.curvature.fits.jets import fit_jets
from core.curvature.scale import choose
from core.mesh.mending.repair import clean
from core.mesh.neighbourhoods import Neighbourhood
from core.mesh.normals import vertex_normals
from core.mesh.rings import adjacency


def neighbourhood_of(surface) -> Neighbourhood:
    return Neighbourhood(surface, adjacency(surface))


def direction_error(mesh: surfaces.AnalyticSurface) -> float:
    """Root mean square angle, in degrees, of d1 against the exact direction."""
    field = core.detect(mesh.vertices, mesh.triangles).curvature
    sine = np.linalg.norm(np.cross(field.d1, mesh.d1), axis=1)
    cosine = np.abs(np.einsum("nc,nc->n", field.d1, mesh.d1))
    return float(np.degrees(np.sqrt((np.arctan2(sine, cosine) ** 2).mean())))


def test_a_cubic_graph_is_exact():
    mesh = surfaces.seed_patch(400, grid=True)
    surface = surface_of(mesh)
    # Upright normals: the height functions are then the polynomial itself, of degree three.
    upright = np.tile([0.0, 0, 1], (len(surface.vertices), 1))
    jets = fit_jets(surface, upright, neighbourhood_of(surface), Progress())
    np.testing.assert_allclose(jets.k1 / surface.unit, mesh.k1, atol=1e-7)
    np.testing.assert_allclose(jets.k2 / surface.unit, mesh.k2, atol=1e-7)
    assert np.abs(np.einsum("nc,nc->n", jets.normal, mesh.normal) - 1).max() < 1e-9


@pytest.mark.once
def test_directions_on_random_points_are_as_good_as_published_jets():
    # 0.048 degrees is what CGAL's jets of degree three reach on as many random hull points.
    assert direction_error(surfaces.random_ellipsoid(count=40962)) <= 0.048


def test_error_falls_with_the_edge():
    coarse = direction_error(surfaces.ellipsoid(subdivisions=4))
    fine = direction_error(surfaces.ellipsoid(subdivisions=5))
    assert fine < coarse / 1.9


@pytest.mark.once
@pytest.mark.parametrize("noise, rings", [(0.0, (2, 2)), (0.01, (3, 5)), (0.1, (6, 8))])
def test_scale_grows_with_the_noise(noise, rings):
    mesh = surfaces.noisy(surfaces.random_ellipsoid(count=6000), noise, seed=1)
    surface = surface_of(mesh)
    scale = choose(surface, vertex_normals(surface), neighbourhood_of(surface), Progress())
    chosen = scale.neighbourhood
    assert rings[0] <= chosen.rings <= rings[1]
    assert chosen.focused == (noise == 0.0)


@pytest.mark.once
def test_noise_is_measured():
    mesh = surfaces.ellipsoid(subdivisions=5)
    edge = np.linalg.norm(
        mesh.vertices[mesh.triangles[:, 0]] - mesh.vertices[mesh.triangles[:, 1]], axis=1
    ).mean()
    rough = surfaces.noisy(mesh, 0.05, seed=2)
    detection = core.detect(rough.vertices, rough.triangles)
    assert detection.noise == pytest.approx(0.05 * edge, rel=0.25)


def test_small_neighbourhoods_grow_until_they_suffice():
    mesh = surfaces.sphere(subdivisions=1)
    surface = surface_of(mesh)
    sizes = []
    for *_, held in neighbourhood_of(surface).blocks(np.arange(len(surface.vertices)), 10_000):
        sizes.extend(held)
    assert min(sizes) >= 15


def test_a_length_bounds_the_samples():
    mesh = surfaces.ellipsoid(subdivisions=4)
    surface = surface_of(mesh)
    length = 0.2
    neighbourhood = dataclasses.replace(neighbourhood_of(surface), reach=length, focused=False)
    for rows, members, held in neighbourhood.blocks(np.arange(len(surface.vertices)), 10_000):
        offset = surface.vertices[members] - surface.vertices[rows]
        distance = np.linalg.norm(offset, axis=2)
        assert ((distance <= length).all(axis=0) | (held == 15)).all()
    assert (np.linalg.norm(offset, axis=2).max(axis=0) > 0.7 * length).all()


def test_samples_among_stretched_triangles_lie_in_a_disc():
    points, triangles = surfaces.grid_points(40, 160, (0.0, 0.0), (1.0, 1.0))
    surface, _ = clean(np.column_stack([points, np.zeros(len(points))]), triangles)
    middle = np.argmin(np.linalg.norm(surface.vertices - surface.vertices.mean(axis=0), axis=1))
    round_ = dataclasses.replace(neighbourhood_of(surface), rings=5, stretch=4.0, focused=False)
    for neighbourhood in (round_, dataclasses.replace(round_, stretch=1.0)):
        ((_, members, _),) = neighbourhood.blocks(np.array([middle]), 10_000)
        offset = surface.vertices[members[:, 0]] - surface.vertices[middle]
        width, length = np.sort(offset.std(axis=0))[1:]
        assert (length < 1.3 * width) == (neighbourhood is round_)
        assert len(members) == 91 or neighbourhood is not round_


def test_creases_are_not_fitted_across():
    # Two halves of a cylinder's wall meet two caps: only creases at 90 degrees between them.
    box = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])
    vertices, triangles = subdivided(box, triangles, 4)
    across = core.detect(vertices, triangles, core.Settings(scale=3.0, crease_angle=180.0))
    within = core.detect(vertices, triangles, core.Settings(scale=3.0, crease_angle=30.0))
    inside = (np.sort(np.abs(vertices), axis=1)[:, 1] < 0.99) & (np.abs(vertices).max(axis=1) == 1)
    assert np.abs(within.curvature.k1[inside]).max() < 1e-9
    assert np.abs(across.curvature.k1[inside]).max() > 0.1


def subdivided(vertices, triangles, times):
    """Flat midpoint subdivision."""
    for _ in range(times):
        edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        unique, inverse = np.unique(edges, axis=0, return_inverse=True)
        middle = inverse.reshape(-1, 3) + len(vertices)
        vertices = np.vstack([vertices, vertices[unique].mean(axis=1)])
        a, b, c = triangles.T
        ab, bc, ca = middle.T
        triangles = np.concatenate(
            [np.stack(t, axis=1) for t in ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))]
        )
    return vertices, triangles
