"""Faces that pass through each other, at once and asked for place by place."""

import numpy as np
from quad_surfaces import bumpy
from surfaces import sphere

from core.mesh.mending.repair import clean
from core.retopology.quads.finishing.faults.crossings import OwnCrossings, crossings


def two_spheres():
    """Two that pass through each other in a circle, as one surface."""
    one = sphere(subdivisions=2)
    away = np.array([1.0, 0.02, 0.03])
    vertices = np.concatenate([one.vertices, one.vertices + away])
    surface, _ = clean(vertices, np.concatenate([one.triangles, one.triangles + len(one.vertices)]))
    return surface, vertices


def test_crossings_are_told_of_the_places_that_they_reach_whatever_was_asked_before():
    surface, vertices = two_spheres()
    corner = surface.vertices[surface.triangles] * surface.unit + surface.origin
    middle = corner.mean(axis=1)
    widest = np.linalg.norm(corner - middle[:, None], axis=2).max()
    pairs = crossings(surface.vertices, surface.triangles)
    own, random = OwnCrossings(surface), np.random.default_rng(0)
    places = random.permutation(vertices)[:50]
    places = places + 0.05 * random.normal(size=places.shape)
    for reach in (0.0, 0.3):
        told = [own.beside(place[None], np.array([reach]))[0] for place in places]
        near = np.linalg.norm(middle - places[:, None], axis=2) <= reach + widest
        # Both triangles of a crossing reach into the ball.
        expected = near[:, pairs].all(axis=2).any(axis=1)
        assert told == expected.tolist()
        assert 0.1 < np.mean(told) < 0.9


def test_crossing_faces_are_found():
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    upright = square[:, [2, 0, 1]] + [0.5, 0.25, -0.5]
    both = np.concatenate([square, upright])
    quads = np.arange(8).reshape(2, 4)
    assert crossings(both, quads).tolist() == [[0, 1]]
    assert not len(crossings(both + (np.arange(8) > 3)[:, None] * [0.0, 0.0, 0.6], quads))
    vertices, triangles = bumpy(0, level=3)
    assert not len(crossings(vertices, triangles))
