"""The scale that the errors of a surface ask for."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest
import surfaces
from exact_fields import surface_of
from scipy.spatial import cKDTree

from core.base.progress import Progress
from core.curvature import scale as module
from core.curvature.scale import (
    MOST_CLEAN,
    MOST_FACTOR,
    choose,
    grow_while_it_falls,
    starting_normals,
)
from core.mesh import neighbourhoods
from core.mesh.mending.repair import clean
from core.mesh.neighbourhoods import Neighbourhood
from core.mesh.normals import smooth_normals, vertex_normals
from core.mesh.patches import Patches
from core.mesh.rings import adjacency


def around(surface):
    return Neighbourhood(surface, adjacency(surface))


def chosen_for(surface):
    return choose(surface, vertex_normals(surface), around(surface), Progress())


def stretched(aspect, noise):
    """A rough spheroid whose triangles are up to so many times as long as wide."""
    points, triangles = surfaces.icosphere(4)
    rough = noise * np.random.default_rng(0).standard_normal(points.shape)
    return clean(points * (1.0, 1.0, aspect) + rough, triangles)[0]


def test_a_clean_surface_stays_at_two_focused_rings():
    surface = surface_of(surfaces.ellipsoid(subdivisions=3))
    normals = vertex_normals(surface)
    chosen = choose(surface, normals, around(surface), Progress())
    assert chosen.neighbourhood.rings == 2 and chosen.neighbourhood.focused
    assert chosen.neighbourhood.stretch == 1.0 and chosen.factor == 1.0
    assert not chosen.tilted


def test_a_plane_has_nothing_to_average_out():
    surface = surface_of(surfaces.plane(cells=12))
    assert chosen_for(surface).neighbourhood.rings == 2


def test_round_off_is_not_averaged_out(monkeypatch):
    """Of a plane askew the fits leave nothing but last digits."""
    monkeypatch.setattr(module, "grow_while_it_falls", None)
    chosen = chosen_for(surface_of(surfaces.plane(cells=12, tilt=0.3)))
    assert chosen.neighbourhood.rings == 2 and chosen.neighbourhood.focused
    assert chosen.clean


def test_a_single_triangle_has_no_vertex_to_choose_by():
    surface, _ = clean(np.eye(3), np.array([[0, 1, 2]]))
    chosen = chosen_for(surface)
    assert chosen.neighbourhood.rings == 2 and chosen.factor == 1.0 and not chosen.clean


@pytest.mark.parametrize("aspect, disc", [(1.0, False), (6.0, True)])
def test_noise_on_stretched_triangles_is_averaged_over_discs(aspect, disc):
    neighbourhood = chosen_for(stretched(aspect, 0.02)).neighbourhood
    assert neighbourhood.rings > 2 and not neighbourhood.focused
    assert (neighbourhood.stretch > 2.0) == disc
    assert disc or neighbourhood.stretch == 1.0


def rounded(stretch):
    """An ellipsoid with errors like those of rounding, on triangles that a stretch of the sphere
    makes long, also where the surface is not straight."""
    points, triangles = surfaces.icosphere(5)
    points = points * (1.0, 1.0, stretch)
    points /= np.linalg.norm(points, axis=1)[:, None]
    noise = 5e-6 * np.random.default_rng(0).standard_normal(points.shape)
    return clean(points * (3.0, 2.0, 1.0) + noise, triangles)[0]


@pytest.mark.parametrize("stretch, disc", [(1.0, False), (6.0, True)])
def test_rings_stay_long_where_the_surface_is_straight_along_them(stretch, disc, monkeypatch):
    """Of discs and rings of long triangles those whose scale changes less; under noise discs."""
    monkeypatch.setattr(module, "FALLING", 10.0)
    monkeypatch.setattr(module, "MOST_RINGS", 3)
    assert (chosen_for(rounded(stretch)).neighbourhood.stretch > 1.0) == disc
    monkeypatch.setattr(module, "LEVEL", 0.0)
    assert chosen_for(rounded(stretch)).neighbourhood.stretch > 1.0


def test_neighbourhoods_do_not_reach_over_a_mesh_of_threads(monkeypatch):
    def grown(normals, neighbourhood, *others):
        return module.Scale(dataclasses.replace(neighbourhood, rings=3)), None

    monkeypatch.setattr(module, "_grown", grown)
    assert chosen_for(stretched(60.0, 0.02)).neighbourhood.stretch == 16.0


def series(monkeypatch, changes, noise=0.1, falls=1.0, residual=1.0, undetermined=()):
    """`grow_while_it_falls` with fits whose deviators change so from ring to ring, in length and
    in direction, and whose standard error `falls` by a factor. `noise` is that of all rings or of
    one after the other, and so is the `residual`; `undetermined` pairs of a number of rings and of
    a place whose fit is not determined, and far off."""
    steps = np.asarray(changes) * np.exp(2.0j * np.arange(len(changes)))
    deviators = 3.0 + np.concatenate([[0.0], np.cumsum(steps)])

    def fits(surface, start, neighbourhood, progress, centres, degree):
        count, ring = len(centres), neighbourhood.rings - 2
        deviator = deviators[min(ring, len(changes))]
        half = 0.5 * np.angle(deviator)
        determined = np.ones(count, bool)
        determined[[place for rings, place in undetermined if rings == ring + 2]] = False
        level = np.broadcast_to(noise, 12)[ring] * falls**ring
        return SimpleNamespace(
            k1=np.where(determined, np.abs(deviator) - 1.0, 1e6),
            k2=np.full(count, -1.0),
            d1=np.tile([np.cos(half), np.sin(half), 0.0], (count, 1)),
            determined=determined,
            noise=np.where(determined, level, 1e6),
            radius=np.full(count, float(neighbourhood.rings)),
            residual=np.full(count, np.broadcast_to(residual, 12)[ring]),
        )

    monkeypatch.setattr(module, "fit_jets", fits)
    surface = surface_of(surfaces.plane(cells=4))
    begin = dataclasses.replace(around(surface), rings=2)
    normals = surfaces.sphere(subdivisions=1).normal[: len(surface.vertices)]
    monkeypatch.setattr(module, "frame", lambda _: (np.eye(3)[[0]].T, np.eye(3)[[1]].T))
    grown = grow_while_it_falls(normals, begin, np.arange(5), Progress())
    assert grown.tilted == (np.max(residual) > 1e-4)
    return grown.neighbourhood.rings, grown.factor, grown.clean, grown.shared


@pytest.mark.parametrize(
    "changes, rings",
    [
        ([1.0, 0.9], 2),
        ([1.0, 0.8, 0.7], 3),
        ([1.0, 0.5, 0.25, 0.24], 4),
        # Where the shape is lost the change rises, whatever comes after.
        ([1.0, 0.5, 0.6, 0.1], 3),
        (0.8 ** np.arange(20), 8),
    ],
)
def test_rings_grow_while_the_change_falls(monkeypatch, changes, rings):
    assert series(monkeypatch, np.asarray(changes))[0] == rings


@pytest.mark.parametrize(
    "share, residual, rings", [(0.9, 1e-6, 3), (1.1, 1e-6, 3), (1.3, 1e-6, 2), (0.9, 0.1, 2)]
)
def test_rings_grow_while_rounding_makes_more_than_the_shape(monkeypatch, share, residual, rings):
    """From two to three rings the bias of cubics grows 9 / 4 times as the fake fits have it: the
    square of the change may exceed what the errors make of it by 5 / 13, the change by 1.18."""
    expected = np.sqrt(np.log(2.0) * (0.1**2 - 0.05**2))
    changes = share * expected * np.array([1.0, 0.9, 0.9, 0.9])
    assert series(monkeypatch, changes, 0.1, 0.5, residual)[0] == rings


@pytest.mark.parametrize("share, rough", [(0.05, True), (5e-5, False)])
@pytest.mark.parametrize("large", [False, True])
def test_normals_are_smoothed_where_noise_tilts_them(share, rough, large, monkeypatch):
    """As far as `starting_normals` does for the rings before the two that look ahead; of a large
    mesh those of the vertices that are fitted, and from six rings on by patches."""
    surface = surface_of(surfaces.noisy(surfaces.sphere(subdivisions=4), share))
    normals = vertex_normals(surface)
    graph = adjacency(surface)
    patches = Patches(surface, normals, graph, Progress())
    begin = Neighbourhood(surface, graph, patching=(lambda: patches) if large else None)
    starts, fit = {}, module.fit_jets

    def fits(surface, start, neighbourhood, progress, centres, degree=3):
        starts[neighbourhood.rings] = start[centres]
        return fit(surface, start, neighbourhood, progress, centres, degree)

    monkeypatch.setattr(module, "fit_jets", fits)
    grown = choose(surface, normals, begin, Progress())
    assert grown.tilted == rough
    assert not rough or max(starts) > 5
    interior = np.flatnonzero(~surface.border)
    centres = interior[:: max(len(interior) // module.SAMPLED, 1)]
    for rings, start in starts.items():
        expected = normals
        if rough and rings >= 6 and large:
            expected = patches.normals
        elif rough and rings > 4:
            expected = smooth_normals(surface, normals, rings - 2)
        np.testing.assert_allclose(start, expected[centres], atol=1e-12)


def test_the_error_is_what_the_change_says_within_bounds(monkeypatch):
    """Of nearly equal noise at both scales 0.3 of the variance is taken to be lost to the next."""
    expected = 0.1 * np.sqrt(np.log(2.0) * 0.3)
    for times, factor in ((0.5, 1.0), (2.0, 2.0), (5.0, 5.0), (9.0, MOST_FACTOR)):
        changes = [times * expected, times * expected]
        assert series(monkeypatch, changes, falls=0.99)[1] == pytest.approx(factor)
        # Where the noise does not fall it is none, and the change the shape's.
        assert series(monkeypatch, changes)[1] == pytest.approx(min(factor, MOST_CLEAN))
    assert series(monkeypatch, [1.0, 1.0], noise=0.0)[1] == 1.0


@pytest.mark.parametrize(
    "noise, clean",
    [((1.0, 1.0, 2.0), True), ((1.0, 2.0, 0.5), True), ((2.0, 1.0, 0.5), False)],
)
def test_clean_is_what_errs_no_less_over_a_ring_more(monkeypatch, noise, clean):
    """Errors of the points are averaged out over more of them."""
    assert series(monkeypatch, [1.0, 0.9], noise=[*noise, *[1.0] * 9])[2] == clean


@pytest.mark.parametrize("times", [1.0, 2.9, 3.1])
@pytest.mark.parametrize("grows, shared", [(1.0, False), (1.2, False), (1.3, True), (2.0, True)])
def test_errors_are_shared_where_residuals_grow_with_the_fits(monkeypatch, times, grows, shared):
    """Though the deviator changes more than independent errors make it: where these leave off it is
    shape that changes it. More than three times as much is detail as fine as noise."""
    change = times * 0.1 * np.sqrt(np.log(2.0) * 0.3)
    residual = 0.01 * np.where(np.arange(12) > 0, grows, 1.0)
    found = series(monkeypatch, [change, change], falls=0.99, residual=residual)
    assert found[1] == pytest.approx(times)
    assert found[3] == (shared or times > MOST_CLEAN)


def test_fits_that_are_not_determined_do_not_count(monkeypatch):
    """Neither those of one ring nor those of the next: two of five places have both."""
    usual = series(monkeypatch, [1.0, 0.5, 0.45])
    few = ((3, 0), (3, 1), (4, 2))
    assert series(monkeypatch, [1.0, 0.5, 0.45], undetermined=few) == usual
    # Without any place that has both, nothing is known of the error.
    none = [(ring, place) for ring in range(2, 6) for place in range(5)]
    assert series(monkeypatch, [1.0, 0.5], undetermined=none)[:2] == (2, 1.0)


def test_normals_are_smoothed_as_far_as_the_rings_reach():
    surface = stretched(1.0, 0.02)
    normals = vertex_normals(surface)
    two, five = (dataclasses.replace(around(surface), rings=rings) for rings in (2, 5))
    assert starting_normals(surface, normals, two, Progress()) is normals
    np.testing.assert_array_equal(
        starting_normals(surface, normals, five, Progress()), smooth_normals(surface, normals, 5)
    )


def test_vertices_side_by_side_share_rings_that_hold_no_fewer_of_the_nearest(monkeypatch):
    """Wide rings of stretched triangles hold many times what is asked of them."""
    surface = stretched(6.0, 0.0)
    points = surface.vertices
    everywhere = np.arange(len(points))
    wide = dataclasses.replace(around(surface), rings=5, focused=False, stretch=6.0)
    nearest, _ = cKDTree(points).query(points, k=91)
    grow, grown = neighbourhoods.grow, []

    def counted(reach, *others):
        grown.append(reach.shape[0])
        return grow(reach, *others)

    def missed():
        """How many vertices have a sample that is not among the nearest."""
        beyond = np.ones(len(points), bool)
        for rows, members, _ in wide.blocks(everywhere, 1 << 16):
            away = np.linalg.norm(points[members] - points[rows], axis=2).max(axis=0)
            beyond[rows] = (len(members) != 91) | (away > 1.000001 * nearest[rows, -1])
        return int(beyond.sum())

    monkeypatch.setattr(neighbourhoods, "grow", counted)
    monkeypatch.setattr(neighbourhoods, "MOST_LISTED", 1 << 18)
    shared = missed()
    assert sum(grown) < len(points) / 3
    monkeypatch.setattr(neighbourhoods, "SHARED", 99)
    assert shared < missed() < len(points) / 4
