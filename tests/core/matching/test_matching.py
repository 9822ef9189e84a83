"""Shapes found again by their umbilics: in other scans, among others, in themselves."""

from functools import cache

import numpy as np
import pytest
from surfaces import torus
from surfaces.blobs import blob, random_sphere, star
from surfaces.sampling import icosphere

import core
from core.matching.closest_points import rotation_by
from core.matching.rotation import axis_and_angle


def shape(vertices, triangles):
    return core.Shape.of(vertices, triangles, core.detect(vertices, triangles))


@cache
def known(seed):
    points, triangles = random_sphere(2500, seed)
    return shape(blob(points, seed), triangles)


def scan(seed, *, noise=0.0, missing=0.0, scale=1.0):
    """The blob on another mesh, rougher, in part, larger and elsewhere; its shape, and the turn,
    the true vertices and the shift of it."""
    random = np.random.default_rng(100 + seed)
    points, triangles = icosphere(4)
    vertices = blob(points @ rotation_by(random.normal(size=3)).T, seed)
    edge = np.linalg.norm(vertices[triangles[:, 0]] - vertices[triangles[:, 1]], axis=1).mean()
    rough = vertices + noise * edge * random.normal(size=vertices.shape)
    if missing:
        height = (vertices @ (0.3, 0.9, 0.3))[triangles].mean(axis=1)
        triangles = triangles[height > np.quantile(height, missing)]
    turn, shift = rotation_by(2.0 * random.normal(size=3)), random.normal(size=3) * 3.0
    return shape(scale * rough @ turn.T + shift, triangles), turn, vertices, shift


CASES = {
    "pose": {},
    "noise and missing parts": {"noise": 0.05, "missing": 0.3},
    "all of it": {"noise": 0.03, "missing": 0.3, "scale": 0.4},
}


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_a_scan_is_brought_onto_the_shape_within_the_stated_error(name):
    moved, turn, vertices, shift = scan(3, **CASES[name])
    scale = CASES[name].get("scale", 1.0)
    other = known(3)
    found = core.align(moved, other, scaled=scale != 1.0)
    matrix = found.matrix[:3, :3]
    angle = np.degrees(axis_and_angle(matrix / found.scale @ turn)[1])
    assert angle < 3.0 * found.rotation_error
    assert found.rotation_error < 0.2
    assert found.scale * scale == pytest.approx(1.0, abs=3e-3)
    exact = (scale * vertices @ turn.T + shift) @ matrix.T + found.matrix[:3, 3]
    apart = np.linalg.norm(exact - vertices, axis=1)
    assert np.sqrt(np.mean(apart**2)) < 2e-3 * other.size
    assert found.overlap > 0.9
    assert found.score > 0.6


@pytest.mark.slow
def test_the_same_object_is_found_among_others():
    moved = scan(4, noise=0.03, missing=0.2, scale=1.7)[0]
    found = core.identify(moved, [known(3), known(4), known(5)])
    assert found[1].score > 0.6
    for other in (found[0], found[2]):
        assert other is None or other.score < 0.5 * found[1].score


@pytest.mark.slow
def test_a_mirror_image_is_another_shape():
    points, triangles = random_sphere(2500, 3)
    mirrored = shape(blob(points, 3) * (-1.0, 1.0, 1.0), triangles[:, ::-1])
    with pytest.raises(core.MatchError, match="not the same"):
        core.align(mirrored, known(3))


@pytest.mark.once
def test_a_shape_without_umbilics_is_refused():
    mesh = torus(columns=60, rows=24)
    with pytest.raises(core.MatchError, match="Too few umbilics"):
        core.align(shape(mesh.vertices, mesh.triangles), known(3))


@pytest.mark.slow
@pytest.mark.parametrize("order", [2, 3, 5])
def test_the_axis_and_its_order_are_found_wherever_it_is(order):
    points, triangles = random_sphere(4000, order)
    turn, shift = rotation_by(np.array([0.7, -1.1, 0.4])), np.array([3.0, -2.0, 5.0])
    found = core.find_rotation(shape(star(points, order) @ turn.T + shift, triangles))
    assert found.order == order
    tilt = np.degrees(np.arccos(min(abs(found.axis @ turn[:, 2]), 1.0)))
    assert tilt < 3.0 * found.axis_error
    assert found.axis_error < 0.05
    assert np.linalg.norm(np.cross(found.point - shift, turn[:, 2])) < 2e-3
    assert found.score > 0.6
    assert len(found.pairs)


@pytest.mark.slow
def test_a_dent_in_one_sector_does_not_hide_the_symmetry():
    points, triangles = random_sphere(4000, 7)
    found = core.find_rotation(shape(star(points, 3, dent=0.1), triangles))
    assert found.order == 3
    assert abs(found.axis[2]) > np.cos(np.radians(0.3))


@pytest.mark.slow
def test_what_has_no_rotation_symmetry_is_refused():
    with pytest.raises(core.MatchError, match="onto itself"):
        core.find_rotation(known(3))
