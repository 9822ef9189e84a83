"""Single vertices that stick out, and what only looks like them."""

import numpy as np
import pytest
import surfaces

import core
from core.curvature.outliers import without_outliers
from core.mesh.mending.repair import clean
from core.mesh.normals import vertex_normals


def ellipsoid(level=4):
    points, triangles = surfaces.icosphere(level)
    return points * (3.0, 2.0, 1.0), triangles


def spiked(vertices, rows, height):
    """The vertices with some moved outwards by so much."""
    moved = vertices.copy()
    normal = moved[rows] / (9.0, 4.0, 1.0)
    moved[rows] += height * normal / np.linalg.norm(normal, axis=1)[:, None]
    return moved


def laid(vertices, triangles):
    """The vertices as they are looked at, in the input's units, and which of them were moved."""
    surface, _ = clean(vertices, triangles)
    after, _, moved = without_outliers(surface, vertex_normals(surface), core.Progress())
    assert (surface.source_vertex == np.arange(len(vertices))).all()
    return after.vertices * after.unit + after.origin, moved


@pytest.mark.parametrize("height", [0.3, -0.3, 0.02])
def test_spikes_are_laid_onto_the_surface(height):
    vertices, triangles = ellipsoid()
    # Two of them side by side: the larger hides the smaller at first.
    beside = triangles[1000][:2]
    rows = np.append([40, 700, 1500, 2000], beside)
    spikes = spiked(vertices, rows[:-1], height)
    spikes = spiked(spikes, rows[-1:], 0.4 * height)
    after, moved = laid(spikes, triangles)
    np.testing.assert_array_equal(moved, np.sort(rows))
    off = np.abs(np.linalg.norm(after[rows] / (3.0, 2.0, 1.0), axis=1) - 1.0)
    assert off.max() < 1e-2 * abs(height)
    np.testing.assert_allclose(np.delete(after, rows, axis=0), np.delete(spikes, rows, axis=0))


def test_spikes_make_no_umbilics():
    vertices, triangles = ellipsoid()
    clean = core.detect(vertices, triangles).umbilics
    # One of them in an umbilic's own triangle.
    rows = np.append(triangles[clean.triangle[0], 0], np.arange(20, len(vertices), 100))
    spikes = spiked(vertices, rows, 0.2)
    found = core.detect(spikes, triangles)
    assert found.umbilics.counts()["lemon"] == len(found.umbilics) == 4
    away = np.linalg.norm(found.umbilics.position[:, None] - clean.position, axis=2).min(axis=1)
    assert np.sort(away)[2] < 0.02 and away.max() < 0.2
    # Places are those of the mesh as it is.
    corners = spikes[triangles[found.umbilics.triangle]]
    on_mesh = np.einsum("rk,rkc->rc", found.umbilics.barycentric, corners)
    np.testing.assert_allclose(found.umbilics.position, on_mesh, atol=1e-9)
    said = f"stick out of the surface around them: {len(rows)}."
    assert any(said in text for text in found.warnings)


def hexagonal(height):
    """A patch of even triangles under a height over x and y, its middle vertex at the origin."""
    x, y = np.meshgrid(np.arange(-12.0, 13.0), np.arange(-12.0, 13.0))
    x, y = (x + 0.5 * y).ravel(), (np.sqrt(0.75) * y).ravel()
    a = np.arange(24 * 25).reshape(24, 25)[:, :-1].ravel()
    triangles = np.concatenate([np.stack([a, a + 1, a + 25]), np.stack([a + 1, a + 26, a + 25])], 1)
    return np.column_stack([x, y, height(x, y)]), triangles.T


@pytest.mark.parametrize(
    "height",
    [
        lambda x, y: -0.5 * np.hypot(x, y),
        lambda x, y: -2.0 * np.hypot(x, y),
        lambda x, y: -np.abs(x),
        lambda x, y: -np.maximum(np.abs(x), np.abs(y)),
        lambda x, y: 0.02 * np.random.default_rng(1).normal(size=len(x)),
    ],
    ids=["cone", "steep cone", "crease", "pyramid", "noise"],
)
def test_tips_creases_and_noise_are_no_outliers(height):
    _, moved = laid(*hexagonal(height))
    assert not len(moved)


def dome(edges):
    """A dome whose middle vertex, the last one, has so many edges and sticks out."""
    angle = 2.0 * np.pi * np.arange(edges) / edges
    r, turn = np.meshgrid(0.1 * np.arange(1, 13), angle, indexing="ij")
    points = np.stack([r * np.cos(turn), r * np.sin(turn), -(r**2)], axis=2).reshape(-1, 3)
    a = np.arange(11 * edges)
    right = a - a % edges + (a + 1) % edges
    triangles = np.concatenate(
        [
            np.stack([a, a + edges, right + edges], axis=1),
            np.stack([a, right + edges, right], axis=1),
            np.stack([right[:edges], np.full(edges, len(points)), a[:edges]], axis=1),
        ]
    )
    return np.concatenate([points, [(0.0, 0.0, 0.012)]]), triangles


@pytest.mark.parametrize("edges", [13, 64])
def test_the_middle_of_a_fan_is_no_outlier(edges):
    _, moved = laid(*dome(edges))
    assert not len(moved)


def test_twice_the_usual_edges_are_no_fan():
    vertices, triangles = dome(12)
    _, moved = laid(vertices, triangles)
    assert moved.tolist() == [len(vertices) - 1]


def test_where_much_is_rough_it_is_the_surface():
    vertices, triangles = ellipsoid(3)
    rows = np.random.default_rng(0).permutation(len(vertices))[: len(vertices) // 10]
    _, moved = laid(spiked(vertices, rows, 0.2), triangles)
    assert not len(moved)
