"""Samples lie on the surface that triangles stand for."""

import numpy as np
import pytest
from surfaces.sampling import icosphere

from core.mesh.samples import points_at, spread_points


def normals_and_areas(vertices, triangles):
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    length = np.linalg.norm(across, axis=1)
    return across / length[:, None], 0.5 * length


@pytest.mark.parametrize("subdivisions", [2, 3])
def test_samples_of_a_sphere_lie_on_it(subdivisions):
    vertices, triangles = icosphere(subdivisions)
    surface = normals_and_areas(vertices, triangles)
    random = np.random.default_rng(0)
    points, normals = spread_points(vertices, triangles, surface, 2000, random)
    chord = np.mean(1.0 - np.linalg.norm(vertices[triangles].mean(axis=1), axis=1))
    off = np.linalg.norm(points, axis=1) - 1.0
    assert abs(off.mean()) < 0.05 * chord
    assert np.abs(off).max() < 0.3 * chord
    assert np.einsum("sc,sc->s", points, normals).min() > 0.999


def test_a_saddle_is_met_from_both_sides():
    side = np.linspace(-1.0, 1.0, 12)
    x, y = (grid.ravel() for grid in np.meshgrid(side, side, indexing="ij"))
    vertices = np.stack([x, y, 0.2 * (x * x - y * y)], axis=1)
    corner = np.arange(121).reshape(11, 11) + np.arange(11)[:, None]
    triangles = np.concatenate(
        [np.stack([corner, corner + 12, corner + 13], axis=-1).reshape(-1, 3),
         np.stack([corner, corner + 13, corner + 1], axis=-1).reshape(-1, 3)]
    )  # fmt: skip
    inner = np.flatnonzero((np.abs(vertices[triangles][..., :2]) < 0.8).all(axis=(1, 2)))
    weights = np.random.default_rng(1).dirichlet((1.0, 1.0, 1.0), len(inner))
    surface = normals_and_areas(vertices, triangles)
    points, _ = points_at(vertices, triangles, surface, inner, weights)
    flat = np.einsum("sk,skc->sc", weights, vertices[triangles[inner]])

    def above(places):
        return places[:, 2] - 0.2 * (places[:, 0] ** 2 - places[:, 1] ** 2)

    assert np.abs(above(points)).max() < 0.1 * np.abs(above(flat)).max()


def test_flat_sides_and_sharp_edges_stay_as_they_are():
    corners = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
    triangles = np.array(
        [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
         [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
    )  # fmt: skip
    surface = normals_and_areas(corners, triangles)
    points, normals = spread_points(corners, triangles, surface, 500, np.random.default_rng(0))
    assert np.abs(np.abs(points - 0.5).max(axis=1) - 0.5).max() < 1e-12
    assert np.abs(np.abs(normals).max(axis=1) - 1.0).max() < 1e-12
