"""Regions: what is spherical or flat over an area is one, what is an umbilic point is none."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from surfaces import (
    cylinder,
    ellipsoid,
    icosphere,
    noisy,
    plane,
    quartic,
    random_ellipsoid,
    random_points,
    seed_patch,
    sphere,
    torus,
)

import core
from core.curvature.noise import field_noise
from core.curvature.tolerances import REGION_SIZE
from core.mesh.exact_shapes import PLANAR, SPHERICAL
from core.mesh.mending.repair import clean
from core.mesh.surface import Surface
from core.mesh.tessellated import Tessellation
from core.umbilics.regions import round_shapes
from core.umbilics.regions.find import find_regions
from core.umbilics.regions.region_map import RegionMap, with_faces
from core.umbilics.regions.report import describe_regions
from core.umbilics.regions.round_shapes import standing_off


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


@pytest.mark.once
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


def rounded_cube(cells: int, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """The cube [-1, 1]^3 with edges and corners rounded, `cells` along each side."""
    side = np.linspace(-1, 1, cells + 1)
    u, v = (values.ravel() for values in np.meshgrid(side, side, indexing="ij"))
    number = np.arange(len(u)).reshape(cells + 1, cells + 1)
    a, b, c, d = (
        corner.ravel()
        for corner in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:])
    )
    half = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    points, triangles = [], []
    for axis in range(3):
        for sign in (-1, 1):
            face = np.roll(np.stack([np.full_like(u, sign), u, v], axis=1), axis, axis=1)
            triangles.append((half if sign > 0 else half[:, ::-1]) + len(points) * len(u))
            points.append(face)
    grid = np.rint(np.concatenate(points) * cells).astype(int)
    _, first, place = np.unique(grid, axis=0, return_index=True, return_inverse=True)
    cube = np.concatenate(points)[first]
    inner = np.clip(cube, radius - 1, 1 - radius)
    outward = cube - inner
    length = np.linalg.norm(outward, axis=1, keepdims=True)
    return inner + radius * outward / length, place.ravel()[np.concatenate(triangles)]


def capped_cylinder(around: int = 64, up: int = 32, across: int = 16):
    """Radius 1, from z = -1 to 1, closed by two flat discs with a sharp rim."""
    rim = [(i / across, 1.0) for i in range(1, across)]
    wall = [(1.0, 1.0 - 2.0 * j / up) for j in range(up + 1)]
    profile = rim + wall + [(r, -z) for r, z in reversed(rim)]
    angle = 2 * np.pi * np.arange(around) / around
    rings = [
        np.stack([r * np.cos(angle), r * np.sin(angle), np.full(around, z)], axis=1)
        for r, z in profile
    ]
    vertices = np.concatenate([[[0, 0, 1.0]], *rings, [[0, 0, -1.0]]])
    j = np.arange(around)
    k = (j + 1) % around
    triangles = [np.stack([0 * j, 1 + j, 1 + k], axis=1)]
    for ring in range(len(profile) - 1):
        one, two = 1 + ring * around, 1 + (ring + 1) * around
        triangles += [
            np.stack([one + j, two + j, two + k], axis=1),
            np.stack([one + j, two + k, one + k], axis=1),
        ]
    last = 1 + (len(profile) - 1) * around
    triangles.append(np.stack([0 * j + len(vertices) - 1, last + k, last + j], axis=1))
    return vertices, np.concatenate(triangles)


@pytest.mark.slow
@pytest.mark.parametrize(
    "curvature, noise",
    [("jets", 0.0), ("jets", 0.02), ("jets", 0.1), ("normals", 0.0), ("normals", 0.02)],
)
def test_detect_a_sphere(curvature, noise):
    surface = noisy(sphere(2.0, subdivisions=4), noise)
    choices = core.Settings(curvature=curvature)
    detection = core.detect(surface.vertices, surface.triangles, choices)
    (region,) = detection.regions
    assert len(detection.candidates) == 0
    assert region.kind == SPHERICAL
    assert region.index == detection.index_sum == 2.0
    assert region.area == pytest.approx(16 * np.pi, rel=0.02)
    assert region.curvature == pytest.approx(0.5, rel=0.1)
    points = core.detect(
        surface.vertices, surface.triangles, core.Settings(curvature=curvature, regions=False)
    )
    assert len(points.regions) == 0 and points.index_sum == 2.0


def test_detect_a_plane():
    for tilt in (0.0, 0.3):
        surface = plane(tilt=tilt)
        detection = core.detect(surface.vertices, surface.triangles)
        (region,) = detection.regions
        assert len(detection.candidates) == 0
        assert region.kind == PLANAR
        assert len(region.triangles) == len(surface.triangles)
        assert region.curvature == pytest.approx(0.0, abs=1e-6)


@pytest.mark.once
def test_detect_a_rounded_cube():
    vertices, triangles = rounded_cube(60, 0.4)
    detection = core.detect(vertices, triangles)
    kinds = [region.kind for region in detection.regions]
    assert kinds.count(PLANAR) == 6 and kinds.count(SPHERICAL) == 8
    assert len(detection.umbilics) == 0
    assert detection.index_sum == 2.0
    for region in detection.regions:
        if region.kind == PLANAR:
            assert region.area == pytest.approx(1.2**2, rel=0.15)
        else:
            assert region.curvature == pytest.approx(1 / 0.4, rel=0.05)


@pytest.mark.once
@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_detect_the_caps_of_a_cylinder(noise):
    vertices, triangles = capped_cylinder()
    edges = np.linalg.norm(np.diff(vertices[triangles[:, :2]], axis=1), axis=2)
    vertices = vertices + np.random.default_rng(0).normal(
        scale=noise * np.median(edges), size=vertices.shape
    )
    detection = core.detect(vertices, triangles)
    assert len(detection.umbilics) == 0
    caps = [region for region in detection.regions if region.kind == PLANAR]
    assert len(caps) == 2
    for region in caps:
        assert region.index == 1.0
        assert region.area == pytest.approx(np.pi, rel=0.02)
    # Without noise the wall is a face of a tessellated part, too.
    walls = [region for region in detection.regions if region.kind != PLANAR]
    assert [region.kind for region in walls] == (["cylindrical"] if noise == 0.0 else [])
    for region in walls:
        assert region.index == 0.0
        assert region.curvature == pytest.approx(0.5, rel=0.01)
        assert region.area == pytest.approx(4 * np.pi, rel=0.02)


@pytest.mark.once
@pytest.mark.parametrize(
    "surface, umbilics",
    [
        (torus(), 0),
        (cylinder(), 0),
        (ellipsoid(subdivisions=2), 4),
        (ellipsoid(subdivisions=5), 4),
        (random_ellipsoid(400), 4),
        (random_ellipsoid(6000, (1.02, 1.0, 0.98)), 4),
        (noisy(ellipsoid(subdivisions=4), 0.02), 4),
        (noisy(random_ellipsoid(4000), 0.05), 4),
        (quartic(4), None),
        (seed_patch(5400), 3),
    ],
    ids=lambda value: getattr(value, "name", str(value)),
)
def test_umbilic_points_are_no_regions(surface, umbilics):
    detection = core.detect(surface.vertices, surface.triangles)
    assert len(detection.regions) == 0
    assert umbilics is None or len(detection.umbilics) == umbilics


def test_a_region_has_the_normals_of_its_shape():
    """Two of a box's sides, and its whole, are no plane and no sphere; a ball's cap is."""
    vertices, triangles = rounded_cube(20, 0.05)
    surface = clean(vertices, triangles)[0]
    ones = np.ones(len(surface.vertices))
    everything = find_regions(surface, 0 * ones, ones, 0.1 * ones, 2, 0 * ones)
    assert everything.count == 0
    side = np.where(surface.vertices[:, 2] > 0.99, 0.0, 1.0)
    found = find_regions(surface, side, 0.01 * ones, 0.1 * ones, 2, 0 * ones)
    assert found.count == 1
    assert (surface.face_normal_area[0][found.label == 0, 2] > 0.9).all()
    ball = clean(*icosphere(3))[0]
    ones = np.ones(len(ball.vertices))
    assert find_regions(ball, 0 * ones, 0.01 * ones, 0.1 * ones, 2, ones).count == 1
    assert find_regions(ball, 0 * ones, 0.01 * ones, 0.1 * ones, 2, 5 * ones).count == 1
    assert find_regions(ball, 0 * ones, 0.01 * ones, 0.1 * ones, 2, -ones).count == 0


@pytest.mark.once
@pytest.mark.parametrize("noise", [0.0, 0.01])
def test_the_ends_of_a_capsule_keep_to_themselves(noise):
    """Hemispheres joined by long quads, in whose corners fits see hemispheres."""
    theta = np.pi * np.arange(1, 32)[:, None] / 32
    phi = 2 * np.pi * np.arange(64) / 64
    up = np.cos(theta) + np.sign(16 - np.arange(1, 32))[:, None] * 1.5
    rings = [np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), up + 0 * phi]
    points = np.stack(rings, axis=2).reshape(-1, 3)
    vertices = np.concatenate([[[0, 0, 2.5]], points, [[0, 0, -2.5]]])
    j = np.arange(64)
    k = (j + 1) % 64
    triangles = [np.stack([0 * j, 1 + j, 1 + k], axis=1)]
    for ring in range(30):
        one, two = 1 + 64 * ring, 65 + 64 * ring
        triangles += [
            np.stack([one + j, two + j, two + k], axis=1),
            np.stack([one + j, two + k, one + k], axis=1),
        ]
    triangles.append(np.stack([0 * j + len(vertices) - 1, 1 + 64 * 30 + k, 1 + 64 * 30 + j], 1))
    triangles = np.concatenate(triangles)
    vertices = vertices + np.random.default_rng(0).normal(scale=0.1 * noise, size=vertices.shape)
    detection = core.detect(vertices, triangles)
    caps = [region for region in detection.regions if region.kind == SPHERICAL]
    assert len(caps) == 2
    for region in caps:
        along = np.ptp(vertices[triangles[region.triangles]][:, :, 2], axis=1)
        assert (along < 1.0).all()
        assert region.area == pytest.approx(2 * np.pi * 0.902, rel=0.05)


def test_two_triangles_are_one_set_whichever_sides_they_share():
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]])
    for turn in range(3):
        for other in range(3):
            pair = [np.roll([0, 1, 2], turn), np.roll([2, 1, 3], other)]
            surface = clean(corners, np.array(pair))[0]
            found = find_regions(surface, *np.zeros((2, 4)), np.full(4, 0.01))
            assert found.count == 1
            assert found.label.tolist() == [0, 0]
            none = RegionMap.none(surface)
            assert (none.label.tolist(), none.count) == ([-1, -1], 0)


def test_beside_exact_faces_what_is_left_of_the_regions_stays():
    face = np.array([0, 0, -1, -1, -1, 1], np.int32)
    nothing = np.zeros(2)
    faces = Tessellation(30.0, face, (PLANAR, SPHERICAL), nothing, np.zeros((2, 3)))
    # The first region lies on a face alone; the second and third beside.
    found = RegionMap(np.array([0, -1, 1, 2, -1, 2], np.int32), 3)
    both = with_faces(faces, found)
    assert both.label.tolist() == [0, 0, 2, 3, -1, 1]
    assert both.count == 4
    assert with_faces(faces, RegionMap(np.full(6, -1, np.int32), 0)).label.tolist() == face.tolist()


@pytest.mark.once
def test_a_region_has_the_places_of_its_shape(monkeypatch):
    """What hides in the noise of curvatures shows in the places of the points."""
    points, triangles = icosphere(4)
    random = np.random.default_rng(0)

    def off(vertices, triangles, scatter):
        surface = clean(vertices, triangles)[0]
        scatter = np.full(len(surface.vertices), scatter / surface.unit)
        rows = [np.arange(len(surface.triangles))]
        return standing_off(surface, rows, 3, scatter)[0]

    shift = 0.01 * random.normal(size=points.shape)
    assert not off(points + shift, triangles, 0.01)
    assert not off(points, triangles, 0.0)
    # The median of noise is 0.67 of its deviation: 1.0 and 1.5 of these.
    assert not off(points + shift, triangles, 0.0067)
    assert off(points + shift, triangles, 0.0045)
    barrel = points * (1.0, 1.0, 0.9)
    assert off(barrel + shift, triangles, 0.01)
    # Where the noise is that large, or unknown, a barrel is not told from a sphere.
    assert not off(barrel + shift, triangles, 0.1)
    assert not off(barrel, triangles, np.nan)
    flat = plane(cells=40)
    bumps = 0.02 * random.normal(size=len(flat.vertices))[:, None] * (0.0, 0.0, 1.0)
    assert not off(flat.vertices + bumps, flat.triangles, 0.02)
    assert off(flat.vertices + bumps, flat.triangles, 0.005)
    # And is asked of what is found: such a region is none.
    rough = noisy(sphere(subdivisions=4), 0.05)
    assert core.detect(rough.vertices, rough.triangles).regions
    monkeypatch.setattr(round_shapes, "STANDS_OFF", 0.3)
    assert not core.detect(rough.vertices, rough.triangles).regions
