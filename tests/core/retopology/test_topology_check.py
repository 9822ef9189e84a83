"""A user's quads held against the surface: poles, angle, distance, each with a known answer."""

import dataclasses

import numpy as np
import pytest
import surfaces
from surfaces import blobs

import core
from core.retopology.quads.finishing.projection import ClosestPoints
from core.retopology.topology_check import _farthest, _matched


def grid(rows, columns, place):
    """Quads of a grid that closes around in both directions, at place(u, v)."""
    u, v = np.meshgrid(np.arange(rows) / rows, np.arange(columns) / columns, indexing="ij")
    vertices = place(2 * np.pi * u.ravel(), 2 * np.pi * v.ravel())
    number = np.arange(rows * columns).reshape(rows, columns)
    beside, above = np.roll(number, -1, axis=0), np.roll(number, -1, axis=1)
    quads = np.stack([number, beside, np.roll(beside, -1, axis=1), above], axis=-1).reshape(-1, 4)
    return vertices, quads


def torus(u, v, spiral=0.0):
    v = v + spiral * u
    radius = 1.0 + 0.4 * np.cos(v)
    return np.column_stack([radius * np.cos(u), radius * np.sin(u), 0.4 * np.sin(v)])


@pytest.fixture(scope="module")
def guide():
    vertices, quads = grid(120, 60, torus)
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    return core.Guide(vertices, triangles, core.detect(vertices, triangles))


def check(guide, vertices, quads):
    start = np.arange(0, quads.size + 1, quads.shape[1])
    return core.check_topology(vertices, quads.ravel(), start, guide, guide.guidance().poles)


@pytest.mark.once
def test_lines_of_curvature_of_a_torus_are_perfect(guide):
    found = check(guide, *grid(40, 20, torus))
    assert len(found.irregular) == len(found.missing) == 0
    assert found.quads == len(found.angle) == 800
    assert found.mean_angle < 0.5
    assert found.distance.max() < 0.02 * found.edge


@pytest.mark.once
def test_a_spiral_has_the_angle_that_it_was_given(guide):
    # Where the tube is outermost a turn goes 2 pi 1.4 along and, with one turn of the tube to a
    # turn around, 2 pi 0.4 across.
    vertices, quads = grid(60, 30, lambda u, v: torus(u, v, 1.0))
    found = check(guide, vertices, quads)
    outer = np.linalg.norm(vertices[quads].mean(axis=1)[:, :2], axis=1) > 1.39
    # Half of it: one direction of the quads is turned, the other is not.
    assert np.median(found.angle[outer]) == pytest.approx(
        np.degrees(np.arctan(0.4 / 1.4)) / 2, abs=0.5
    )


@pytest.mark.slow
def test_jacobians_are_sines_and_tell_a_folded_quad(guide):
    vertices, quads = grid(40, 20, torus)
    found = check(guide, vertices, quads)
    # Lines of curvature meet at right angles; the quads between them are trapezoids.
    assert 0.9 < found.least_jacobian <= found.jacobian.max() <= 1.0
    folded = quads.copy()
    folded[7] = folded[7][[0, 2, 1, 3]]
    found = check(guide, vertices, folded)
    assert found.folded[7] and found.least_jacobian == found.jacobian[7] <= 0.0
    assert (np.delete(found.jacobian, 7) > 0.9).all()


@pytest.mark.slow
def test_quads_that_face_against_the_surface_are_folded_however_square(guide):
    vertices, quads = grid(40, 20, torus)
    assert not check(guide, vertices, quads).folded.any()
    # Wound the other way as a whole it is as sound.
    assert not check(guide, vertices, quads[:, ::-1]).folded.any()
    # Pulled over its neighbour, a quad is turned over, and no corner of it shut.
    turned = quads.copy()
    turned[7] = turned[7][::-1]
    found = check(guide, vertices, turned)
    assert found.least_jacobian > 0.9
    assert np.flatnonzero(found.folded).tolist() == [7]


@pytest.mark.once
def test_distance_is_that_of_an_offset(guide):
    vertices, quads = grid(40, 20, torus)
    u = np.repeat(2 * np.pi * np.arange(40) / 40, 20)
    v = np.tile(2 * np.pi * np.arange(20) / 20, 40)
    normal = np.column_stack([np.cos(v) * np.cos(u), np.cos(v) * np.sin(u), np.sin(v)])
    found = check(guide, vertices + 0.03 * normal, quads)
    assert found.distance == pytest.approx(0.03, rel=0.03)


@pytest.mark.slow
def test_what_has_no_quads_is_not_covered_however_near_the_others_are(guide):
    vertices, quads = grid(40, 20, torus)
    assert check(guide, vertices, quads).covered == 1.0
    # A quarter of the turns of the tube, all around; an edge more on both sides counts as covered.
    # In parts of the whole area their rows have, with angle v, the integral of 1 + 0.4 cos v.
    v = np.tile(np.arange(20), 40)
    found = check(guide, vertices, quads[(v < 5) | (v >= 10)])
    assert found.distance.max() < 0.02 * found.edge
    low, high = (2 * np.pi * at for at in (5 / 20, 10 / 20))
    reach = found.edge / 0.4
    low, high = low + reach, high - reach
    gone = (high - low + 0.4 * (np.sin(high) - np.sin(low))) / (2 * np.pi)
    assert found.covered == pytest.approx(1.0 - gone, abs=0.01)


@pytest.mark.slow
def test_what_faces_cut_off_between_vertices_on_the_surface_is_told(guide):
    """Sides of a tube cut off what those of a regular polygon do, and where the torus bends the
    same way around up to as much as is cut off there besides; all vertices are on the surface."""
    vertices, quads = grid(40, 20, torus)
    found = check(guide, vertices, quads)
    tube, around = 0.4 * (1.0 - np.cos(np.pi / 20)), 1.4 * (1.0 - np.cos(np.pi / 40))
    assert found.distance.max() < 0.02 * found.edge
    assert tube < found.farthest < tube + around
    assert found.surface_edges_away == found.farthest / found.edge


@pytest.mark.slow
def test_the_farthest_vertex_of_the_surface_is_found_exactly(guide):
    """A spike of one vertex, that no other is near, and what a search of all vertices says."""
    vertices, _ = grid(120, 60, torus)
    coarse, its = grid(40, 20, torus)
    fans = np.concatenate([its[:, [0, 1, 2]], its[:, [0, 2, 3]]])
    closest = ClosestPoints(coarse, fans, np.full(fans.size, -1))
    for height in (0.0, 0.3):
        points = vertices.copy()
        points[61] *= 1.0 + height
        away = np.linalg.norm(closest(points)[1] - points, axis=1)
        assert _farthest(points, closest, 0.0) == away.max()
        assert _farthest(points, closest, 9.0) == 9.0
        if height:
            assert away.argmax() == 61


@pytest.mark.slow
def test_faces_of_any_size_cover_all_that_they_span(guide):
    vertices, quads = grid(40, 20, torus)
    # The flat polygon of a ring of the tube lies inside it, farther than an edge from the surface.
    ring = np.arange(20)
    corners = np.concatenate([ring, quads.ravel()])
    start = np.concatenate([[0], 20 + np.arange(0, quads.size + 1, 4)])
    poles = guide.guidance().poles
    assert core.check_topology(vertices, corners, start, guide, poles).covered == 1.0
    alone = core.check_topology(vertices, ring, np.array([0, 20]), guide, poles)
    assert 0.0 < alone.covered < 0.2


def test_triangles_have_no_angle_and_all_valences_count(guide):
    vertices, quads = grid(40, 20, torus)
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    found = check(guide, vertices, triangles)
    assert np.isnan(found.least_jacobian)
    assert found.quads == 0 and np.isnan(found.mean_angle) and np.isnan(found.angle).all()
    assert set(found.valence) == {6} and len(found.irregular) == found.extra == 800


@pytest.fixture(scope="module")
def ellipsoid():
    mesh = surfaces.ellipsoid((1.5, 1.0, 0.7), subdivisions=5)
    return core.Guide(mesh.vertices, mesh.triangles, core.detect(mesh.vertices, mesh.triangles))


def cube_on(radii, size):
    """A cube of size x size quads a side, blown up to an ellipsoid: eight poles of valence 3."""
    side = np.linspace(-1.0, 1.0, size + 1)
    places, quads = [], []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            a, b = np.meshgrid(side, side, indexing="ij")
            face = np.stack([a, b, np.full_like(a, sign)], axis=-1)
            places.append(np.roll(face, axis + 1, axis=-1).reshape(-1, 3))
            number = np.arange((size + 1) ** 2).reshape(size + 1, size + 1)
            one = np.stack(
                [number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=-1
            )
            one = one.reshape(-1, 4) + len(places[0]) * (len(places) - 1)
            quads.append(one if sign > 0 else one[:, ::-1])
    places, quads = np.concatenate(places), np.concatenate(quads)
    _, first, row = np.unique(places.round(9), axis=0, return_index=True, return_inverse=True)
    vertices = places[first]
    vertices /= np.linalg.norm(vertices, axis=1, keepdims=True)
    return vertices * radii, row.reshape(-1)[quads]


@pytest.mark.once
def test_a_cube_on_an_ellipsoid_has_eight_poles_in_the_wrong_places(ellipsoid):
    found = check(ellipsoid, *cube_on((1.5, 1.0, 0.7), 12))
    assert found.valence.tolist() == [3] * 8
    assert found.matched + len(found.missing) == 8
    assert found.matched + found.extra == 8


@pytest.mark.slow
def test_a_vertex_stands_for_a_pole_within_three_edges_and_for_one_only(ellipsoid):
    vertices, quads = cube_on((1.5, 1.0, 0.7), 12)
    plan = ellipsoid.guidance().poles
    corners = np.flatnonzero(np.bincount(quads.ravel()) == 3)
    moved = vertices.copy()
    for corner in corners:
        near = np.linalg.norm(plan.position - vertices[corner], axis=1).argmin()
        moved[corner] = plan.position[near]
    found = check(ellipsoid, moved, quads)
    assert found.matched == len(np.unique(found.pole[found.pole >= 0]))
    nearest = np.linalg.norm(plan.position[:, None] - moved[found.irregular][None], axis=2).min(
        axis=1
    )
    assert (nearest[found.missing] > 0).all()


@pytest.mark.parametrize("parts", [1, 2, 4])
@pytest.mark.parametrize("sides", [(1.0, 1.0, 1.0), (3.0, 1.0, 0.5)])
def test_triangles_larger_than_the_quads_say_no_more_than_where_a_pole_may_be(parts, sides):
    # The plan of a box has its poles in the middle of triangles at the corners: with one or few of
    # them to a side these are more than three edges of the quads away.
    shell, faces = cube_on((1.0, 1.0, 1.0), parts)
    vertices = shell / np.abs(shell).max(axis=1, keepdims=True) * sides
    triangles = np.concatenate([faces[:, [0, 1, 2]], faces[:, [0, 2, 3]]])
    guide = core.Guide(vertices, triangles, core.detect(vertices, triangles))
    made = core.remesh(vertices, triangles, core.RemeshSettings(quads=600))
    found = check(guide, made.vertices, made.quads)
    assert (found.matched, found.extra, len(found.missing)) == (8, 0, 0)


def test_as_many_vertices_as_can_be_stand_for_poles_and_by_the_shortest_ways(ellipsoid):
    plan = ellipsoid.guidance().poles
    row = np.arange(2)
    poles = dataclasses.replace(
        plan, position=np.array([(0.0, 0, 0), (2.0, 0, 0)]), valence=plan.valence[row]
    )
    # The first vertex is nearest to the second pole, which alone the second one reaches.
    places = np.array([(1.2, 0.0, 0.0), (3.4, 0.0, 0.0)])
    assert _matched(places, np.full(2, 3), poles, np.full(2, 1.5)).tolist() == [0, 1]
    # Both reach both: no way around.
    assert _matched(places - (1.2, 0, 0), np.full(2, 3), poles, np.full(2, 9.0)).tolist() == [0, 1]
    # A vertex of the other sign, or out of reach, stands for none.
    assert _matched(places, np.array([5, 3]), poles, np.full(2, 1.5)).tolist() == [-1, 1]
    assert _matched(places, np.full(2, 3), poles, np.full(2, 0.1)).tolist() == [-1, -1]


def test_a_mesh_without_faces_is_refused(ellipsoid):
    with pytest.raises(core.InvalidMeshError, match="no faces"):
        check(ellipsoid, np.zeros((3, 3)), np.zeros((0, 4), int))


@pytest.mark.slow
def test_quads_that_were_made_are_checked_like_any_other_mesh(ellipsoid):
    surface = ellipsoid.surface
    made = core.remesh(
        surface.vertices * surface.unit + surface.origin,
        surface.triangles,
        core.RemeshSettings(quads=300),
        detection=ellipsoid.detection,
    )
    found = core.check_quads(made, ellipsoid)
    assert (found.matched, found.extra, len(found.missing)) == (8, 0, 0)
    assert found.quads == len(found.angle) == len(made.quads)
    assert found.least_jacobian > 0.5


def _patch():
    mesh = surfaces.seed_patch(1200)
    return mesh.vertices, mesh.triangles


def _saddle():
    mesh = surfaces.monkey_saddle(cells=33)
    return mesh.vertices, mesh.triangles


def _blob():
    points, triangles = blobs.random_sphere(2000, 0)
    return blobs.blob(points, 1), triangles


def _star():
    points, triangles = blobs.random_sphere(2000, 0)
    return blobs.star(points, 5, 0.3), triangles


@pytest.mark.slow
@pytest.mark.parametrize(
    ("made_of", "settings"),
    [
        (_blob, {"quads": 200}),
        (_blob, {"quads": 400, "smoothness": 1.0}),
        (_patch, {"quads": 300}),
        (_star, {"quads": 400, "symmetry": "z"}),
        (_saddle, {"quads": 300, "symmetry": "y"}),
    ],
)
def test_our_quads_are_held_against_the_poles_that_they_were_laid_out_with(made_of, settings):
    """Smoother than a guide's plan, with creases left out, on few quads, mirrored: there are no
    others in the end, and none of them is lost."""
    vertices, triangles = made_of()
    detection = core.detect(vertices, triangles)
    made = core.remesh(
        vertices, triangles, core.RemeshSettings(**settings), detection=detection
    )
    guide = core.Guide(vertices, triangles, detection)
    found = core.check_quads(made, guide)
    assert len(found.missing) == found.extra == 0
    assert sorted(made.planned.valence) == sorted(found.valence)
    start = np.arange(0, made.quads.size + 1, 4)
    poles = guide.guidance().poles
    other = core.check_topology(made.vertices, made.quads.ravel(), start, guide, poles)
    assert len(other.missing) + other.extra > 0
    known = made.planned
    rows = known.triangle, known.barycentric, known.valence
    again = core.Poles.placed(vertices, triangles, *rows)
    np.testing.assert_allclose(again.position, known.position, atol=1e-9)
    assert again.total == known.total
