"""Shapes found again by their umbilics: in other scans, among others, in themselves."""

from functools import cache

import numpy as np
import pytest
from surfaces.sampling import icosphere, outward

import core
from core.matching.align import align
from core.matching.closest_points import rotation_by
from core.matching.identify import identify
from core.matching.rotation import axis_and_angle, find_rotation
from core.matching.shape import Shape


def blob(seed, count=5000):
    """A smooth closed shape without symmetry, another for each seed, on points of its own."""
    random = np.random.default_rng(seed)
    waves = random.normal(size=(12, 3))
    heights, phases = random.normal(size=12) * 0.06, random.uniform(0.0, 6.3, 12)
    points, triangles = random_sphere(count, seed)
    radius = 1.0 + np.cos(points @ waves.T * 2.0 + phases) @ heights
    return points * radius[:, None] * (1.6, 1.2, 1.0), triangles


def random_sphere(count, seed):
    from scipy.spatial import ConvexHull

    points = np.random.default_rng(seed).normal(size=(count, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    return points, outward(points, ConvexHull(points).simplices.astype(np.int64))


def shape(vertices, triangles):
    return Shape.of(vertices, triangles, core.detect(vertices, triangles))


@cache
def known(seed):
    return shape(*blob(seed))


def scan(seed, *, noise=0.0, missing=0.0, scale=1.0):
    """The blob on another mesh, rougher, in part, larger and elsewhere: its shape and motion."""
    random = np.random.default_rng(100 + seed)
    # The surface is that of the seed, the points are not.
    points, triangles = icosphere(5)
    points = points @ rotation_by(random.normal(size=3)).T
    random_waves = np.random.default_rng(seed)
    waves = random_waves.normal(size=(12, 3))
    heights, phases = random_waves.normal(size=12) * 0.06, random_waves.uniform(0.0, 6.3, 12)
    radius = 1.0 + np.cos(points @ waves.T * 2.0 + phases) @ heights
    vertices = points * radius[:, None] * (1.6, 1.2, 1.0)
    edge = np.linalg.norm(vertices[triangles[:, 0]] - vertices[triangles[:, 1]], axis=1).mean()
    rough = vertices + noise * edge * random.normal(size=vertices.shape)
    if missing:
        height = (vertices @ (0.3, 0.9, 0.3))[triangles].mean(axis=1)
        triangles = triangles[height > np.quantile(height, missing)]
    turn, shift = rotation_by(2.0 * random.normal(size=3)), random.normal(size=3) * 3.0
    return shape(scale * rough @ turn.T + shift, triangles), turn, vertices, scale, shift


CASES = {
    "pose": {},
    "noise": {"noise": 0.05},
    "missing parts": {"missing": 0.4},
    "noise and missing parts": {"noise": 0.05, "missing": 0.3},
    "scale": {"scale": 2.7},
    "all of it": {"noise": 0.05, "missing": 0.3, "scale": 0.4},
}


@pytest.mark.parametrize("name", CASES)
def test_a_scan_is_brought_onto_the_shape_within_the_stated_error(name):
    moved, turn, vertices, scale, shift = scan(3, **CASES[name])
    other = known(3)
    found = align(moved, other, scaled=scale != 1.0)
    matrix = found.matrix[:3, :3]
    left = matrix / found.scale @ turn
    angle = np.degrees(axis_and_angle(left)[1])
    assert angle < 4.0 * found.rotation_error + 0.02
    assert found.scale * scale == pytest.approx(1.0, abs=2e-3)
    exact = (scale * vertices @ turn.T + shift) @ matrix.T + found.matrix[:3, 3]
    apart = np.linalg.norm(exact - vertices, axis=1)
    assert np.sqrt(np.mean(apart**2)) < 2e-3 * other.size
    assert found.overlap > 0.9
    assert found.score > 0.8


def test_the_same_object_is_found_among_others():
    others = [known(seed) for seed in (3, 4, 5)]
    moved = scan(4, noise=0.03, missing=0.2, scale=1.7)[0]
    found = identify(moved, others)
    assert found[1].score > 0.8
    assert found[0] is None or found[0].score < 0.4
    assert found[2] is None or found[2].score < 0.4


def test_another_shape_is_refused():
    with pytest.raises(core.MatchError):
        align(known(4), known(5))


def test_a_shape_without_umbilics_is_refused():
    from surfaces import torus

    mesh = torus()
    with pytest.raises(core.MatchError, match="Too few umbilics"):
        align(shape(mesh.vertices, mesh.triangles), known(3))


def test_a_mirror_image_is_another_shape():
    vertices, triangles = blob(3)
    mirrored = shape(vertices * (-1.0, 1.0, 1.0), triangles[:, ::-1])
    with pytest.raises(core.MatchError):
        align(mirrored, known(3))


def star(order, count=6000, seed=1, dent=0.0):
    """A closed shape with a rotation symmetry of that order alone, about z, on random points."""
    points, triangles = random_sphere(count, seed)
    x, y, z = points.T
    around = ((x + 1j * y) ** order).real + 0.5 * z * ((x + 1j * y) ** order).imag
    radius = 1.0 + 0.12 * around + 0.15 * z + 0.1 * z**3
    radius -= dent * np.exp(-20.0 * ((x - 0.8) ** 2 + (y - 0.4) ** 2 + (z - 0.4) ** 2))
    return points * radius[:, None] * (1.0, 1.0, 0.7), triangles


@pytest.mark.parametrize("order", [2, 3, 5])
def test_the_axis_and_its_order_are_found_wherever_it_is(order):
    vertices, triangles = star(order)
    turn, shift = rotation_by(np.array([0.7, -1.1, 0.4])), np.array([3.0, -2.0, 5.0])
    found = find_rotation(shape(vertices @ turn.T + shift, triangles))
    assert found.order == order
    tilt = np.degrees(np.arccos(min(abs(found.axis @ turn[:, 2]), 1.0)))
    assert tilt < 4.0 * found.axis_error + 0.05
    off = np.cross(found.point - shift, turn[:, 2])
    assert np.linalg.norm(off) < 2e-3
    assert found.score > 0.8
    assert len(found.pairs)


def test_a_dent_in_one_sector_does_not_hide_the_symmetry():
    found = find_rotation(shape(*star(3, dent=0.1)))
    assert found.order == 3
    assert abs(found.axis[2]) > np.cos(np.radians(0.2))


def test_what_has_no_rotation_symmetry_is_refused():
    with pytest.raises(core.MatchError, match="onto itself"):
        find_rotation(known(3))
