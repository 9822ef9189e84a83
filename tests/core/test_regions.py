"""Regions: what is spherical or flat over an area is one, what is an umbilic point is none."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from surfaces import ellipsoid, icosphere, plane, random_points, sphere

from core.cleaning import clean
from core.field_noise import field_noise
from core.regions import PLANAR, SPHERICAL, RegionMap, describe_regions, find_regions
from core.surface import Surface
from core.tolerances import REGION_SIZE


def _surface(surface) -> Surface:
    return clean(surface.vertices, surface.triangles)[0]


def _patch(count: int = 3000, seed: int = 0) -> Surface:
    points, triangles = random_points(count, (-1, -1), (1, 1), seed)
    return clean(np.column_stack([points, np.zeros(count)]), triangles)[0]


def _normal_errors(surface: Surface, seed: int = 0) -> np.ndarray:
    """Length of a plane vector of normal errors of mean square 1, smoothed over the one-ring."""
    random = np.random.default_rng(seed)
    error = random.normal(size=(len(surface.vertices), 2))
    start = surface.neighbour_start
    around = np.add.reduceat(error[surface.neighbours], start[:-1]) + error
    around /= np.sqrt(np.diff(start) + 1)[:, None]
    return np.linalg.norm(around, axis=1) / np.sqrt(2)


def _find(surface: Surface, gap: np.ndarray, noise: float | np.ndarray, radius: float):
    ones = np.ones(len(surface.vertices))
    return find_regions(surface, gap, noise * ones, radius * ones)


def test_pure_noise_is_one_region():
    surface = _patch()
    found = _find(surface, 0.1 * _normal_errors(surface), 0.1, 0.06)
    assert found.count == 1
    assert (found.label == 0).all()


def test_an_umbilic_in_the_noise_is_no_region():
    surface = _patch()
    distance = np.linalg.norm(surface.vertices[:, :2], axis=1)
    # The noise drowns a disc of a third of the patch, far more than one fit sees.
    for errors in (0.0, _normal_errors(surface)):
        gap = np.hypot(distance, 0.15 * errors)
        assert _find(surface, gap, 0.15, 0.06).count == 0


def test_a_strip_of_noise_is_a_region():
    surface = _surface(plane(cells=80))
    x = np.abs(surface.vertices[:, 0])
    gap = np.where(x < 0.2, 0.01 * _normal_errors(surface), 5.0 * (x - 0.15))
    found = _find(surface, gap, 0.01, 0.05)
    assert found.count == 1
    centre = surface.vertices[surface.triangles].mean(axis=1)
    assert (np.abs(centre[found.label == 0, 0]) < 0.22).all()
    assert (found.label[np.abs(centre[:, 0]) < 0.15] == 0).all()


def test_small_areas_are_no_regions():
    surface = _patch(6000)
    distance = np.linalg.norm(surface.vertices[:, :2], axis=1)
    radius = 0.05
    for factor, count in ((0.8, 0), (1.4, 1)):
        size = radius * np.sqrt(factor * REGION_SIZE)
        assert (
            _find(surface, np.where(distance < size + 0.02, 0.0, 1.0), 0.1, radius).count == count
        )


def test_two_areas_are_two_regions():
    surface = _surface(plane(cells=80))
    x = surface.vertices[:, 0]
    found = _find(surface, np.where(np.abs(x) < 0.1, 1.0, 0.0), 0.01, 0.05)
    assert found.count == 2
    left, right = (surface.vertices[surface.triangles[rows]][:, :, 0] for rows in found.rows())
    assert left.max() < 0 < right.min() or right.max() < 0 < left.min()


def test_holes_are_filled():
    surface = _patch()
    gap = np.zeros(len(surface.vertices))
    gap[[5, 50, 500]] = 1.0
    found = _find(surface, gap, 0.01, 0.08)
    assert found.count == 1
    assert (found.label == 0).all()


def test_unknown_vertices_go_with_those_around_them():
    surface = _patch()
    gap = np.zeros(len(surface.vertices))
    gap[surface.border] = np.nan
    assert (_find(surface, gap, 0.01, 0.05).label == 0).all()
    assert _find(surface, gap + 1.0, 0.01, 0.05).count == 0
    assert _find(surface, np.full_like(gap, np.nan), 0.01, 0.05).count == 0
    assert _find(surface, gap, np.nan, 0.05).count == 0


def test_a_crease_is_no_region():
    surface = _patch()
    # The fit's error is as large as the gap, and both are as large as 1 / radius.
    assert _find(surface, np.full(len(surface.vertices), 10.0), 12.0, 0.05).count == 0


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e4])
def test_described_in_units_of_the_input(scale):
    vertices, triangles = icosphere(4)
    surface = clean(scale * vertices, triangles)[0]
    ones = np.ones(len(vertices))
    index = np.zeros(len(triangles))
    index[:4] = 0.5
    found = find_regions(surface, 0.0 * ones, 0.01 * ones, 0.1 * ones)
    (region,) = describe_regions(surface, found, ones, 0.01 * ones, 0.1 * ones, index)
    assert region.kind == SPHERICAL
    assert region.index == 2.0
    assert region.area == pytest.approx(4 * np.pi * scale**2, rel=0.01)
    assert region.curvature == pytest.approx(1 / scale)
    assert np.array_equal(np.sort(region.triangles), np.arange(len(triangles)))


def test_flat_within_the_noise_is_planar():
    surface = _patch()
    ones = np.ones(len(surface.vertices))
    everything = RegionMap(np.zeros(len(surface.triangles), dtype=np.int32), 1)
    index = np.zeros(len(surface.triangles))
    for curvature, noise, kind in (
        (0.001, 0.0, PLANAR),
        (0.1, 0.0, SPHERICAL),
        (0.1, 10.0, PLANAR),
        (np.nan, np.nan, PLANAR),
    ):
        (region,) = describe_regions(
            surface, everything, curvature * ones, noise * ones, 0.1 * ones, index
        )
        assert region.kind == kind
        assert np.isfinite(region.curvature)


def test_noise_of_exact_operators():
    for shape, regions in (
        (sphere(subdivisions=4), 1),
        (plane(), 1),
        (ellipsoid(subdivisions=4), 0),
    ):
        exact = _surface(shape)
        noise, radius = field_noise(
            exact, shape.k1 * exact.unit, shape.k2 * exact.unit, shape.d1, shape.normal
        )
        assert np.isfinite(noise).all() and (noise >= 0).all()
        found = find_regions(exact, (shape.k1 - shape.k2) * exact.unit, noise, radius)
        assert found.count == regions


@given(st.integers(20, 300), st.integers(0, 1000), st.floats(0.0, 1.0), st.floats(0.02, 0.3))
@settings(max_examples=60, deadline=None)
def test_labels_are_sound(count, seed, flat_part, radius):
    surface = _patch(count, seed)
    random = np.random.default_rng(seed)
    gap = np.where(random.random(count) < flat_part, 0.0, random.random(count))
    found = _find(surface, gap, 0.05, radius)
    assert found.label.shape == (len(surface.triangles),)
    assert sorted(np.unique(found.label[found.label >= 0])) == list(range(found.count))
    rows = found.rows()
    assert len(rows) == found.count
    assert sum(len(row) for row in rows) == np.count_nonzero(found.label >= 0)
