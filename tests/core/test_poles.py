"""The pole plan: counts, sums, zones, what each pole says."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from surfaces import cylinder, ellipsoid, monkey_saddle, quartic, sphere, torus

import core
from core.base.progress import Progress
from core.retopology.lines.edge_paths import edge_paths
from core.retopology.poles import plan_poles


def planned(mesh, zone=None, detection_settings=None, **settings):
    detection = core.detect(mesh.vertices, mesh.triangles, detection_settings)
    guide = core.Guide(mesh.vertices, mesh.triangles, detection)
    return detection, guide.guidance(core.GuidanceSettings(**settings), zone=zone).poles


@pytest.mark.parametrize("plan", ["field", "umbilics"])
@pytest.mark.parametrize(
    "mesh, total", [(ellipsoid(), 8), (quartic(), 8), (sphere(), 8), (torus(), 0)]
)
def test_the_sum_is_four_times_the_euler_characteristic(mesh, total, plan):
    _, poles = planned(mesh, plan=plan)
    assert (4 - poles.valence).sum() == poles.total == poles.expected == total
    assert set(poles.valence) <= {3, 5}


@pytest.mark.parametrize("plan", ["field", "umbilics"])
def test_every_lemon_becomes_two_three_poles(plan):
    detection, poles = planned(ellipsoid(), plan=plan)
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
    mesh = ellipsoid(subdivisions=4)
    detection = core.detect(mesh.vertices, mesh.triangles)
    guide = core.Guide(mesh.vertices, mesh.triangles, detection)
    surface = guide.surface
    edge = 1.5 * float(np.sqrt(np.median(surface.face_normal_area[1])))
    smoothing = 0.5 * edge
    middle = surface.vertices[surface.triangles].mean(axis=1) * surface.unit + surface.origin
    away = np.linalg.norm(middle[:, None] - detection.umbilics.position, axis=2).min(axis=1)
    wanted = (lengths * smoothing + edges * edge) * surface.unit
    moved = np.argmin(np.abs(away - wanted))
    assert abs(away[moved] - wanted) < 0.1 * edge * surface.unit
    index = np.zeros(len(surface.triangles))
    index[moved] = 0.25
    cross = SimpleNamespace(triangle_index=index, smoothing=smoothing)
    poles = plan_poles(surface, guide.planes(Progress()), cross, detection.umbilics, [])
    assert (poles.umbilic[0] >= 0) == claimed


def test_poles_of_an_umbilic_that_is_not_certain_are_half_as_sure():
    mesh = ellipsoid(subdivisions=3)
    detection = core.detect(mesh.vertices, mesh.triangles)
    doubted = replace(detection.umbilics, certain=np.array([True, False, True, False]))
    detection = replace(detection, umbilics=doubted)
    poles = core.Guide(mesh.vertices, mesh.triangles, detection).guidance().poles
    assert np.array_equal(poles.confidence, np.where(doubted.certain, 1.0, 0.5)[poles.umbilic])


def test_every_umbilic_has_its_poles_where_all_are_wanted():
    detection, poles = planned(quartic(), plan="umbilics")
    quarters = np.bincount(
        poles.umbilic[poles.umbilic >= 0],
        weights=(4 - poles.valence)[poles.umbilic >= 0],
        minlength=len(detection.umbilics),
    )
    assert np.array_equal(quarters, 4 * detection.umbilics.index)


def test_sums_hold_where_the_filters_left_them_open():
    _, poles = planned(quartic(), detection_settings=core.Settings(opening=2), plan="umbilics")
    assert poles.total == poles.expected == 8


def test_poles_of_a_region_are_spread_over_it():
    _, poles = planned(sphere())
    assert (poles.umbilic == -1).all() and (poles.region == 0).all()
    # As on a cube: no two nearer than an edge of it, by a good margin.
    gap = np.linalg.norm(poles.position[:, None] - poles.position[None], axis=2)
    assert gap[np.triu_indices(8, 1)].min() > 0.8


def test_open_surface_has_no_expected_sum():
    _, poles = planned(cylinder())
    assert np.isnan(poles.expected) and len(poles) == 0
    _, star = planned(monkey_saddle())
    assert np.isnan(star.expected)


def test_poles_lie_on_their_triangles():
    mesh = ellipsoid()
    _, poles = planned(mesh)
    corner = mesh.vertices[mesh.triangles[poles.triangle]]
    assert np.allclose(np.einsum("kc,kcx->kx", poles.barycentric, corner), poles.position)
    assert np.allclose(np.linalg.norm(poles.normal, axis=1), 1.0)


def test_marked_zone_is_avoided():
    mesh = ellipsoid()
    zone = mesh.vertices[:, 0] > 2.0
    _, poles = planned(mesh, zone=zone)
    assert not zone[mesh.triangles[poles.triangle]].any()
    assert poles.moved.sum() == 4 and poles.total == 8
    assert len(np.unique(poles.triangle)) == 8


def test_a_zone_that_is_everything_moves_nothing():
    mesh = ellipsoid(subdivisions=3)
    _, poles = planned(mesh, zone=np.ones(len(mesh.vertices), bool))
    assert poles.total == 8 and not poles.moved.any()


def test_paths_along_edges_are_near_the_lines():
    mesh = ellipsoid(subdivisions=4)
    detection = core.detect(mesh.vertices, mesh.triangles)
    arcs = core.Guide(mesh.vertices, mesh.triangles, detection).separatrices()
    sides = np.concatenate([mesh.triangles[:, [k, (k + 1) % 3]] for k in range(3)])
    edges = np.unique(np.sort(sides, axis=1), axis=0)
    marked = edge_paths(mesh.vertices, edges, arcs)
    used = edges[marked]
    assert np.abs(mesh.vertices[used, 1]).max() < mesh.edge_length
    # A ring: every vertex has two of them.
    assert set(np.bincount(used.ravel())) <= {0, 2}
