"""Jets at all vertices of a large mesh from fits at some."""

import dataclasses

import numpy as np
import pytest
import surfaces
from exact_fields import surface_of
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import sparse

import core
from core.base.progress import Progress
from core.curvature import spread_fits as module
from core.curvature.fits.jets import fit_jets
from core.curvature.scale import choose
from core.curvature.spread_fits import fit_spread
from core.mesh import rings as rings_module
from core.mesh.neighbourhoods import Neighbourhood
from core.mesh.normals import smooth_normals, vertex_normals
from core.mesh.rings import adjacency, independent, spread

AXES = (3.0, 2.0, 1.0)


def around(surface, rings=2, **others):
    return Neighbourhood(surface, adjacency(surface), rings=rings, focused=rings == 2, **others)


def deviators(jets, normals):
    e1, e2 = core.fields.frames.frame(normals.T)
    d = np.einsum("nc,cn->n", jets.d1, e1) + 1j * np.einsum("nc,cn->n", jets.d1, e2)
    return (jets.k1 - jets.k2) * d**2


def errors(exact, jets, surface):
    """Root mean square error of the deviators, in 1 / length."""
    exact_jets = dataclasses.replace(
        jets, k1=exact.k1 * surface.unit, k2=exact.k2 * surface.unit, d1=exact.d1
    )
    difference = deviators(jets, exact.normal) - deviators(exact_jets, exact.normal)
    return float(np.sqrt(np.mean(np.abs(difference) ** 2)))


@st.composite
def graphs(draw):
    n = draw(st.integers(1, 30))
    ends = st.tuples(st.integers(0, n - 1), st.integers(0, n - 1))
    edges = [(a, b) for a, b in draw(st.lists(ends, max_size=60)) if a != b]
    dense = np.zeros((n, n), np.int32)
    for a, b in edges:
        dense[a, b] = dense[b, a] = 1
    return dense


@settings(max_examples=60, deadline=None)
@given(graphs())
def test_independent_nodes_are_apart_and_beside_all_others(dense):
    nodes = independent(sparse.csr_array(dense), Progress())
    assert not dense[np.ix_(nodes, nodes)].any()
    assert (dense[:, nodes].any(axis=1) | np.isin(np.arange(len(dense)), nodes)).all()


@settings(max_examples=60, deadline=None)
@given(graphs(), st.sampled_from([(1, 1), (1, 2), (2, 3)]))
def test_every_node_is_near_one_of_those_spread(dense, how):
    over = spread(sparse.csr_array(dense), *how, Progress())
    nodes, near = over.nodes, over.near
    step = (dense + np.eye(len(dense), dtype=int) > 0).astype(int)
    within = np.linalg.matrix_power(step, how[1])[:, nodes] > 0
    assert np.array_equal(near.toarray() > 0, within)
    assert within.any(axis=1).all()


def test_a_second_round_leaves_fewer_nodes():
    graph = adjacency(surface_of(surfaces.ellipsoid(subdivisions=4)))
    one, two = (len(spread(graph, rounds, 3, Progress()).nodes) for rounds in (1, 2))
    assert 0.2 < one / graph.shape[0] < 0.3 and two < 0.4 * one


def test_clean_meshes_lose_little():
    """Against the truth; the bias in between has the other sign than that in the middle."""
    exact = surfaces.ellipsoid(AXES, 5)
    surface = surface_of(exact)
    normals = vertex_normals(surface)
    everywhere = fit_jets(surface, normals, around(surface), Progress())
    some = fit_spread(surface, normals, around(surface), Progress())
    assert errors(exact, some, surface) < 1.1 * errors(exact, everywhere, surface)
    assert np.abs(np.einsum("nc,nc->n", some.normal, exact.normal)).min() > 1 - 1e-6
    cross = np.cross(some.d1, some.d2)
    assert np.allclose(cross, some.normal, atol=1e-12)
    assert np.allclose(np.linalg.norm(some.d1, axis=1), 1.0, atol=1e-12)


@pytest.mark.parametrize("rings", [4, 7])
def test_noise_is_averaged_out_better_than_by_fits_everywhere(rings):
    exact = surfaces.ellipsoid(AXES, 5)
    surface = surface_of(surfaces.noisy(exact, 0.05))
    normals = smooth_normals(surface, vertex_normals(surface), rings)
    everywhere = fit_jets(surface, normals, around(surface, rings), Progress())
    some = fit_spread(surface, normals, around(surface, rings), Progress())
    assert errors(exact, some, surface) < errors(exact, everywhere, surface)
    assert some.determined.all()
    # What is stated follows what the fits state.
    assert 0.8 < np.median(some.noise) / np.median(everywhere.noise) < 1.25
    assert 0.8 < np.median(some.residual) / np.median(everywhere.residual) < 1.25
    assert 0.8 < np.median(some.radius) / np.median(everywhere.radius) < 1.25


@pytest.mark.parametrize("rings", [2, 4])
def test_the_blocks_change_nothing(rings, monkeypatch):
    surface = surface_of(surfaces.noisy(surfaces.ellipsoid(AXES, 4), 0.01))
    normals = vertex_normals(surface)
    creased = surface.vertices[:, 0] > 0.8  # rows without a fit among others
    parted = around(surface, rings, crease_vertices=creased)
    whole = fit_spread(surface, normals, parted, Progress())
    monkeypatch.setattr(module, "BLOCK", 100)
    monkeypatch.setattr(rings_module, "NEAR_BLOCK", 64)
    blocks = fit_spread(surface, normals, parted, Progress())
    for name, values in vars(whole).items():
        np.testing.assert_allclose(getattr(blocks, name), values, rtol=1e-12, atol=1e-12)


def test_fits_are_moved_to_the_vertex_together():
    """The mean of fits to one side would be wrong where the curvature changes: at a border."""
    exact = surfaces.seed_patch(2500)
    surface = surface_of(exact)
    normals = vertex_normals(surface)
    wide = dataclasses.replace(around(surface, 3), focused=False)
    everywhere = fit_jets(surface, normals, wide, Progress())
    some = fit_spread(surface, normals, wide, Progress())
    assert errors(exact, some, surface) < 1.15 * errors(exact, everywhere, surface)


def test_nothing_is_blended_across_a_crease():
    """Crease vertices are fitted themselves, and so are those in between."""
    surface = surface_of(surfaces.ellipsoid(AXES, 4))
    normals = vertex_normals(surface)
    creased = np.abs(surface.vertices[:, 0]) < 0.05
    creased[:40] = True
    parted = around(surface, crease_vertices=creased)
    everywhere = fit_jets(surface, normals, parted, Progress())
    some = fit_spread(surface, normals, parted, Progress())
    for name in ("k1", "k2", "noise", "radius", "normal"):
        got, expected = getattr(some, name)[creased], getattr(everywhere, name)[creased]
        assert np.allclose(got, expected, rtol=1e-6, atol=1e-9), name


def test_where_no_fit_is_near_the_vertex_is_fitted_itself(monkeypatch):
    surface = surface_of(surfaces.ellipsoid(AXES, 3))
    normals = vertex_normals(surface)
    monkeypatch.setattr(module, "ALIKE", 2.0)  # no fit is taken anywhere
    everywhere = fit_jets(surface, normals, around(surface), Progress())
    some = fit_spread(surface, normals, around(surface), Progress())
    for name, values in vars(everywhere).items():
        assert np.array_equal(getattr(some, name), values), name


def test_fits_that_are_not_determined_are_not_blended():
    """Separate triangles determine nothing, and say so."""
    corners = np.random.default_rng(0).normal(size=(60, 3))
    surface = core.mesh.mending.repair.clean(corners, np.arange(60).reshape(-1, 3))[0]
    jets = fit_spread(surface, vertex_normals(surface), around(surface), Progress())
    assert not jets.determined.any()


@pytest.mark.once
def test_large_meshes_are_fitted_at_some_vertices(monkeypatch):
    """The whole detection: less than a third of the fits, the same umbilics."""
    exact = surfaces.ellipsoid(AXES, 5)
    fitted = []
    whole = module.fit_each

    def counted(surface, normals, neighbourhood, progress, centres, *others):
        fitted.append(len(centres))
        whole(surface, normals, neighbourhood, progress, centres, *others)

    monkeypatch.setattr(module, "fit_each", counted)
    before = core.detect(exact.vertices, exact.triangles)
    assert not fitted
    monkeypatch.setattr(module, "FEWEST", len(exact.vertices))
    after = core.detect(exact.vertices, exact.triangles)
    assert sum(fitted) < len(exact.vertices) / 3
    assert after.umbilics.counts() == before.umbilics.counts()
    assert after.index_sum == before.index_sum == 2.0
    places = np.linalg.norm(
        after.umbilics.position[:, None] - before.umbilics.position, axis=2
    ).min(axis=1)
    assert places.max() < 1e-3


def test_errors_of_the_points_keep_focused_fits_at_all_vertices(monkeypatch):
    """Such little noise that two rings stay, and yet it is most of their error."""
    monkeypatch.setattr(module, "FEWEST", 0)
    exact = surfaces.ellipsoid((1.3, 1.1, 1.0), 4)
    spread_over = []
    for noise in (0.0, 2e-4):
        surface = surface_of(surfaces.noisy(exact, noise) if noise else exact)
        scale = choose(surface, vertex_normals(surface), around(surface), Progress())
        assert scale.neighbourhood.focused
        spread_over.append(module.worth_spreading(scale))
    assert spread_over == [True, False]
