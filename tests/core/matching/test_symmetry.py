"""The mirror plane of shapes whose planes are known."""

import dataclasses
import itertools

import numpy as np
import pytest
from scipy.spatial import ConvexHull
from surfaces import ellipsoid, sphere
from surfaces.sampling import icosphere, outward

import core
from core.matching.mirror_planes import mirrored_pairs, proposed_planes


def mirror(vertices, triangles):
    detection = core.detect(vertices, triangles)
    return core.Guide(vertices, triangles, detection).symmetry()


def egg(subdivisions=5):
    """A lopsided ellipsoid: only y -> -y maps it onto itself."""
    points, triangles = icosphere(subdivisions)
    return lopsided(points), triangles


def lopsided(points):
    x, y, z = (points * (3.0, 2.0, 1.0)).T
    return np.stack([x + 0.15 * x**2, y, z * (1 + 0.1 * x) + 0.05 * x**2], axis=1)


def turned(angle):
    a, b = np.cos(angle), np.sin(angle)
    return np.array([[a, -b, 0], [b, a, 0], [0, 0, 1]]) @ np.array(
        [[1, 0, 0], [0, a, -b], [0, b, a]]
    )


@pytest.mark.once
@pytest.mark.parametrize("angle", [0.0, 0.7, 2.5])
def test_the_one_plane_is_found_wherever_it_is(angle):
    vertices, triangles = egg()
    turn, shift = turned(angle), np.array([5.0, -2.0, 1.0])
    plane = mirror(vertices @ turn.T + shift, triangles)
    wanted = turn @ (0.0, 1.0, 0.0)
    assert abs(plane.normal @ wanted) > 1 - 1e-6
    assert abs((plane.point - shift) @ wanted) < 1e-3
    assert plane.score > 0.95
    assert len(plane.pairs)


@pytest.mark.once
@pytest.mark.parametrize("coarse", [2, 4])
def test_halves_of_unlike_triangles_do_not_move_the_plane(coarse):
    # The larger its triangles the deeper a mesh lies inside a rounded surface.
    random = np.random.default_rng(coarse)
    points = random.normal(size=(8000, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    points = points[(points[:, 1] > 0.0) | (np.arange(8000) % coarse == 0)]
    triangles = outward(points, ConvexHull(points).simplices.astype(np.int64))
    plane = mirror(lopsided(points), triangles)
    assert np.degrees(np.arccos(min(abs(plane.normal[1]), 1.0))) < 3.0 * plane.angle_error
    assert abs(plane.point[1]) < 3.0 * plane.offset_error


@pytest.mark.once
def test_random_meshes_do_not_need_matching_vertices():
    points = np.random.default_rng(2).normal(size=(15000, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    triangles = outward(points, ConvexHull(points).simplices.astype(np.int64))
    plane = mirror(lopsided(points), triangles)
    assert np.degrees(np.arccos(min(abs(plane.normal[1]), 1.0))) < 0.5
    assert abs(plane.point[1]) < 0.01


def half_anew(vertices, triangles, seed, noise):
    """The half y > 0 moved along the surface and up from it, as another scan of it would be."""
    random = np.random.default_rng(seed)
    upper = vertices[:, 1] > 0.05
    corner = vertices[triangles]
    weight = random.dirichlet((1.0, 1.0, 1.0), len(triangles))
    some = np.zeros(len(vertices), int)
    some[triangles.ravel()] = np.repeat(np.arange(len(triangles)), 3)
    inside = np.einsum("tk,tkc->tc", weight, corner)[some]
    edge = np.linalg.norm(corner[:, 0] - corner[:, 1], axis=1).mean()
    moved = 0.7 * vertices + 0.3 * inside + noise * edge * random.normal(size=vertices.shape)
    return np.where(upper[:, None], moved, vertices)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 3, 4])
def test_a_half_on_other_points_leaves_the_plane_within_its_stated_error(seed):
    vertices, triangles = egg()
    plane = mirror(half_anew(vertices, triangles, seed, 0.03), triangles)
    tilt = np.degrees(np.arccos(min(abs(plane.normal[1]), 1.0)))
    assert tilt < 4.0 * plane.angle_error
    assert plane.angle_error < 0.3
    assert abs(plane.point[1]) < 4.0 * plane.offset_error + 1e-3


@pytest.mark.parametrize("angle", [0.0, 0.7, 2.5])
def test_umbilics_propose_the_plane_that_mirrors_them(angle):
    vertices, triangles = egg(4)
    turn, shift = turned(angle), np.array([5.0, -2.0, 1.0])
    vertices = vertices @ turn.T + shift
    umbilics = core.detect(vertices, triangles).umbilics
    wanted = turn @ (0.0, 1.0, 0.0)
    planes = proposed_planes(umbilics, 6.0)
    assert max(abs(normal @ wanted) for normal, _ in planes) > 0.999
    # Not between umbilics of unlike curvature.
    unlike = dataclasses.replace(umbilics, curvature=2.0 ** np.arange(len(umbilics)))
    assert proposed_planes(unlike, 6.0) == []


def test_a_plane_is_proposed_once():
    mesh = ellipsoid(subdivisions=4)
    umbilics = core.detect(mesh.vertices, mesh.triangles).umbilics
    planes = proposed_planes(umbilics, 6.0)
    assert len(planes) >= 2
    # Of four umbilics two pairs each lie across one plane.
    for one, two in itertools.combinations(planes, 2):
        assert abs(one[0] @ two[0]) < 0.98


def test_an_ellipsoid_has_one_of_its_planes():
    mesh = ellipsoid()
    plane = mirror(mesh.vertices, mesh.triangles)
    assert np.abs(plane.normal).max() > 1 - 1e-6


def test_without_umbilics_there_is_a_reason():
    mesh = sphere(subdivisions=3)
    with pytest.raises(core.GuidanceError, match="Too few umbilics"):
        mirror(mesh.vertices, mesh.triangles)


@pytest.mark.slow
def test_what_is_not_symmetric_has_no_plane():
    vertices, triangles = egg()
    x, y, z = vertices.T
    skew = np.stack([x + 0.2 * y * z, y * (1 + 0.12 * x) + 0.1 * y**2, z + 0.25 * x * y], axis=1)
    with pytest.raises(core.GuidanceError):
        mirror(skew, triangles)


def test_a_kind_that_is_open_has_its_mirror_image():
    surface = ellipsoid(subdivisions=3)
    found = core.detect(surface.vertices, surface.triangles).umbilics
    across = found.position[:, 0] > 0.0
    half = dataclasses.replace(found, kind=np.where(across, "uncertain", found.kind))
    for umbilics, pairs in ((found, 2), (half, 2)):
        assert len(mirrored_pairs(umbilics, np.array([1.0, 0.0, 0.0]), 0.0, 0.1)) == pairs
        normals = np.array([normal for normal, _ in proposed_planes(umbilics, 6.0)])
        assert (np.abs(normals[:, 0]) > 0.99).any()
    # Of another index nothing is an image.
    other = dataclasses.replace(half, index=np.where(across, -0.5, 0.5))
    assert len(mirrored_pairs(other, np.array([1.0, 0.0, 0.0]), 0.0, 0.1)) == 0
