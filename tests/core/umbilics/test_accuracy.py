"""What is told from the errors of a mesh, and what is not."""

import numpy as np
import pytest
import surfaces

import core
from core.curvature.scale import choose
from core.mesh.mending.repair import clean
from core.mesh.neighbourhoods import Neighbourhood
from core.mesh.normals import vertex_normals
from core.mesh.rings import adjacency
from core.umbilics.kind import kinds
from core.umbilics.pairing.cancelling import cancel
from core.umbilics.pairing.persistence import significant


def matched(found: core.Umbilics, truth: surfaces.UmbilicPoints) -> tuple[np.ndarray, np.ndarray]:
    """(t,) distance from each true umbilic to the nearest of its index, (k,) and back."""
    distance = np.linalg.norm(found.position[:, None] - truth.position, axis=2)
    distance[found.index[:, None] != truth.index] = np.inf
    return distance.min(axis=0), distance.min(axis=1)


@pytest.mark.slow
def test_marching_cubes_have_the_umbilics_of_their_surface():
    # The errors of such meshes are shared by neighbours and look like shape to residuals.
    surface = surfaces.superquadric()
    vertices, triangles = surfaces.marching_tetrahedra(surface, 30)
    detection = core.detect(vertices, triangles)
    missed, wrong = matched(detection.umbilics, surface.umbilics())
    cell = 2 * surface.half / 30
    assert detection.index_sum == 2.0
    assert (missed < 4 * cell).sum() >= 18
    assert (wrong < 5 * cell).all()
    assert (wrong[detection.umbilics.certain] < 2 * cell).all()


@pytest.mark.once
def test_the_scale_sees_errors_that_neighbours_share():
    surface = surfaces.superquadric()
    for vertices, triangles, least in (
        (*surfaces.marching_tetrahedra(surface, 24), 3),
        (surface.on_rays(surfaces.icosphere(4)[0]), surfaces.icosphere(4)[1], 2),
    ):
        mesh, _ = clean(vertices, triangles)
        around = Neighbourhood(mesh, adjacency(mesh))
        chosen = choose(mesh, vertex_normals(mesh), around, core.Progress()).neighbourhood
        assert chosen.rings >= least
        assert chosen.focused == (least == 2)


def test_stated_errors_are_those_of_clean_coarse_meshes():
    points, triangles = surfaces.icosphere(4)
    errors = []
    for seed in (1, 2, 3):
        surface = surfaces.random_field(seed)
        found, truth = core.detect(surface.on_rays(points), triangles).umbilics, surface.umbilics()
        offset = found.position[:, None] - truth.position
        offset -= np.einsum("ktc,kc->kt", offset, found.normal)[..., None] * found.normal[:, None]
        away = np.linalg.norm(offset, axis=2)
        away[found.index[:, None] != truth.index] = np.inf
        errors.append((away / found.uncertainty[:, None]).min(axis=0))
    errors = np.concatenate(errors)
    # 39 and 86 % of two-dimensional Gaussians, here of 24.
    assert 0.25 < (errors <= 1.0).mean() < 0.7 and (errors <= 2.0).mean() > 0.8


@pytest.mark.slow
@pytest.mark.parametrize("surface", [surfaces.cayley(), surfaces.random_field(2)])
def test_coarse_meshes_show_what_they_resolve(surface):
    points, triangles = surfaces.icosphere(4)
    vertices = surface.on_rays(points)
    detection = core.detect(vertices, triangles)
    truth = surface.umbilics()
    missed, wrong = matched(detection.umbilics, truth)
    edge = np.linalg.norm(vertices[triangles[:, 0]] - vertices[triangles[:, 1]], axis=1).mean()
    apart = np.linalg.norm(truth.position[:, None] - truth.position, axis=2)
    np.fill_diagonal(apart, np.inf)
    assert (missed[apart.min(axis=0) > 3 * edge] < edge).all()
    assert (wrong < edge).all()
    named = detection.umbilics.kind[detection.umbilics.certain]
    assert "uncertain" not in named


@pytest.mark.slow
def test_resolved_pairs_stay_together():
    mesh = surfaces.noisy(surfaces.random_ellipsoid(3000), 0.1, seed=4)
    found = core.detect(mesh.vertices, mesh.triangles)
    every = found.candidates
    paired = every.partner >= 0
    np.testing.assert_array_equal(every.resolved[paired], every.resolved[every.partner[paired]])
    assert every.resolved[~paired].all()
    assert found.index_sum == 2.0
    assert set(map(tuple, found.umbilics.position)) == set(
        map(tuple, every.position[every.resolved])
    )


def test_the_firm_one_of_two_stays():
    units = np.array([1, -1, 1])
    centres = np.array([[0.0, 0, 0], [1, 0, 0], [3, 0, 0]])
    # All three meet over one pass after the other: both positives before the negative.
    low, high, saddle = np.array([0, 0]), np.array([2, 1]), np.array([0.1, 0.2])
    first, second, _ = cancel(units, centres, low, high, saddle)
    assert {int(first[0]), int(second[0])} == {0, 1}
    firm = np.array([True, False, False])
    first, second, level = cancel(units, centres, low, high, saddle, firm)
    assert {int(first[0]), int(second[0])} == {1, 2}
    assert level[0] == 0.2


@pytest.mark.parametrize("count", [20, 200])
def test_firm_ones_among_many(count):
    random = np.random.default_rng(count)
    units = np.append(np.ones(count, np.int64), -1)
    centres = random.normal(size=(count + 1, 3))
    firm = random.random(count + 1) < 0.5
    low, high = np.arange(count), np.arange(1, count + 1)
    pairs = cancel(units, centres, low, high, np.linspace(0.1, 1.0, count), firm)
    distance = np.linalg.norm(centres[:-1] - centres[-1], axis=1)
    expected = np.where(firm[:-1], np.inf, distance).argmin()
    assert {int(pairs[0][0]), int(pairs[1][0])} == {int(expected), count}


def test_significance_is_rayleigh():
    random = np.random.default_rng(0)
    deviators = random.normal(size=(4000, 25)) + 1j * random.normal(size=(4000, 25))
    longest = np.abs(deviators / np.sqrt(2)).max(axis=1)
    assert (longest > significant(25, 0.1)).mean() == pytest.approx(0.1, abs=0.02)
    assert significant(25, 0.003) == pytest.approx(3.0, abs=0.01)
    assert significant(1713, 0.003) == pytest.approx(3.64, abs=0.01)


def test_a_lemon_that_may_be_a_monstar_is_uncertain():
    p, half = np.ones(3, complex), np.full(3, 0.5)
    # A monstar where q / p lies outside the deltoid, whose cusps are at 1 and whose sides at 1/3.
    q = np.array([0.1, 0.3, 0.6]) * -1.0
    sure = kinds(p, q, half, np.zeros(3))
    assert sure[0] == "lemon" and sure[2] == "monstar"
    assert kinds(p, q, half, np.full(3, 0.05))[1] == "uncertain"
    assert list(kinds(p, q, half, np.full(3, 0.02))[[0, 2]]) == ["lemon", "monstar"]
    stars = kinds(p, np.full(3, 2.0 + 0j), -half, np.full(3, 0.3))
    assert list(stars) == ["star"] * 3
