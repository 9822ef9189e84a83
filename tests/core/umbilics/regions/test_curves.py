"""Curves of umbilics are regions of their own kind, and hold no points."""

import numpy as np
import pytest
from surfaces import (
    icosphere,
    marching_tetrahedra,
    random_field,
    random_harmonics,
    random_points,
    seed_patch,
)
from surfaces.images import noisy
from surfaces.revolution import VASE_CIRCLE, revolved, vase

import core
from core.base.progress import Progress
from core.curvature.estimate import estimate
from core.curvature.tolerances import CURVE
from core.fields.winding import Winding
from core.mesh.mending.repair import clean
from core.mesh.normals import vertex_normals
from core.umbilics.methods.raw import RawUmbilics
from core.umbilics.regions.region_map import RegionMap, with_curves
from core.umbilics.regions.unresolved import UnresolvedSets, unresolved_sets
from core.umbilics.shown_curves import without_shown

# A turn after which no row of vertices lies along a symmetry.
TURN, _ = np.linalg.qr(np.array([[2.0, 0.3, 0.5], [-0.2, 3.0, 0.7], [0.4, -0.6, 1.5]]))


def rough(vertices, triangles, share, seed=0):
    """Moved by normal deviates of a share of the mean edge."""
    side = vertices[triangles[:, 0]] - vertices[triangles[:, 1]]
    edge = np.linalg.norm(side, axis=1).mean()
    return vertices + share * edge * np.random.default_rng(seed).normal(size=vertices.shape)


@pytest.mark.once
@pytest.mark.parametrize(
    "columns, rows, diagonals, jitter, noise",
    [
        (96, 64, "one", 0.0, 0.0),
        (96, 64, "random", 0.0, 0.0),
        (96, 64, "random", 0.3, 0.0),
        (64, 30, "other", 0.0, 0.0),
        (96, 64, "random", 0.3, 0.02),
    ],
)
def test_the_circles_of_a_vase_are_two_curves_and_no_point(columns, rows, diagonals, jitter, noise):
    vertices, triangles = revolved(vase, 3.0, columns, rows, diagonals, jitter)
    detection = core.detect(rough(vertices, triangles, noise), triangles)
    assert len(detection.umbilics) == 0
    assert [(region.kind, region.index) for region in detection.regions] == [("curve", 0.0)] * 2
    assert any("2 curves" in text for text in detection.warnings)
    sides = set()
    for region in detection.regions:
        z = vertices[triangles[region.triangles]].mean(axis=1)[:, 2]
        assert np.median(np.abs(z)) == pytest.approx(VASE_CIRCLE, abs=0.1)
        sides.add(np.sign(np.median(z)))
        # All the way around.
        angle = np.arctan2(*vertices[triangles[region.triangles]].mean(axis=1)[:, :2].T)
        assert np.histogram(angle, 12, (-np.pi, np.pi))[0].min() > 0
    assert sides == {-1.0, 1.0}


def test_a_vase_of_many_periods_keeps_no_point():
    vertices, triangles = revolved(vase, 2.0 * np.pi, 96, 128)
    detection = core.detect(vertices, triangles)
    assert len(detection.umbilics) == 0
    assert [region.kind for region in detection.regions] == ["curve"] * 4


@pytest.mark.once
@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_a_pear_has_a_circle_and_two_poles(noise):
    points, triangles = icosphere(5)
    vertices = points * (1.0 + 0.25 * points[:, 2:] ** 3) * (1.0, 1.0, 1.2)
    detection = core.detect(rough(vertices, triangles, noise), triangles)
    assert [region.kind for region in detection.regions] == ["curve"]
    found = detection.umbilics
    # Noise splits them.
    assert noise or found.kind.tolist() == ["compound"] * 2
    top = found.position[:, 2] > 0.0
    assert found.index[top].sum() == found.index[~top].sum() == 1.0
    assert (np.hypot(*found.position.T[:2]) < 0.2).all()
    assert detection.index_sum == 2.0


def test_without_regions_there_are_no_curves():
    vertices, triangles = revolved(vase, 3.0, 96, 64)
    detection = core.detect(vertices, triangles, core.Settings(regions=False))
    assert not detection.regions


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.0, 0.01, 0.03])
def test_what_a_border_cuts_off_is_no_curve(noise):
    mesh = noisy(seed_patch(5400), noise) if noise else seed_patch(5400)
    detection = core.detect(mesh.vertices, mesh.triangles)
    assert not [region for region in detection.regions if region.kind == "curve"]


def test_lines_of_curvature_go_on_across_a_curve():
    vertices, triangles = revolved(vase, 3.0, 64, 40)
    detection = core.detect(vertices, triangles)
    guide = core.Guide(vertices, triangles, detection)
    assert len(detection.regions) == 2 and not guide.undirected.any()
    assert not guide.simplified(Progress()).index.any()


def _strip(index, long=True, beside=False, missed=0.5):
    """A strip of a flat patch as an unresolved set with that index; in a region if `beside`."""
    points, triangles = random_points(800, (-1, -1), (1, 1), 0)
    surface = clean(np.column_stack([points, np.zeros(800)]), triangles)[0]
    middle = surface.vertices[surface.triangles].mean(axis=1)
    label = np.where(np.abs(middle[:, 0]) < 0.04, 0, -1).astype(np.int32)
    inside = np.flatnonzero(label == 0)
    turning = np.zeros(len(label))
    turning[inside[0]] = index
    diameter = 0.1 if long else 0.5
    sets = UnresolvedSets(label, *(np.array([x]) for x in (1.0, 0.05, diameter, missed)))
    regions = RegionMap.none(surface)
    if beside:
        near = np.where((middle[:, 0] > 0.04) & (middle[:, 0] < 0.3), 0, -1).astype(np.int32)
        regions = RegionMap(near, 1)
    found = with_curves(surface, regions, sets, turning)
    assert sorted(set(found.label.tolist())) == list(range(-1, found.count))
    return found


def test_a_curve_is_long_has_no_index_and_touches_no_region():
    assert _strip(0.0).curves == 1
    assert _strip(0.5).curves == 0
    assert _strip(0.0, long=False).curves == 0
    assert _strip(0.0, beside=True).curves == 0
    assert _strip(0.0, missed=1.0).curves == 0


@pytest.mark.slow
def test_a_valley_between_umbilics_is_no_curve():
    # Cells leave the gap within its error all along it.
    detection = core.detect(*marching_tetrahedra(random_field(2), 48))
    assert not detection.regions
    assert len(detection.umbilics) == 10


@pytest.mark.slow
def test_a_curve_whose_umbilics_a_finer_fit_shows_is_none():
    """Under noise the gap stays within its error all along a valley between two of them."""
    surface = random_harmonics(300)
    points, triangles = icosphere(5)
    vertices = surface.on_rays(points @ TURN)
    corners, others = triangles.ravel(), np.roll(triangles, 1, axis=1).ravel()
    side = np.linalg.norm(vertices[corners] - vertices[others], axis=1)
    edge = np.bincount(corners, side) / np.bincount(corners)
    shift = np.random.default_rng(303).normal(size=vertices.shape)
    vertices = vertices + 0.05 * edge[:, None] * shift
    detection = core.detect(vertices, triangles)
    assert not detection.regions
    true = surface.umbilics()
    assert np.sort(detection.umbilics.index).tolist() == np.sort(true.index).tolist()


def test_a_curve_holds_no_umbilic_that_is_isolated_beyond_doubt():
    """Whatever else turns on it: on an ellipsoid one of an umbilic and a triangle where there is
    none is no curve, on one with a place of noise alone the curve stays."""
    points, triangles = icosphere(4)
    surface = clean(points @ TURN * (3.0, 2.0, 1.0), triangles)[0]
    fitted = estimate(surface, vertex_normals(surface), core.Settings(), None, None, Progress())
    index = Winding.of(surface, fitted.field.d1, fitted.field.d2, Progress()).index
    there, elsewhere = np.flatnonzero(index)[0], np.flatnonzero(index == 0.0)[0]
    for rows, kept in (([there, elsewhere], 0), ([elsewhere], 1)):
        label = np.full(len(index), -1, np.int32)
        label[rows] = 0
        count = len(rows)
        middles = np.full((count, 3), 1.0 / 3.0)
        raw = RawUmbilics(
            np.array(rows), middles, np.full(count, 0.5), np.full(count, -1), np.zeros(0)
        )
        regions = RegionMap(label, 1, curves=1)
        left = without_shown(surface, fitted, raw, regions, Progress())
        assert left.curves == left.count == kept


def test_errors_as_large_as_the_bend_of_the_surface_decide_nothing():
    points, triangles = icosphere(3)
    surface = clean(points * (3.0, 2.0, 1.0), triangles)[0]
    field = core.detect(points * (3.0, 2.0, 1.0), triangles).curvature
    ones = np.ones(len(points))
    scaled = {name: getattr(field, name) * surface.unit for name in ("k1", "k2")}
    field = core.CurvatureField(**(vars(field) | scaled))
    every = np.arange(len(points))
    wild = unresolved_sets(surface, field, 100.0 * ones, ones, CURVE, every, Progress())
    none = unresolved_sets(surface, field, 0.0 * ones, ones, CURVE, every, Progress())
    assert np.array_equal(wild.label, none.label)
    some = unresolved_sets(surface, field, 0.3 * ones, 0.01 * ones, CURVE, every, Progress())
    assert (some.label >= 0).sum() > (none.label >= 0).sum()
    assert len(some.length) > 1
    area = surface.face_normal_area[1]
    covered = [area[some.label == number].sum() for number in range(len(some.length))]
    assert np.allclose(some.width * some.length, covered)


def test_a_deviator_of_zero_without_error_is_zero_everywhere():
    points, triangles = icosphere(2)
    surface = clean(points, triangles)[0]
    ones = np.ones(len(points))
    field = core.detect(points, triangles).curvature
    field = core.CurvatureField(**(vars(field) | {"k1": ones, "k2": ones}))
    every = np.arange(len(points))
    found = unresolved_sets(surface, field, 0.0 * ones, ones, CURVE, every, Progress())
    assert (found.label == 0).all()
    assert found.missed.tolist() == [0.0]
