"""Umbilics that are not told from each other are one, with the sum of their indices."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull
from surfaces import (
    cosines,
    ellipsoid,
    icosphere,
    noisy,
    quartic,
    random_ellipsoid,
    random_field,
)
from surfaces.sampling import outward

import core

# A turn that leaves no vertex on a plane of symmetry.
TURN, _ = np.linalg.qr(np.array([[2.0, 0.3, 0.5], [-0.2, 3.0, 0.7], [0.4, -0.6, 1.5]]))


def spheroid(length, kind="even", subdivisions=4, seed=0):
    """A sphere stretched along an axis that no vertex lies on: two umbilics of index +1."""
    points, triangles = icosphere(subdivisions)
    if kind == "random":
        points = np.random.default_rng(seed).normal(size=(2500, 3))
        points /= np.linalg.norm(points, axis=1)[:, None]
        triangles = outward(points, ConvexHull(points).simplices.astype(np.int64))
    return points @ TURN * (1.0, 1.0, length), triangles


def around(places, found):
    """(p,) sum of the indices that are nearer to each place than to any other."""
    nearest = np.linalg.norm(found.position[:, None] - places, axis=2).argmin(axis=1)
    return np.bincount(nearest, weights=found.index, minlength=len(places))


def test_the_flat_points_of_the_quartic_are_six_compounds():
    mesh = quartic(5)
    detection = core.detect(mesh.vertices, mesh.triangles)
    found = detection.umbilics
    assert found.counts() == {"star": 8, "lemon": 0, "monstar": 0, "compound": 6, "uncertain": 0}
    whole = found.kind == "compound"
    assert found.index[whole].tolist() == [1.0] * 6
    assert detection.index_sum == 2.0
    truth = quartic(2).umbilics
    flat = truth.position[truth.index == 1.0]
    away = np.linalg.norm(flat[:, None] - found.position[whole], axis=2).min(axis=1)
    # Within what they say of themselves.
    assert (away <= 2.0 * found.uncertainty[whole].max()).all()
    assert np.isnan(found.separatrix[whole]).all()
    # Each lies on the mesh, in the triangle that it names.
    corners = mesh.vertices[mesh.triangles[found.triangle]]
    assert np.allclose(np.einsum("kc,kcx->kx", found.barycentric, corners), found.position)


@pytest.mark.once
@pytest.mark.parametrize("length", [1.6, 0.6])
@pytest.mark.parametrize("kind", ["even", "random"])
def test_under_noise_the_poles_of_a_spheroid_add_up(length, kind):
    vertices, triangles = spheroid(length, kind)
    edge = np.linalg.norm(vertices[triangles[:, 0]] - vertices[triangles[:, 1]], axis=1).mean()
    moved = vertices + 0.03 * edge * np.random.default_rng(3).normal(size=vertices.shape)
    found = core.detect(moved, triangles).umbilics
    assert around(np.array([[0, 0, -length], [0, 0, length]]), found).tolist() == [1.0, 1.0]
    assert np.abs(found.position[:, 2]).min() > 0.95 * length


@pytest.mark.parametrize("length", [1.6, 0.6])
@pytest.mark.parametrize("kind", ["even", "random"])
def test_the_poles_of_a_spheroid_are_compounds(length, kind):
    vertices, triangles = spheroid(length, kind)
    detection = core.detect(vertices, triangles)
    assert detection.umbilics.kind.tolist() == ["compound"] * 2
    assert detection.umbilics.index.tolist() == [1.0] * 2
    assert detection.index_sum == 2.0
    assert np.abs(detection.umbilics.position[:, 2]).min() > 0.97 * length


def test_the_twelve_halves_of_cosines_are_six_compounds():
    surface = cosines()
    points, triangles = icosphere(4)
    vertices = surface.on_rays(points @ TURN)
    detection = core.detect(vertices, triangles)
    assert detection.umbilics.counts()["compound"] == 6
    assert detection.umbilics.counts()["star"] == 8


@pytest.mark.parametrize("axes", [(3.0, 2.0, 1.9), (3.0, 2.0, 1.98)])
def test_umbilics_that_the_mesh_resolves_stay_two(axes):
    mesh = ellipsoid(axes, 5)
    detection = core.detect(mesh.vertices, mesh.triangles)
    assert detection.umbilics.kind.tolist() == ["lemon"] * 4


def test_a_clear_pair_is_not_drawn_into_a_set():
    """A lemon and a star 6 edges apart, between which the gap is small against its change."""
    surface = random_field(2)
    points, triangles = icosphere(4)
    vertices = surface.on_rays(points @ TURN)
    parts = core.detect(vertices, triangles, core.Settings(merge=False))
    merged = core.detect(vertices, triangles)
    assert len(merged.umbilics) == len(parts.umbilics) == 12


def test_umbilics_within_an_edge_are_one():
    mesh = ellipsoid((3.0, 2.0, 1.9999), 4)
    detection = core.detect(mesh.vertices, mesh.triangles)
    assert detection.umbilics.kind.tolist() == ["compound"] * 2
    apart = core.detect(mesh.vertices, mesh.triangles, core.Settings(merge=False))
    assert len(apart.umbilics) == 4 and apart.index_sum == 2.0


@pytest.mark.slow
@given(share=st.floats(0.0, 0.15), seed=st.integers(0, 10**6), long=st.floats(1.01, 3.0))
@settings(max_examples=6, deadline=None)
def test_the_sum_stays_exact(share, seed, long):
    mesh = noisy(random_ellipsoid(400, (long * 1.01, 1.0, 0.99), seed=seed % 50), share, seed)
    for merge in (True, False):
        detection = core.detect(
            mesh.vertices, mesh.triangles, core.Settings(merge=merge, regions=seed % 2 == 0)
        )
        sums = detection.candidates.index.sum() + sum(r.index for r in detection.regions)
        assert sums == detection.index_sum == 2.0
        # A sphere may be one region, and pairs of nothing: then there is no level in between.
        level = detection.candidates.persistence
        between = np.sort(level[np.isfinite(level)])[::2]
        for level in (0.0, *between.tolist(), 1e9):
            again = core.filtered(detection, core.Settings(persistence=level))
            assert again.index_sum == 2.0


def test_what_was_dropped_stays_among_the_candidates():
    mesh = quartic(4)
    detection = core.detect(mesh.vertices, mesh.triangles)
    apart = core.detect(mesh.vertices, mesh.triangles, core.Settings(merge=False))
    assert len(detection.candidates) < len(apart.candidates)
    assert detection.candidates.index.sum() == apart.candidates.index.sum() == 2.0
    dropped = ~detection.candidates.resolved
    partner = detection.candidates.partner[dropped]
    # Pairs go together.
    assert (partner >= 0).all() and dropped[partner].all()


def test_poles_of_a_compound_are_four():
    vertices, triangles = spheroid(1.6)
    detection = core.detect(vertices, triangles)
    guidance = core.Guide(vertices, triangles, detection).guidance()
    assert guidance.poles.total == 8
    assert np.bincount(guidance.poles.umbilic, minlength=2).tolist() == [4, 4]
    assert (guidance.poles.valence == 3).all()


def test_a_compound_can_be_put_away():
    vertices, triangles = spheroid(0.6)
    found = core.detect(vertices, triangles)
    kept = core.filtered(core.unpack(core.pack(found)), core.Settings())
    assert kept.umbilics.kind.tolist() == ["compound"] * 2


@pytest.mark.once
@pytest.mark.parametrize("noise", [0.0, 0.02, 0.1])
def test_method_i_reports_each_cluster_once(noise):
    mesh = noisy(ellipsoid(subdivisions=4), noise) if noise else ellipsoid(subdivisions=4)
    merged = core.detect(mesh.vertices, mesh.triangles, core.Settings(method="I"))
    raw = core.detect(mesh.vertices, mesh.triangles, core.Settings(method="I", merge=False))
    assert merged.index_sum == 2.0 and len(merged.umbilics) < len(raw.umbilics)
    assert raw.index_sum > 2.0
    assert np.allclose(mesh.vertices[merged.umbilics.vertex], merged.umbilics.position)
    assert set(merged.umbilics.vertex) <= set(raw.umbilics.vertex) or noise


@pytest.mark.slow
def test_method_i_sums_to_the_euler_characteristic_where_nothing_is_smooth():
    points, triangles = icosphere(3)
    for seed in range(4):
        wild = points + 0.3 * np.random.default_rng(seed).normal(size=points.shape)
        detection = core.detect(wild, triangles, core.Settings(method="I"))
        assert detection.index_sum == 2.0


def rings_of_thin_triangles(rings, segments, axis):
    """Vertices and triangles of an ellipsoid 3:2:1, its poles on an axis."""
    polar = np.linspace(0.0, np.pi, rings + 1)[1:-1]
    around = np.arange(segments) * 2.0 * np.pi / segments
    points = [(0.0, 0.0, 1.0), (0.0, 0.0, -1.0)]
    points += [
        (np.sin(a) * np.cos(b), np.sin(a) * np.sin(b), np.cos(a)) for a in polar for b in around
    ]
    rows = 2 + np.arange((rings - 1) * segments).reshape(rings - 1, segments)
    after = np.roll(rows, -1, axis=1)
    a, b, c, d = (some.ravel() for some in (rows[:-1], after[:-1], rows[1:], after[1:]))
    triangles = [np.column_stack([np.zeros(segments, int), rows[0], after[0]])]
    triangles += [np.column_stack([a, c, b]), np.column_stack([b, c, d])]
    triangles += [np.column_stack([np.ones(segments, int), after[-1], rows[-1]])]
    vertices = np.roll(np.array(points), axis - 2, axis=1) * (3.0, 2.0, 1.0)
    return vertices, np.concatenate(triangles)


@pytest.mark.parametrize(("rings", "segments", "axis"), [(16, 100, 0), (50, 16, 1)])
def test_the_stated_error_covers_the_other_place_of_one_of_which_two_cancel(rings, segments, axis):
    detection = core.detect(*rings_of_thin_triangles(rings, segments, axis))
    kept = detection.umbilics
    true = np.array([[3.0 * np.sqrt(5.0 / 8.0), 0.0, np.sqrt(3.0 / 8.0)]])
    off = np.linalg.norm(np.abs(kept.position) - true, axis=1)
    assert len(kept) == 4
    assert off.min() > 0.5
    assert (kept.uncertainty > off / 2.0).all()
