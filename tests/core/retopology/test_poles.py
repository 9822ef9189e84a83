"""The pole plan: counts, sums, zones, what each pole says."""

import functools
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import sparse
from scipy.sparse.csgraph import maximum_bipartite_matching
from surfaces import cylinder, ellipsoid, monkey_saddle, quartic, sphere, torus

import core
from core.base.progress import Progress
from core.curvature.tolerances import PAIR_NOISE
from core.fields.face_index import face_field_singularities
from core.mesh.input_map import places_on_surface
from core.mesh.rings import adjacency
from core.retopology.crosses.cross_field import cross_field
from core.retopology.features import find_features
from core.retopology.field.planned import _matched, with_poles, with_poles_of_faces
from core.retopology.guidance import disagreements
from core.retopology.lines.edge_paths import edge_paths
from core.retopology.pole_places import Singularities
from core.retopology.poles import _claimed, _confidence, plan_poles, replanned

MESHES = {
    "ellipsoid": ellipsoid(subdivisions=4),
    "quartic": quartic(4),
    "sphere": sphere(subdivisions=4),
    "torus": torus(columns=60, rows=24),
    "cylinder": cylinder(),
    "monkey saddle": monkey_saddle(),
}


@functools.cache
def guide_of(name, **settings):
    mesh = MESHES[name]
    detection = core.detect(mesh.vertices, mesh.triangles, core.Settings(**settings))
    return core.Guide(mesh.vertices, mesh.triangles, detection)


@functools.cache
def poles_of(name, plan="field"):
    return guide_of(name).guidance(core.GuidanceSettings(plan=plan)).poles


@pytest.mark.parametrize("plan", ["field", "umbilics"])
@pytest.mark.parametrize(
    "name, total", [("ellipsoid", 8), ("quartic", 8), ("sphere", 8), ("torus", 0)]
)
def test_the_sum_is_four_times_the_euler_characteristic(name, total, plan):
    poles = poles_of(name, plan)
    assert (4 - poles.valence).sum() == poles.total == poles.expected == total
    assert set(poles.valence) <= {3, 5}


@pytest.mark.parametrize("plan", ["field", "umbilics"])
def test_every_lemon_becomes_two_three_poles(plan):
    detection, poles = guide_of("ellipsoid").detection, poles_of("ellipsoid", plan)
    assert (poles.valence == 3).all() and len(poles) == 8
    assert np.array_equal(np.bincount(poles.umbilic), [2, 2, 2, 2])
    assert (poles.confidence == 1.0).all()
    for umbilic in range(4):
        pair = poles.position[poles.umbilic == umbilic]
        ray = detection.umbilics.separatrix[umbilic, 0]
        apart = (pair[1] - pair[0]) / np.linalg.norm(pair[1] - pair[0])
        assert abs(apart @ ray) < 0.1


@pytest.mark.parametrize("lengths, edges, claimed", [(7.5, 5.5, True), (8.5, 6.5, False)])
def test_an_umbilic_takes_what_smoothing_has_moved_a_few_lengths_and_edges(lengths, edges, claimed):
    guide = guide_of("ellipsoid")
    surface, umbilics = guide.surface, guide.detection.umbilics
    edge = 1.5 * float(np.sqrt(np.median(surface.face_normal_area[1])))
    smoothing = 0.5 * edge
    middle = surface.vertices[surface.triangles].mean(axis=1) * surface.unit + surface.origin
    away = np.linalg.norm(middle[:, None] - umbilics.position, axis=2).min(axis=1)
    wanted = (lengths * smoothing + edges * edge) * surface.unit
    moved = np.argmin(np.abs(away - wanted))
    assert abs(away[moved] - wanted) < 0.1 * edge * surface.unit
    index = np.zeros(len(surface.triangles))
    index[moved] = 0.25
    cross = SimpleNamespace(triangle_index=index, smoothing=smoothing)
    poles = plan_poles(surface, guide.planes(Progress()), cross, umbilics, [])
    assert (poles.umbilic[0] >= 0) == claimed


def test_poles_of_an_umbilic_that_is_not_certain_are_half_as_sure():
    mesh, detection = MESHES["ellipsoid"], guide_of("ellipsoid").detection
    doubted = replace(detection.umbilics, certain=np.array([True, False, True, False]))
    detection = replace(detection, umbilics=doubted)
    poles = core.Guide(mesh.vertices, mesh.triangles, detection).guidance().poles
    assert np.array_equal(poles.confidence, np.where(doubted.certain, 1.0, 0.5)[poles.umbilic])


def test_every_umbilic_has_its_poles_where_all_are_wanted():
    detection, poles = guide_of("quartic").detection, poles_of("quartic", "umbilics")
    quarters = np.bincount(
        poles.umbilic[poles.umbilic >= 0],
        weights=(4 - poles.valence)[poles.umbilic >= 0],
        minlength=len(detection.umbilics),
    )
    assert np.array_equal(quarters, 4 * detection.umbilics.index)


@pytest.mark.once
def test_sums_hold_where_the_filters_left_them_open():
    guide = guide_of("quartic", opening=2)
    poles = guide.guidance(core.GuidanceSettings(plan="umbilics")).poles
    assert poles.total == poles.expected == 8


def test_poles_of_a_region_are_spread_over_it():
    poles = poles_of("sphere")
    assert (poles.umbilic == -1).all() and (poles.region == 0).all()
    # As on a cube: no two nearer than an edge of it, by a good margin.
    gap = np.linalg.norm(poles.position[:, None] - poles.position[None], axis=2)
    assert gap[np.triu_indices(8, 1)].min() > 0.8


@pytest.mark.once
def test_open_surface_has_no_expected_sum():
    poles = poles_of("cylinder")
    assert np.isnan(poles.expected) and len(poles) == 0
    assert np.isnan(poles_of("monkey saddle").expected)


def test_poles_lie_on_their_triangles():
    mesh, poles = MESHES["ellipsoid"], poles_of("ellipsoid")
    corner = mesh.vertices[mesh.triangles[poles.triangle]]
    assert np.allclose(np.einsum("kc,kcx->kx", poles.barycentric, corner), poles.position)
    assert np.allclose(np.linalg.norm(poles.normal, axis=1), 1.0)


def test_marked_zone_is_avoided():
    mesh = MESHES["ellipsoid"]
    zone = mesh.vertices[:, 0] > 2.0
    poles = guide_of("ellipsoid").guidance(zone=zone).poles
    assert not zone[mesh.triangles[poles.triangle]].any()
    assert poles.moved.sum() == 4 and poles.total == 8
    assert len(np.unique(poles.triangle)) == 8


def test_a_zone_that_is_everything_moves_nothing():
    zone = np.ones(len(MESHES["ellipsoid"].vertices), bool)
    poles = guide_of("ellipsoid").guidance(zone=zone).poles
    assert poles.total == 8 and not poles.moved.any()


def test_paths_along_edges_are_near_the_lines():
    mesh = MESHES["ellipsoid"]
    arcs = guide_of("ellipsoid").separatrices()
    sides = np.concatenate([mesh.triangles[:, [k, (k + 1) % 3]] for k in range(3)])
    edges = np.unique(np.sort(sides, axis=1), axis=0)
    marked = edge_paths(mesh.vertices, edges, arcs)
    used = edges[marked]
    assert np.abs(mesh.vertices[used, 1]).max() < mesh.edge_length
    # A ring: every vertex has two of them.
    assert set(np.bincount(used.ravel())) <= {0, 2}


def without_singularities(surface, smoothing):
    """A cross field that has lost all of them."""
    return SimpleNamespace(
        triangle_index=np.zeros(len(surface.triangles)),
        smoothing=smoothing,
        strength=np.ones(len(surface.vertices)),
    )


@pytest.mark.parametrize("known", [True, False])
@pytest.mark.parametrize("lengths", [0.1, 8.0])
def test_poles_that_the_field_has_lost_stand_to_both_sides_of_the_separatrix(known, lengths):
    """By half a smoothing length, but at least an edge; somewhere where it is not known."""
    guide = guide_of("ellipsoid")
    surface, umbilics = guide.surface, guide.detection.umbilics
    ray = umbilics.separatrix[:, 0]
    if not known:
        umbilics = replace(umbilics, separatrix=np.full_like(umbilics.separatrix, np.nan))
    edge = 1.5 * float(np.sqrt(np.median(surface.face_normal_area[1])))
    cross = without_singularities(surface, lengths * edge)
    planes = guide.planes(Progress())
    poles = plan_poles(surface, planes, cross, umbilics, [], plan="umbilics")
    assert poles.umbilic.tolist() == [0, 0, 1, 1, 2, 2, 3, 3]
    assert (poles.valence == 3).all() and poles.total == 8
    apart = max(0.5 * lengths, 1.0) * edge * surface.unit
    for number in range(4):
        away = poles.position[poles.umbilic == number] - umbilics.position[number]
        np.testing.assert_allclose(np.linalg.norm(away, axis=1), apart, rtol=0.1)
        across = away / np.linalg.norm(away, axis=1, keepdims=True)
        assert across[0] @ across[1] < -0.8
        if known:
            assert np.abs(across @ ray[number]).max() < 0.3


def test_poles_are_listed_by_their_umbilics_those_without_one_last():
    guide = guide_of("ellipsoid")
    surface, umbilics = guide.surface, guide.detection.umbilics
    middle = surface.vertices[surface.triangles].mean(axis=1) * surface.unit + surface.origin
    top = np.argmax(middle[:, 1])
    cross = without_singularities(surface, 0.01)
    cross.triangle_index[[*umbilics.triangle, top]] = 0.25
    # Not in the order of their triangles.
    shuffled = umbilics.select(np.argsort(-umbilics.triangle))
    poles = plan_poles(surface, guide.planes(Progress()), cross, shuffled, [])
    assert poles.umbilic.tolist() == [0, 1, 2, 3, -1]
    assert poles.triangle.tolist() == [*shuffled.triangle, top]


def test_an_umbilic_in_the_first_triangle_has_its_poles_and_one_on_nothing_none():
    mesh, umbilics = MESHES["ellipsoid"], guide_of("ellipsoid").detection.umbilics
    count = len(mesh.triangles)
    first = int(umbilics.triangle[0])
    # The first umbilic's triangle becomes the first one; the last one is none at all.
    triangles = np.concatenate([np.roll(mesh.triangles, -first, axis=0), [[0, 0, 1]]])
    detection = core.detect(mesh.vertices, triangles)
    guide = core.Guide(mesh.vertices, triangles, detection)
    moved = (umbilics.triangle - first) % count
    moved[1] = count
    umbilics = replace(umbilics, triangle=moved)
    cross = without_singularities(guide.surface, 0.01)
    planes = guide.planes(Progress())
    poles = plan_poles(guide.surface, planes, cross, umbilics, [], plan="umbilics")
    assert [int((poles.umbilic == number).sum()) for number in range(4)] == [2, 0, 2, 2]
    # The same of one that the field has.
    cross.triangle_index[0] = 0.25
    claimed = plan_poles(guide.surface, planes, cross, umbilics, [])
    assert (claimed.umbilic.tolist(), claimed.triangle.tolist()) == ([0], [0])
    # The sum wants two more, which nothing places.
    assert (poles.umbilic == -1).sum() == 2 and poles.total == 8


def test_a_region_of_an_open_surface_gets_the_poles_of_its_index_where_the_field_is_weakest():
    guide = guide_of("cylinder")
    surface = guide.surface
    cross = without_singularities(surface, 0.01)
    weak = [surface.triangles[5, 0], surface.triangles[400, 0]]
    cross.strength[weak] = 0.1
    region = SimpleNamespace(triangles=np.arange(40), index=0.5)
    nobody = guide.detection.umbilics
    assert not len(nobody)
    planes = guide.planes(Progress())
    poles = plan_poles(surface, planes, cross, nobody, [region], plan="umbilics")
    assert poles.valence.tolist() == [3, 3]
    assert np.isin(weak, surface.triangles[poles.triangle]).any()
    assert np.allclose(poles.barycentric, 1.0 / 3.0)
    corner = MESHES["cylinder"].vertices[MESHES["cylinder"].triangles[poles.triangle]]
    assert np.allclose(corner.mean(axis=1), poles.position)
    assert not len(plan_poles(surface, planes, cross, nobody, [], plan="umbilics"))


def test_of_singularities_that_nothing_claims_those_far_from_opposite_ones_are_planned():
    guide = guide_of("cylinder")
    cross = without_singularities(guide.surface, 0.01)
    cross.triangle_index[[0, 2, 400]] = [0.25, -0.25, 0.25]
    # The region wants one: not the one beside an opposite one.
    region = SimpleNamespace(triangles=np.arange(4), index=0.25)
    planes, nobody = guide.planes(Progress()), guide.detection.umbilics
    poles = plan_poles(guide.surface, planes, cross, nobody, [region], plan="umbilics")
    assert poles.triangle.tolist() == [400]


def test_there_is_no_pole_in_a_triangle_without_an_inner_vertex():
    """Nor is there one at a border vertex of the field of the faces."""
    guide = guide_of("monkey saddle")
    surface = guide.surface
    ear = np.flatnonzero(surface.border[surface.triangles].all(axis=1))
    inner = np.flatnonzero(~surface.border[surface.triangles].any(axis=1))[0]
    assert len(ear)
    cross = without_singularities(surface, 0.01)
    cross.triangle_index[[ear[0], inner]] = -0.25
    none = guide.detection.umbilics.select(np.zeros(0, np.int64))
    poles = plan_poles(surface, guide.planes(Progress()), cross, none, [])
    assert poles.triangle.tolist() == [surface.source_triangle[inner]]


def test_poles_in_one_triangle_have_vertices_of_their_own_and_too_many_are_said():
    guide = guide_of("torus")
    surface, planes = guide.surface, guide.planes(Progress())
    settings, measured = core.GuidanceSettings(), guide.measured(Progress())
    cross = cross_field(surface, measured, settings, Progress())
    features = find_features(surface, settings)
    near = np.unique(adjacency(surface)[surface.triangles[100]].indices)
    # Three at the corners and others beside; where all vertices are taken opposite ones cancel.
    for pairs, enough in (1, True), (2, True), (len(near), False):
        sign = np.tile([1, -1], pairs)
        triangle = np.full(len(sign), 100)
        found = with_poles(surface, planes, cross, features, triangle, sign, Progress())
        assert (found.astray == 0) == enough
        poles = plan_poles(surface, planes, cross, guide.detection.umbilics, [])
        said = disagreements(surface, 0, found, poles)
        assert [f"in {found.astray} places" in text for text in said] == [True] * (not enough)
        vertex, quarters = face_field_singularities(surface, planes, found.face_direction)
        if enough:
            assert np.isin(vertex, near).all()
            assert np.array_equal(np.sort(quarters), np.sort(sign))


def test_poles_whose_vertex_lies_beside_their_triangle_go_to_it():
    """Then plan and faces name the same poles: a vertex an edge away was taken for another's."""
    guide = guide_of("torus")
    surface, planes = guide.surface, guide.planes(Progress())
    settings, measured = core.GuidanceSettings(), guide.measured(Progress())
    cross = cross_field(surface, measured, settings, Progress())
    features = find_features(surface, settings)
    triangle, sign = np.full(4, 100), np.array([1, -1, 1, -1])
    cross = with_poles(surface, planes, cross, features, triangle, sign, Progress())
    cross, row, triangle, sign = with_poles_of_faces(
        surface, planes, cross, triangle, sign, Progress()
    )
    assert row.tolist() == [0, 1, 2, 3] and sign.tolist() == [1, -1, 1, -1]
    vertex, quarters = face_field_singularities(surface, planes, cross.face_direction)
    for one in (1, -1):
        corner = surface.triangles[triangle[sign == one]]
        reach = (corner[:, :, None] == vertex[quarters == one]).any(axis=1)
        assert (maximum_bipartite_matching(sparse.csr_array(reach)) >= 0).all()
    planned = np.zeros(len(surface.triangles))
    np.add.at(planned, triangle, sign)
    assert np.array_equal(np.rint(4 * cross.triangle_index), planned)


def test_poles_without_a_free_vertex_get_none():
    reach = sparse.csr_array(np.ones((2, 5), bool))
    assert (_matched(reach, np.ones(5, bool)) == -1).all()
    taken = np.array([True, True, False, True, True])
    assert sorted(_matched(reach, taken).tolist()) == [-1, 2]
    assert taken.all()


def test_an_umbilic_takes_as_many_singularities_as_its_index_has_quarters():
    """Those of its sign, the nearest first; what has no place on the surface takes none."""
    surface = guide_of("torus").surface
    index = np.array([1.0, 0.5, 1.0])
    # One after the other along a row of triangles, all of them near.
    single = np.arange(0, 14, 2)
    place = surface.vertices[surface.triangles[single]].mean(axis=1)
    there = place[[0, 6, 2]] * surface.unit + surface.origin
    umbilics = SimpleNamespace(index=index, position=there)
    cross = SimpleNamespace(smoothing=1.0)
    arguments = surface, cross, umbilics, np.array([0, 12, -1])
    owner = _claimed(*arguments, Singularities(single, np.ones(7, int), place), 1.0)
    assert owner.tolist() == [0, 0, 0, 0, -1, 1, 1]
    assert (_claimed(*arguments, Singularities(single, -np.ones(7, int), place), 1.0) == -1).all()


def test_a_pole_is_as_sure_as_its_umbilic_rises_out_of_the_noise():
    umbilics = SimpleNamespace(
        persistence=np.array([3.0, 3.0, 3.0, np.inf, np.nan]),
        noise=np.array([1.0, 2.0, 2.0, 1.0, np.nan]),
        certain=np.array([True, True, False, True, True]),
    )
    found = _confidence(umbilics, np.arange(5))[:4]
    sure = 3.0 / (3.0 + PAIR_NOISE * np.array([1.0, 2.0]))
    np.testing.assert_allclose(found, [*sure, 0.5 * sure[1], 1.0])


def test_a_pole_of_another_triangle_stands_in_its_middle():
    surface, poles = guide_of("ellipsoid").surface, poles_of("ellipsoid")
    poles = replace(poles, barycentric=np.tile([0.5, 0.3, 0.2], (len(poles), 1)))
    triangle, weights = places_on_surface(surface, poles.triangle, poles.barycentric)
    rows, beside = np.array([0, 1, -1]), surface.twin[3 * triangle[1]] // 3
    asked = np.array([triangle[0], beside, triangle[2]])
    found = replanned(surface, [], poles, rows, asked, np.ones(3))
    middle = surface.vertices[surface.triangles[asked]].mean(axis=1)
    stays = weights[0] @ surface.vertices[surface.triangles[triangle[0]]]
    expected = np.vstack([stays, middle[1:]]) * surface.unit + surface.origin
    np.testing.assert_allclose(found.position, expected, atol=1e-12)
    assert found.confidence[:2].tolist() == poles.confidence[:2].tolist()
