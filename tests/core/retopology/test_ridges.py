"""Ridges against surfaces whose ridges are known: where they run, their kinds, and none."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from exact_fields import surface_of
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree
from shapes import rounded_box
from surfaces import (
    ImplicitSurface,
    cylinder,
    ellipsoid,
    icosphere,
    marching_tetrahedra,
    noisy,
    paraboloid,
    random_ellipsoid,
    similar,
    sphere,
    torus,
)
from surfaces.analytic import operators

import core
from core.base.progress import Progress
from core.formats.points import read_points_csv
from core.mesh.mending.repair import clean
from core.mesh.neighbourhoods import Neighbourhood
from core.mesh.rings import adjacency
from core.retopology.ridges import reach
from core.retopology.ridges.bend import bend_of, bending_of
from core.retopology.ridges.find import CERTAIN, WEAK, find_ridges
from core.retopology.ridges.measure import _shares, measure_slopes, placed_slopes
from core.retopology.ridges.nested import NestedFits
from core.retopology.ridges.paths import ordered_paths
from core.retopology.ridges.reach import choose_fitting
from core.retopology.ridges.slopes import Fitting, fit_slopes, unknown
from core.retopology.ridges.sought import sought_slopes

AXES = np.array([3.0, 2.0, 1.0])


def guided(mesh):
    detection = core.detect(mesh.vertices, mesh.triangles)
    return core.Guide(mesh.vertices, mesh.triangles, detection)


def ridges(mesh, **options):
    return guided(mesh).ridges(core.GuidanceSettings(**options))


def ellipse_length(a, b):
    t = np.linspace(0, 2 * np.pi, 20001)
    return np.linalg.norm(np.diff(np.stack([a * np.cos(t), b * np.sin(t)]), axis=1), axis=0).sum()


def on_ellipsoid(points):
    """Points (n, 3) near the ellipsoid, moved onto it along its gradient."""
    for _ in range(5):
        gradient = 2 * points / AXES**2
        value = (points**2 / AXES**2).sum(axis=1) - 1
        points = points - (value / (gradient**2).sum(axis=1))[:, None] * gradient
    return points


def exact_slope(points, family, d, step=1e-4):
    """(n,) derivative of a principal curvature of the ellipsoid along its direction."""
    hessian = np.broadcast_to(np.diag(2 / AXES**2), (len(points), 3, 3))
    ahead, behind = (
        operators(2 * moved / AXES**2, hessian)[family]
        for moved in (on_ellipsoid(points + step * d), on_ellipsoid(points - step * d))
    )
    return (ahead - behind) / (2 * step)


def test_slopes_are_the_derivatives_of_the_curvatures():
    mesh = ellipsoid(tuple(AXES), 5)
    surface = surface_of(mesh)
    slopes = measure_slopes(surface, mesh.curvature_on(surface), Progress())
    points = mesh.vertices[surface.source_vertex]
    for family, d in enumerate((mesh.d1, mesh.d2)):
        d = d[surface.source_vertex]
        exact = exact_slope(points, family, d)
        sign = np.sign(np.einsum("nc,nc->n", slopes.d[family], d))
        found = sign * slopes.e[family] / surface.unit**2
        # A polynomial of degree four leaves a few parts in a hundred; near umbilics d is unsure.
        error = np.abs(found - exact) / np.sqrt((exact**2).mean())
        assert np.quantile(error, 0.95) < 0.1


@pytest.mark.slow
@pytest.mark.parametrize(
    ("mesh", "off"),
    [
        (ellipsoid(subdivisions=4), 0.1),
        (random_ellipsoid(4000), 0.1),
        (noisy(ellipsoid(subdivisions=5), 0.02), 0.2),
        (noisy(random_ellipsoid(6000), 0.05), 0.3),
    ],
    ids=["icosphere", "random", "2 %", "random, 5 %"],
)
def test_the_crest_of_an_ellipsoid_is_its_longest_section(mesh, off):
    lines = ridges(mesh)
    assert set(lines.kind) == {"crest"} and set(lines.family) == {0}
    z = np.abs(lines.position[:, 2]) / mesh.edge_length
    assert np.mean(z) < off and z.max() < 1.5
    assert lines.length.sum() == pytest.approx(ellipse_length(3, 2), rel=0.06)
    # The section across the crest at its ends: an ellipse with half axes 1 and 2 or 3.
    assert 55 < np.median(lines.bend) < 80


def steeper_on_one_side(noise, step=0.12, turn=1.75, width=0.5):
    """A bent strip: at arc length s across it the curvature is turn/width exp(-u - exp(-u)) with
    u = s / width, whose maximum at s = 0 has unlike sides. Vertices, triangles, and s of points."""
    s = step * np.arange(-16, 25, 0.01)
    angle = turn * np.exp(-np.exp(-s / width))
    profile = 0.01 * step * np.cumsum(np.stack([np.cos(angle), -np.sin(angle)]), axis=1)
    x, z = profile[:, ::100]
    rows, columns = len(x), 26
    y = step * np.arange(columns)
    vertices = np.column_stack([np.repeat(x, columns), np.tile(y, rows), np.repeat(z, columns)])
    vertices += noise * step * np.random.default_rng(1).normal(size=vertices.shape)
    first = (columns * np.arange(rows - 1)[:, None] + np.arange(columns - 1)).ravel()
    corners = first, first + columns, first + columns + 1, first + 1
    triangles = np.concatenate(
        [np.column_stack(corners[:3]), np.column_stack([corners[0], *corners[2:]])]
    )
    tree = cKDTree(profile.T)
    return vertices, triangles, lambda points: s[tree.query(points[:, [0, 2]])[1]] / step


@pytest.mark.parametrize(("noise", "off"), [(0.0, 0.1), (0.05, 0.5)])
def test_a_crest_with_unlike_sides_is_where_its_curvature_is_largest(noise, off):
    """Fits of degree four alone have it .24 and .80 edges beside."""
    vertices, triangles, edges_beside = steeper_on_one_side(noise)
    lines = core.Guide(vertices, triangles, core.detect(vertices, triangles)).ridges()
    assert set(lines.kind) == {"crest"}
    y = lines.position[:, 1]
    inside = (y > 0.3) & (y < y.max() - 0.3)
    assert inside.sum() > 20
    assert np.abs(edges_beside(lines.position[inside])).mean() < off


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_errors_that_neighbours_share_do_not_move_a_crest(noise):
    """Those of voxels make the two fits differ by more than independent ones would."""
    value = lambda x, y, z: x * x * (1 / 9) + y * y * 0.25 + z * z - 1.0  # noqa: E731
    form = ImplicitSurface("ellipsoid", value, 3.2)
    vertices, triangles = marching_tetrahedra(form, 44)
    edge = np.linalg.norm(vertices[triangles[:, 0]] - vertices[triangles[:, 1]], axis=1).mean()
    vertices = vertices + noise * edge * np.random.default_rng(0).normal(size=vertices.shape)
    guide = core.Guide(vertices, triangles, core.detect(vertices, triangles))
    surface, field = guide.surface, guide.detection.curvature
    axes = np.stack([field.d1.T, field.d2.T, field.normal.T])
    fitting = choose_fitting(surface, axes, Progress())
    first = sought_slopes(surface, axes, fitting, (WEAK, CERTAIN), Progress())
    placed = placed_slopes(surface, axes, fitting, first, True, Progress())
    height = [
        np.abs(find_ridges(surface, some).chains.position[:, 2] + surface.origin[2] / surface.unit)
        for some in (first, placed)
    ]
    assert np.median(height[1]) < min(1.1 * np.median(height[0]), 0.1 * surface.mean_side)


@pytest.mark.parametrize(
    ("changes", "most", "reached"),
    [
        ((8.0, 4.0, 2.0, 1.9, 1.0), 13, 7),
        ((8.0, 7.9, 1.0, 1.0, 1.0), 13, 5),
        ((8.0, 4.0, 2.0, 1.0, 0.5), 6, 6),
    ],
    ids=["errors average out", "shape is lost", "no farther"],
)
def test_fits_reach_as_far_as_errors_average_out(changes, most, reached, monkeypatch):
    """Those that place crests by their own trend, not by that of the fits that found them."""
    mesh = ellipsoid(subdivisions=2)
    surface = clean(mesh.vertices, mesh.triangles)[0]

    class Growing:
        def __init__(self, *_):
            self.place = 0

        def slopes(self):
            some = np.ones((2, 1))
            e = sum(changes[: self.place]) * some
            known, d = np.ones(1, bool), np.ones((2, 1, 3))
            return replace(unknown(1), k=some, e=e, error=100.0 * some, determined=known, d=d)

        def widen(self):
            self.place += 1

    monkeypatch.setattr(reach, "NestedFits", Growing)
    around = Neighbourhood(surface, adjacency(surface), rings=4, focused=False)
    axes = np.zeros((3, 3, len(surface.vertices)))
    found, shared = reach.reaching(surface, axes, Fitting(around, 6, None), most, Progress())
    assert found.neighbourhood.rings == reached
    assert shared >= 1.0


@pytest.mark.parametrize("bias, least, most", [(0.0, 0.0, 0.2), (1.0, 0.2, 0.8), (10.0, 0.97, 1.0)])
def test_what_the_first_fit_lacks_counts_as_far_as_it_is_no_error(bias, least, most):
    """The part of the squares that is not their variance, of each ridge for itself."""
    random = np.random.default_rng(0)
    lacking = bias + random.normal(size=4000)
    ridge = np.repeat([0, 3], 2000)
    lacking[2000:] *= 5.0
    lacking[7] = np.nan
    share = _shares(lacking, np.repeat([1.0, 25.0], 2000), ridge)
    assert share[7] == 0.0
    share = np.delete(share, 7)
    assert len(np.unique(share)) <= 2
    assert least <= share.min() and share.max() <= most


def test_all_ridges_of_an_ellipsoid_are_its_three_sections():
    mesh = ellipsoid(subdivisions=5)
    lines = ridges(mesh, ridge_kinds="all", least_bend=0.0)
    assert set(lines.kind) == {"crest", "minimal", "hyperbolic maximal", "hyperbolic minimal"}
    for kind, axis in (("crest", 2), ("minimal", 0)):
        points = np.concatenate([lines.points(i) for i in np.flatnonzero(lines.kind == kind)])
        assert np.abs(points[:, axis]).max() < 0.5 * mesh.edge_length
    # The maximal ones pass over the poles of the shortest axis, the others of the longest.
    poles = {"hyperbolic maximal": 0, "hyperbolic minimal": 2}
    for kind, axis in poles.items():
        rows = np.flatnonzero(lines.kind == kind)
        points = np.concatenate([lines.points(i) for i in rows])
        assert np.abs(points[:, 1]).max() < 0.5 * mesh.edge_length
        assert np.abs(points[:, axis]).max() < np.abs(mesh.umbilics.position[0, axis]) + 1e-2
    # One of each comes to every lemon.
    for kind in poles:
        rows = lines.kind == kind
        reached = np.concatenate([lines.source[rows], lines.target[rows]])
        assert sorted(reached[reached >= 0]) == [0, 1, 2, 3]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("mesh", "fitted"),
    [
        (noisy(ellipsoid(subdivisions=4), 0.05), 0.95),
        (noisy(ellipsoid((1.3, 1.0, 0.8), 4), 0.05), 0.95),
        (noisy(torus(2.0, 0.8, 150, 60), 0.02), 0.5),
    ],
    ids=["ellipsoid", "rounder", "torus"],
)
def test_crests_of_fits_near_them_are_those_of_all_fits(mesh, fitted):
    guide = guided(mesh)
    surface, field = guide.surface, guide.detection.curvature
    axes = np.stack([field.d1.T, field.d2.T, field.normal.T])
    fitting = choose_fitting(surface, axes, Progress())
    everywhere = fit_slopes(surface, axes, fitting, Progress())
    sought = sought_slopes(surface, axes, fitting, (WEAK, CERTAIN), Progress())
    assert sought.determined.mean() < fitted
    found, expected = (find_ridges(surface, slopes).chains for slopes in (sought, everywhere))
    assert len(found) == len(expected)
    # The same points; a chain that is closed may begin at another of them.
    for one, two in ((found, expected), (expected, found)):
        distance, _ = cKDTree(one.position).query(two.position) if len(two) else (0.0, None)
        assert np.max(distance) < 1e-9


@pytest.mark.parametrize(
    "mesh", [noisy(ellipsoid(subdivisions=3), 0.05), noisy(paraboloid(cells=20), 0.02)]
)
def test_fits_that_grow_ring_by_ring_are_those_made_at_once(mesh):
    guide = guided(mesh)
    surface, field = guide.surface, guide.detection.curvature
    axes = np.stack([field.d1.T, field.d2.T, field.normal.T])
    centres = np.arange(0, len(surface.vertices), 7)
    nested = NestedFits(surface, axes, centres, 4, 3)
    for rings in (3, 4, 6):
        around = Neighbourhood(surface, adjacency(surface), rings=rings, focused=False)
        once = fit_slopes(surface, axes, Fitting(around, 4, None), Progress(), centres)
        grown = nested.slopes()
        both = once.determined & grown.determined
        assert both.mean() > 0.9
        for name in ("k", "e", "bending", "error", "radius"):
            one, two = (getattr(some, name)[..., both] for some in (grown, once))
            np.testing.assert_allclose(one, two, rtol=1e-5, atol=1e-7 * np.abs(two).max())
        for _ in range({3: 1, 4: 2}.get(rings, 0)):
            nested.widen()


@pytest.mark.slow
@pytest.mark.parametrize(
    "mesh",
    [
        torus(),
        torus(2.0, 0.8, 150, 60),
        noisy(torus(2.0, 0.8, 150, 60), 0.05),
        sphere(),
        noisy(sphere(subdivisions=4), 0.05),
        cylinder(),
    ],
    ids=["torus", "wide", "5 %", "sphere", "noisy sphere", "cylinder"],
)
def test_surfaces_without_ridges_have_none(mesh):
    assert len(ridges(mesh)) == 0


def test_a_trough_has_its_crest_in_the_hollow():
    lines = ridges(paraboloid())
    assert set(lines.kind) == {"crest"} and set(lines.family) == {1}
    # z = x^2 / 4 + y^2 / 2 bends most across the x axis.
    assert np.abs(lines.position[:, 1]).max() < 0.1


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_a_rounded_box_has_a_crest_along_each_of_its_edges(noise):
    vertices, triangles = rounded_box(5)
    edge = np.linalg.norm(vertices[triangles[:, 0]] - vertices[triangles[:, 1]], axis=1).mean()
    vertices = vertices + noise * edge * np.random.default_rng(0).normal(size=vertices.shape)
    detection = core.detect(vertices, triangles)
    lines = core.Guide(vertices, triangles, detection).ridges()
    size = np.sort(np.abs(lines.position), axis=1)
    assert np.quantile(size[:, 2] - size[:, 1], 0.95) < 0.35 * edge
    middle = 2 ** (-1 / 6)
    for axis in range(3):
        for one in (-middle, middle):
            for two in (-middle, middle):
                point = np.insert([one, two], axis, 0.0)
                assert np.linalg.norm(lines.position - point, axis=1).min() < edge


@pytest.fixture(scope="module")
def crest():
    """An ellipsoid and its one ridge."""
    mesh = random_ellipsoid(2000)
    return mesh, ridges(mesh)


@pytest.mark.once
@settings(max_examples=5)
@given(scale=st.floats(0.01, 100), seed=st.integers(0, 99))
def test_figures_are_in_the_units_of_the_mesh(crest, scale, seed):
    mesh, one = crest
    turn, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    other = ridges(similar(mesh, scale, turn, (1.0, 2.0, 3.0)))
    assert len(one) == len(other) == 1
    for name, power in (("strength", -1), ("sharpness", -3), ("bend", 0)):
        expected = scale**power * np.median(getattr(one, name))
        assert np.median(getattr(other, name)) == pytest.approx(expected, rel=0.02)
    assert other.length.sum() == pytest.approx(scale * one.length.sum(), rel=0.01)


def test_inside_out_a_ridge_is_a_ravine():
    mesh = ellipsoid(subdivisions=4)
    detection = core.detect(mesh.vertices, mesh.triangles[:, ::-1])
    guide = core.Guide(mesh.vertices, mesh.triangles[:, ::-1], detection)
    lines = guide.ridges()
    inward = detection.curvature.k1.max() <= 0
    assert set(lines.family) == ({1} if inward else {0})
    assert np.abs(lines.position[:, 2]).max() < mesh.edge_length


def test_points_lie_in_the_triangles_that_they_name():
    mesh = noisy(ellipsoid(subdivisions=4), 0.02)
    lines = ridges(mesh, ridge_kinds="all", least_bend=0.0)
    corner = mesh.vertices[mesh.triangles[lines.triangle]]
    there = np.einsum("pk,pkc->pc", lines.barycentric, corner)
    np.testing.assert_allclose(there, lines.position, atol=1e-12)
    assert lines.barycentric.min() >= 0
    at_umbilic = np.zeros(len(lines.position), bool)
    at_umbilic[lines.start[:-1][lines.source >= 0]] = True
    at_umbilic[lines.start[1:][lines.target >= 0] - 1] = True
    for number in range(len(lines)):
        rows = np.arange(lines.start[number], lines.start[number + 1])
        if lines.closed[number]:
            rows = np.append(rows[-1], rows)
        chord = np.diff(lines.position[rows], axis=0)
        assert lines.length[number] == pytest.approx(np.linalg.norm(chord, axis=1).sum())
        on_edges = ~at_umbilic[rows[1:]] & ~at_umbilic[rows[:-1]]
        lift = np.einsum("pc,pc->p", chord, lines.normal[rows[1:]])
        assert np.abs(lift[on_edges]).max(initial=0.0) < 1e-9
    part = lines.select(lines.kind == "crest")
    assert set(part.kind) == {"crest"} and len(part.bend) == part.start[-1] == len(part.position)


def test_least_bend_is_a_slider():
    guide = guided(ellipsoid(subdivisions=4))
    lengths = [
        guide.ridges(core.GuidanceSettings(least_bend=bend)).length.sum()
        for bend in (0.0, 30.0, 68.0, 120.0)
    ]
    assert lengths[0] == lengths[1] >= lengths[2] > lengths[3] == 0.0


def test_bend_is_the_turn_of_the_normal_where_the_curvature_is_positive():
    # k(s) = 2 - 3 s^2 is positive between -sqrt(2/3) and sqrt(2/3).
    s, step = np.linspace(-np.sqrt(2 / 3), np.sqrt(2 / 3), 10001, retstep=True)
    turn = np.degrees((2 - 3 * s**2).sum() * step)
    assert bend_of(np.array([2.0]), np.array([-6.0]))[0] == pytest.approx(turn, rel=1e-6)
    assert bending_of(np.array([-2.0]), turn)[0] == pytest.approx(6.0, rel=1e-6)


def test_meshes_too_small_for_a_fit_have_no_ridges():
    points, triangles = icosphere(0)
    detection = core.detect(points * AXES, triangles)
    assert len(core.Guide(points * AXES, triangles, detection).ridges()) == 0


def test_joining_asks_for_each_family_whether_to_stop():
    guide, asked = guided(ellipsoid(subdivisions=4)), []
    progress = Progress(cancelled=lambda: asked.append(1))
    find_ridges(guide.surface, guide.slopes(Progress()), progress=progress)
    assert len(asked) >= 4


def test_cancelling_stops_the_measuring():
    mesh = ellipsoid(subdivisions=4)
    with pytest.raises(core.CancelledError):
        guided(mesh).ridges(progress=Progress(cancelled=lambda: True))


@settings(max_examples=30)
@given(
    pieces=st.lists(st.tuples(st.integers(1, 9), st.booleans()), max_size=6),
    seed=st.integers(0, 1000),
)
def test_segments_are_put_in_order(pieces, seed):
    random = np.random.default_rng(seed)
    ends, owner, first = [], [], 0
    for number, (count, closed) in enumerate(pieces):
        count += 2 * closed
        nodes = first + np.arange(count + 1)
        if closed:
            nodes[-1] = nodes[0]
        ends += list(pairwise(nodes))
        owner += [number] * count
        first += count + 1
    ends = np.array(ends, int).reshape(-1, 2)
    names = random.permutation(max(first, 1))
    order = random.permutation(len(ends))
    swapped = random.random(len(ends)) < 0.5
    shuffled = np.where(swapped[:, None], ends[order][:, ::-1], ends[order])
    owner = np.array(owner, int)[order]
    shuffled = names[shuffled]
    paths = ordered_paths(shuffled)
    assert len(paths) == len(pieces)
    assert sorted(paths.segment) == list(range(len(ends)))
    for number in range(len(paths)):
        rows = np.arange(paths.start[number], paths.start[number + 1])
        segment = paths.segment[rows]
        assert len(set(owner[segment])) == 1
        run = np.where(paths.forward[rows, None], shuffled[segment], shuffled[segment][:, ::-1])
        assert (run[1:, 0] == run[:-1, 1]).all()
        assert paths.closed[number] == pieces[owner[segment[0]]][1]
        assert paths.closed[number] == (run[0, 0] == run[-1, 1])


def test_figures_go_to_a_table_and_come_back(tmp_path):
    mesh = ellipsoid(subdivisions=4)
    guide = guided(mesh)
    lines = guide.ridges()
    data = core.Exported(mesh.vertices, mesh.triangles, guide, guide.guidance(), ridges=lines)
    paths = core.write_guidance(tmp_path / "thing", ["ridges", "ridge_figures"], data)
    assert {path.name for path in paths} >= {"thing-ridges.obj", "thing-ridges.csv"}
    table = read_points_csv(tmp_path / "thing-ridges.csv")
    assert table["bend"] == lines.bend.tolist()
    assert np.stack([table["x"], table["y"], table["z"]], axis=1) == pytest.approx(lines.position)
    assert set(table["kind"]) == {"crest"} and (tmp_path / "thing-ridges.json").is_file()
    with pytest.raises(core.FormatError, match="no ridges"):
        empty = core.Exported(mesh.vertices, mesh.triangles, guide, guide.guidance())
        core.write_guidance(tmp_path / "other", ["ridge_figures"], empty)
