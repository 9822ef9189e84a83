"""The steps from a surface to quads, each by itself."""

from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from quad_guarantees import closest_in, holds
from quad_surfaces import bumpy, cube, plain, uneven_box, with_needles
from surfaces import cylinder, ellipsoid, plane

import core
from core.mesh.half_edges import following, link
from core.mesh.mending.repair import clean
from core.retopology.quads.conformity import conformity
from core.retopology.quads.field.crosses import crosses
from core.retopology.quads.field.pole_moves import with_better_poles
from core.retopology.quads.field.sectors import sector_angles, sector_turns
from core.retopology.quads.finishing.projection import ClosestPoints
from core.retopology.quads.layout import laying_out
from core.retopology.quads.layout.grids import grids, violations
from core.retopology.quads.layout.integers import whole_lengths
from core.retopology.quads.layout.motorcycle_graph import motorcycle_graph
from core.retopology.quads.layout.words import words_of_count
from core.retopology.quads.mapping.cones import cone_scales
from core.retopology.quads.mapping.seamless_map import SeamlessMap, determinant, pose
from core.retopology.quads.mapping.seams import seams
from core.retopology.quads.mapping.untangling import injective_map
from core.retopology.quads.surface import working_surface
from core.retopology.quads.surface.chains import long_chains
from core.retopology.quads.surface.decimation import coarsened
from core.retopology.quads.surface.needles import without_needles
from core.retopology.quads.surface.sizes import sizes
from core.retopology.quads.surface.subdivision import CREASE_BIT, Triangles, split_edges


@pytest.fixture(scope="module")
def crossed():
    mesh = ellipsoid(subdivisions=4)
    detection = core.detect(mesh.vertices, mesh.triangles)
    guide = core.Guide(mesh.vertices, mesh.triangles, detection)
    direction = guide.guidance(core.GuidanceSettings(smoothness=0.45)).face_direction
    surface = guide.surface
    size = np.full(len(surface.triangles), 0.1)
    none = np.zeros(len(surface.twin), bool)
    return crosses(surface.vertices, surface.triangles, surface.twin, direction, size, none)


def test_quarter_turns_sum_to_the_characteristic(crossed):
    assert (4 - crossed.quarter_turns).sum() == 8
    turned = crossed.turned(np.random.default_rng(0).normal(size=len(crossed.triangles)))
    assert np.array_equal(turned.quarter_turns, crossed.quarter_turns)


def test_cut_surface_is_a_disk(crossed):
    cut = seams(crossed)
    edges = (len(crossed.twin) + cut.cut.sum()) // 2
    assert cut.count - edges + len(crossed.triangles) == 1
    off = ~cut.cut
    assert not cut.matching[off].any()


def test_map_is_seamless_and_injective(crossed):
    problem = pose(crossed)
    x, faults = injective_map(problem, core.Progress())
    assert not faults.any()
    assert determinant(problem.jacobian(x)).min() > 0.0
    assert np.abs(problem.conditions @ x).max() < 1e-7
    assert np.allclose(problem.turns(x), crossed.quarter_turns, atol=1e-6)


def test_layout_covers_the_surface(crossed):
    problem = pose(crossed)
    x, _ = injective_map(problem, core.Progress())
    layout = motorcycle_graph(
        SeamlessMap(crossed, problem.seams, problem.places(x)), core.Progress()
    )
    half = [part for rectangle in layout.rectangles for side in rectangle for part in side]
    assert sorted(half) == list(range(2 * len(layout.length)))
    for sides in layout.rectangles:
        bottom, right, top, left = (layout.length[np.array(side) // 2].sum() for side in sides)
        assert np.isclose(bottom, top, atol=1e-6) and np.isclose(left, right, atol=1e-6)
    whole = whole_lengths(layout, 1.0, set(), 1, core.Progress())
    assert whole.min() >= 1
    for sides in layout.rectangles:
        bottom, right, top, left = (whole[np.array(side) // 2].sum() for side in sides)
        assert bottom == top and left == right
    assert not violations(layout, grids(layout, whole))
    # A set of arcs that must not vanish does not.
    free = whole_lengths(layout, 0.2, set(), 0, core.Progress())
    gone = frozenset(np.flatnonzero(free == 0)[:3].tolist())
    assert gone
    kept = whole_lengths(layout, 0.2, {gone}, 0, core.Progress())
    assert kept[sorted(gone)].sum() >= 1


def flat_torus(seed, count=6):
    """A square whose sides are joined, with places in the plane that no line meets twice."""
    random = np.random.default_rng(seed)
    i, j = (part.ravel() for part in np.meshgrid(np.arange(count), np.arange(count)))
    lower = np.stack([[i, j], [i + 1, j], [i + 1, j + 1]])
    upper = np.stack([[i, j], [i + 1, j + 1], [i, j + 1]])
    corner = np.concatenate([lower, upper], axis=2).transpose(2, 0, 1)
    triangles = corner[..., 0] % count * count + corner[..., 1] % count
    off = 0.2 * random.random((count * count, 2))
    place = corner + off[triangles]
    turn = np.zeros((count * count, 2))
    turn[triangles] = 2.0 * np.pi / count * (corner % count + off[triangles])
    ring = 3.0 + np.cos(turn[:, 1])
    vertices = ring * np.cos(turn[:, 0]), ring * np.sin(turn[:, 0]), np.sin(turn[:, 1])
    return np.column_stack(vertices), triangles, place[..., 0] + 1j * place[..., 1]


@pytest.mark.parametrize("seed", range(8))
def test_tracks_that_come_back_along_their_own_line_meet_themselves(seed):
    vertices, triangles, place = flat_torus(seed)
    middle = vertices[triangles].mean(axis=1)
    along = np.column_stack([-middle[:, 1], middle[:, 0], 0.0 * middle[:, 0]])
    twin = link(triangles, len(vertices)).twin
    none, even = np.zeros(len(twin), bool), np.ones(len(triangles))
    crossed = crosses(vertices, triangles, twin, along, even, none)
    layout = motorcycle_graph(SeamlessMap(crossed, seams(crossed), place), core.Progress())
    # One square, whose sides are two lines around: round-off decides nothing.
    assert len(layout.rectangles) == 1
    assert layout.length.min() > 2.0


def test_what_has_failed_is_not_tried_again_unchanged(monkeypatch):
    mesh = ellipsoid(subdivisions=3)
    maps = []
    pose_ = laying_out.pose
    monkeypatch.setattr(laying_out, "pose", lambda *what: maps.append(what) or pose_(*what))
    monkeypatch.setattr(laying_out, "motorcycle_graph", lambda *_: None)
    core.quad_layout(mesh.vertices, mesh.triangles, core.RemeshSettings(quads=300))
    assert 1 < len(maps) < laying_out.ATTEMPTS - 1


@pytest.mark.parametrize("seed", range(3))
def test_a_map_follows_the_curvature_where_it_is_sure(seed):
    """Before anything is evened out, at the price of sides of unlike lengths."""
    settings = core.RemeshSettings(quads=800, relaxation=0)
    made = core.remesh(*bumpy(seed), settings)
    assert np.nanmean(made.angle) < 7.0


def test_maps_that_fail_at_poles_are_loosened_there(monkeypatch):
    """The plan stays: no field is made anew, and none of its poles goes."""
    mesh = bumpy(2, level=5, waves=14)
    fields = []
    planned = laying_out.planned_field
    monkeypatch.setattr(
        laying_out, "planned_field", lambda *what: fields.append(planned(*what)) or fields[-1]
    )
    made = core.remesh(*mesh, core.RemeshSettings(quads=800, relaxation=0))
    assert len(fields) == 1
    assert len(made.pole_valence) == len(fields[0].poles.triangle)


def test_sizes_go_down_at_poles_of_five_sides_and_up_at_those_of_three():
    vertices, triangles = bumpy(0, level=4)
    guide = core.Guide(vertices, triangles, core.detect(vertices, triangles))
    direction = guide.guidance(core.GuidanceSettings(smoothness=0.45)).face_direction
    surface = guide.surface
    size, none = np.full(len(surface.triangles), 0.1), np.zeros(len(surface.twin), bool)
    plan = crosses(surface.vertices, surface.triangles, surface.twin, direction, size, none)
    scale = cone_scales(plan, 2.0)
    turns = plan.quarter_turns[plan.triangles]
    assert (turns == 3).any() and (turns == 5).any()
    assert scale[(turns == 3).any(axis=1)].min() > 1.1
    assert scale[(turns == 5).any(axis=1)].max() < 0.9
    assert 0.9 < np.median(scale) < 1.1


def test_double_poles_part_and_opposite_ones_cancel(crossed):
    nowhere = np.zeros(len(crossed.vertices), bool)
    plain = with_better_poles(crossed, nowhere)
    assert sorted(plain.quarter_turns[plain.singular]) == [3] * 8
    # A quarter turn on an edge between regular vertices: two opposite poles, far from others.
    poles = plain.vertices[plain.singular]
    gap = np.linalg.norm(plain.vertices[:, None] - poles, axis=2).min(axis=1)
    regular = (gap > 0.3) & (plain.quarter_turns == 4)
    edge = int(np.flatnonzero(regular[plain.tail] & regular[plain.head])[0])

    def with_turns(number):
        matching = plain.matching.copy()
        matching[edge] += number
        matching[plain.twin[edge]] -= number
        return plain.matched(matching)

    pair = with_turns(1)
    assert pair.quarter_turns[[pair.tail[edge], pair.head[edge]]].tolist() == [5, 3]
    again = with_better_poles(pair, nowhere)
    assert np.array_equal(again.quarter_turns, plain.quarter_turns)
    double = with_turns(-2)
    assert double.quarter_turns[[double.tail[edge], double.head[edge]]].tolist() == [2, 6]
    again = with_better_poles(double, nowhere)
    assert set(again.quarter_turns) <= {3, 4, 5}
    assert (4 - again.quarter_turns).sum() == 8


def test_corners_take_back_what_a_pole_beside_them_has():
    # A flat sheet over a bend of its border by 30 degrees: two quads meet there, or three.
    across, up = np.meshgrid(np.linspace(-1.0, 1.0, 21), np.linspace(0.0, 1.0, 11))
    low = -np.tan(np.radians(15.0)) * np.abs(across)
    points = np.stack([across, low + up * (1.0 - low), 0.0 * up], axis=2).reshape(-1, 3)
    first = (21 * np.arange(10)[:, None] + np.arange(20)).ravel()
    square = np.stack([first, first + 1, first + 22, first + 21], axis=1)
    triangles = np.concatenate([square[:, [0, 1, 2]], square[:, [0, 2, 3]]])
    surface, _ = clean(points, triangles)
    count = len(surface.triangles)
    direction = np.tile([1.0, 0.0, 0.0], (count, 1))
    plain = crosses(
        surface.vertices,
        surface.triangles,
        surface.twin,
        direction,
        np.full(count, 0.3),
        surface.twin < 0,
    )
    upwards = [int(np.flatnonzero(surface.source_vertex == 10 + 21 * row)[0]) for row in range(8)]

    def with_corner_and_pole(steps):
        """The bend with a quarter turn more, a vertex so many steps above it with one less."""
        matching = plain.matching.copy()
        for tail, head in pairwise(upwards[: steps + 1]):
            edge = int(np.flatnonzero((plain.tail == tail) & (plain.head == head))[0])
            matching[edge] += 1
            matching[plain.twin[edge]] -= 1
        return plain.matched(matching)

    def turns_at_bend(crossed):
        start, turns = sector_turns(crossed)
        return turns[crossed.tail[start] == upwards[0]].tolist()

    nowhere = np.zeros(len(points), bool)
    near, far = with_corner_and_pole(1), with_corner_and_pole(7)
    assert turns_at_bend(plain) == [2] and turns_at_bend(near) == turns_at_bend(far) == [3]
    assert near.quarter_turns[upwards[1]] == far.quarter_turns[upwards[7]] == 3
    again = with_better_poles(near, nowhere)
    assert turns_at_bend(again) == [2] and not again.singular.any()
    # The field decides between two and three else, but where a layout has failed.
    assert turns_at_bend(with_better_poles(far, nowhere)) == [3]
    assert turns_at_bend(with_better_poles(far, nowhere, plain=~nowhere)) == [2]


@pytest.mark.parametrize("crease", [False, True])
@pytest.mark.parametrize("bend", [0.0, 0.6, np.pi / 2])
def test_jags_of_a_feature_that_bends_are_no_corners(bend, crease):
    # A sheet whose middle line has teeth of 60 degrees and bends as a whole, by what they leave.
    count, apart = 41, 0.1
    teeth = np.where(np.arange(count) % 2, 1.0, -1.0) * np.pi / 3.0
    teeth[: count // 2 - 3] = teeth[count // 2 + 5 :] = 0.0
    heading = np.cumsum(teeth) + bend * (np.arange(count) >= count // 2)
    step = apart * np.stack([np.cos(heading), np.sin(heading)], axis=1)
    line = np.concatenate([[[0.0, 0.0]], np.cumsum(step, axis=0)])
    rows = np.arange(-4 if crease else 0, 5)
    side = np.array([-np.sin(0.5 * bend), np.cos(0.5 * bend)])
    flat = (line + 0.3 * rows[:, None, None] * side).reshape(-1, 2)
    points = np.column_stack([flat, np.zeros(len(flat))])
    wide = count + 1
    first = (wide * np.arange(len(rows) - 1)[:, None] + np.arange(count)).ravel()
    square = np.stack([first, first + 1, first + wide + 1, first + wide], axis=1)
    triangles = np.concatenate([square[:, [0, 1, 2]], square[:, [0, 2, 3]]])
    surface, _ = clean(points, triangles)
    m = len(surface.triangles)
    row = wide * int(np.flatnonzero(rows == 0)[0]) + np.arange(wide)
    on = np.isin(surface.source_vertex, row)
    tail, head = surface.triangles.ravel(), surface.triangles[:, [1, 2, 0]].ravel()
    feature = on[tail] & on[head]
    along, size = np.tile([1.0, 0.0, 0.0], (m, 1)), np.full(m, 0.5)
    twin = surface.twin
    crossed = crosses(surface.vertices, surface.triangles, twin, along, size, feature)
    start, _ = sector_turns(crossed)
    middle = on[crossed.tail[start]] & on[crossed.head[start]]
    angle = np.pi - sector_angles(crossed, start[middle])
    inner = np.isin(surface.source_vertex[crossed.tail[start[middle]]], row[3:-3])
    turning = np.abs(angle[inner])
    corners = np.count_nonzero(turning > np.pi / 4)
    assert corners == ((1 + crease) if bend > 1.0 else 0)


def test_splitting_keeps_a_manifold_and_its_features():
    vertices, triangles = cube(2)
    surface, _ = clean(vertices, triangles)
    feature = np.zeros(len(surface.twin), np.int8)
    feature[::7] = CREASE_BIT
    feature |= feature[surface.twin]
    mesh = Triangles(
        surface.vertices,
        surface.triangles.astype(np.int64),
        np.zeros((len(surface.vertices), 1)),
        np.arange(len(surface.triangles)),
        feature,
    )
    length = mesh.lengths[feature > 0].sum()
    random = np.random.default_rng(0)
    for _ in range(3):
        other, _ = clean(mesh.vertices, mesh.triangles)
        marked = random.random(len(other.twin)) < 0.4
        mesh = split_edges(mesh, marked | marked[other.twin])
    other, warnings = clean(mesh.vertices, mesh.triangles)
    assert other.euler_characteristic.sum() == 2 and other.closed.all() and not warnings
    assert np.isclose(other.face_normal_area[1].sum(), surface.face_normal_area[1].sum())
    assert np.isclose(mesh.lengths[mesh.feature > 0].sum(), length)


def test_coarsening_keeps_topology_borders_and_features():
    mesh = cylinder()
    surface, _ = clean(mesh.vertices, mesh.triangles)
    corners = surface.triangles.ravel()
    low = np.abs(surface.vertices[:, 2] - np.median(surface.vertices[:, 2])) < 1e-9
    feature = low[corners] & low[surface.triangles[:, [1, 2, 0]].ravel()]
    assert feature.any()
    fine = Triangles(
        surface.vertices,
        surface.triangles.astype(np.int64),
        np.zeros((len(surface.vertices), 1)),
        np.arange(len(surface.triangles)),
        np.where(feature, CREASE_BIT, 0).astype(np.int8),
    )
    coarse = coarsened(fine, 1500, core.Progress())
    other, warnings = clean(coarse.vertices, coarse.triangles)
    assert len(coarse.triangles) < 0.5 * len(fine.triangles) and not warnings
    assert np.array_equal(other.euler_characteristic, surface.euler_characteristic)
    assert (other.twin < 0).sum() == (surface.twin < 0).sum()
    assert np.isclose(coarse.lengths[coarse.feature > 0].sum(), fine.lengths[feature].sum())
    assert np.array_equal(coarse.feature, np.where(other.twin >= 0, coarse.feature, 0)[other.twin])


@pytest.mark.parametrize("wanted", [10.0, 1e8, 1e30])
def test_quads_larger_than_the_surface_are_of_one_size(wanted):
    """Even where none is in sight: sizes that change over as far have no factors."""
    mesh = plane(cells=1)
    surface, _ = clean(mesh.vertices, mesh.triangles)
    bend = 1.0 + surface.vertices[:, 0] ** 2
    working = SimpleNamespace(surface=surface, field=SimpleNamespace(k1=bend, k2=bend))
    found = sizes(working, wanted, 1.0)
    np.testing.assert_allclose(found, wanted, rtol=1e-2)


def bent_edges(surface):
    normal, _ = surface.face_normal_area
    half = np.flatnonzero(surface.twin >= 0)
    bent = np.einsum("ec,ec->e", normal[half // 3], normal[surface.twin[half] // 3]) < 0.5
    found = np.zeros(len(surface.twin), bool)
    found[half[bent]] = True
    return found


@pytest.mark.parametrize("where", ["creases", "everywhere", "border"])
def test_needles_go_and_topology_borders_and_features_stay(where):
    mesh = cylinder()
    vertices, triangles = (mesh.vertices, mesh.triangles) if where == "border" else cube(3)
    surface, _ = clean(vertices, triangles)
    feature = bent_edges(surface)
    fine = plain(
        surface.vertices, surface.triangles, np.where(feature, CREASE_BIT, 0).astype(np.int8)
    )
    border = surface.twin < 0
    marked = {"creases": feature, "everywhere": fine.lengths > 0, "border": border}[where]
    spoiled = fine
    for _ in range(2):
        # Twice: chains of short edges, and vertices with several of them.
        marks = np.zeros(3 * len(spoiled.triangles), bool)
        if where == "border":
            marks = clean(spoiled.vertices, spoiled.triangles)[0].twin < 0
        elif where == "creases":
            marks = spoiled.feature > 0
        else:
            marks |= spoiled.lengths > 0
        spoiled = with_needles(spoiled, marks & (spoiled.lengths > 1e-3), 1e-7)
    assert marked.any() and spoiled.lengths.min() < 1e-6
    found = without_needles(spoiled)
    other, warnings = clean(found.vertices, found.triangles)
    assert found.lengths.min() > 1e-3 and not warnings
    assert len(found.triangles) == len(triangles)
    assert np.array_equal(other.euler_characteristic, surface.euler_characteristic)
    assert (other.twin < 0).sum() == (surface.twin < 0).sum()
    length = fine.lengths[feature].sum()
    assert np.isclose(found.lengths[found.feature > 0].sum(), length, atol=1e-4)
    inner = other.twin >= 0
    assert np.array_equal(found.feature[inner], found.feature[other.twin[inner]])
    # What has none of them stays as it is.
    same = without_needles(fine)
    assert np.array_equal(same.vertices, fine.vertices)
    assert np.array_equal(same.triangles, fine.triangles)


def test_what_is_all_needles_stays_a_surface():
    vertices, triangles = cube(1)
    for scale in ((1.0, 1e-8, 1.0), (1.0, 1e-8, 1e-8), (1.0, 0.0, 0.0), (0.0, 0.0, 0.0)):
        found = without_needles(plain(vertices * np.array(scale), triangles))
        links = link(found.triangles.astype(np.int32), len(found.vertices))
        assert links is not None and (links.twin >= 0).all()
        assert len(found.vertices) - len(found.triangles) // 2 == 2


@pytest.mark.slow
def test_quads_of_a_coarsened_surface_lie_on_the_fine_one(monkeypatch):
    monkeypatch.setattr(working_surface, "MOST", 2000)
    vertices, triangles = bumpy(4, level=5)
    made = core.remesh(vertices, triangles, core.RemeshSettings(quads=300))
    holds(vertices, triangles, made)


def test_stubs_and_tangles_are_no_features():
    vertices, triangles = cube(8)
    surface, _ = clean(vertices, triangles)
    normal, _ = surface.face_normal_area
    half = np.flatnonzero(np.arange(len(surface.twin)) < surface.twin)
    bent = half[np.einsum("ec,ec->e", normal[half // 3], normal[surface.twin[half] // 3]) < 0.5]
    inside = half[~np.isin(half, bent)][:1]
    kept = long_chains(surface, np.sort(np.concatenate([bent, inside])), 1.0)
    assert np.array_equal(kept, bent)
    # An edge of the cube that ends in the open stays where it bends enough.
    corners = surface.triangles.ravel()
    at = surface.vertices[corners[bent]] + surface.vertices[corners[following(bent)]]
    gap = bent[np.linalg.norm(at - at[0], axis=1) > 0.01]
    assert len(gap) == len(bent) - 1
    assert np.array_equal(long_chains(surface, gap, 0.3, 80.0), gap)
    assert len(long_chains(surface, gap, 0.3, 100.0)) < len(gap)


@pytest.mark.parametrize("mesh", [bumpy(1, level=3), uneven_box()], ids=["alike", "uneven"])
def test_closest_points_are_the_closest(mesh):
    surface, _ = clean(*mesh)
    random = np.random.default_rng(0)
    points = random.uniform(-1.2, 1.2, size=(50, 3))
    closest = ClosestPoints(surface.vertices, surface.triangles, surface.twin)
    _, found = closest(points)
    corner = surface.vertices[surface.triangles]
    for point, place in zip(points, found, strict=True):
        every = closest_in(corner, point)
        least = np.linalg.norm(every - point, axis=1).min()
        assert np.linalg.norm(place - point) <= least * (1 + 1e-9) + 1e-12
    # Places of the surface are their own, and on the side that they are asked for.
    weight = random.dirichlet(np.ones(3), len(corner))
    places = np.einsum("tk,tkc->tc", weight, corner)
    assert np.abs(closest(places)[1] - places).max() < 1e-9
    triangle, there = closest.below(places, closest.normal)
    assert (np.einsum("tc,tc->t", closest.normal[triangle], closest.normal) > 0.5).all()
    assert np.abs(there - places).max() < 1e-9


def test_conformity_tells_torn_meshes():
    quads = np.array([[0, 1, 2, 3], [3, 2, 4, 5]])
    assert conformity(quads, 6).manifold
    assert not conformity(quads[[0, 0]], 4).manifold
    assert not conformity(np.array([[0, 1, 2, 3], [2, 3, 4, 5]]), 6).manifold
    # Two quads that touch in a corner.
    assert not conformity(np.array([[0, 1, 2, 3], [2, 4, 5, 6]]), 7).manifold


@pytest.mark.slow
def test_no_mesh_is_torn_by_tiny_counts():
    vertices, triangles = bumpy(2, level=3)
    made = core.remesh(vertices, triangles, core.RemeshSettings(quads=20))
    found = conformity(made.quads, len(made.vertices))
    assert found.manifold and found.characteristic == 2
    missed = [said for said in made.warnings if f"{len(made.quads)} quads instead of 20" in said]
    assert len(missed) == (len(made.quads) != 20)


def test_a_number_of_quads_that_is_missed_is_said_with_the_reason():
    assert words_of_count(103, 100, 8, 0) == words_of_count(97, 100, 8, 1) == []
    (fewer,) = words_of_count(96, 100, 8, 0)
    assert fewer.startswith("96 quads instead of 100") and "whole numbers" in fewer
    for poles, cut, why in ((8, 1, "without a layout"), (8, 0, "8 poles"), (0, 0, "closed rings")):
        (more,) = words_of_count(104, 100, poles, cut)
        assert more.startswith("104 quads instead of 100") and why in more
