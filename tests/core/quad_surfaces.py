"""Surfaces that tests of quads share."""

import numpy as np
from surfaces import sphere

from core.mesh.mending.repair import clean
from core.retopology.quads.surface.subdivision import Triangles, split_edges


def cube(cuts=4):
    """A closed cube of right-angled triangles, its sides in `cuts` parts."""
    at = np.linspace(-1.0, 1.0, cuts + 1)
    u, v = (x.ravel() for x in np.meshgrid(at, at, indexing="ij"))
    rows = np.arange((cuts + 1) ** 2).reshape(cuts + 1, -1)
    a, b, c, d = rows[:-1, :-1], rows[1:, :-1], rows[1:, 1:], rows[:-1, 1:]
    face = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)]).reshape(-1, 3)
    vertices, triangles = [], []
    for axis in range(3):
        for side in (-1.0, 1.0):
            points = np.zeros((len(u), 3))
            points[:, axis], points[:, axis - 2], points[:, axis - 1] = side, u, v
            corners = face if side > 0 else face[:, ::-1]
            triangles.append(corners + len(vertices) * len(u))
            vertices.append(points)
    points, row = np.unique(np.concatenate(vertices).round(9), axis=0, return_inverse=True)
    return points, row.ravel()[np.concatenate(triangles)]


def bumpy(seed, level=4, waves=10):
    """A random smooth closed surface."""
    mesh = sphere(subdivisions=level)
    random = np.random.default_rng(seed)
    direction = random.normal(size=(waves, 3))
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    height = sum(
        0.12 * random.normal() * np.cos(3.0 * mesh.vertices @ axis + random.uniform(0, 6))
        for axis in direction
    )
    return mesh.vertices * np.maximum(1.0 + height, 0.3)[:, None], mesh.triangles


def uneven_box(splits=60):
    """A closed flat box of twelve large triangles, one of which is cut in small ones."""
    vertices, triangles = cube(1)
    vertices = vertices * np.array([1.0, 0.8, 0.05])
    for _ in range(splits):
        at = vertices[triangles[11:]]
        area = np.linalg.norm(np.cross(at[:, 1] - at[:, 0], at[:, 2] - at[:, 0]), axis=1)
        row = 11 + int(area.argmax())
        a, b, c = triangles[row]
        middle = len(vertices)
        vertices = np.vstack([vertices, at[row - 11].mean(axis=0)])
        cut = [[a, b, middle], [b, c, middle], [c, a, middle]]
        triangles = np.vstack([np.delete(triangles, row, axis=0), cut])
    return vertices, triangles


def with_needles(mesh, marked, gap):
    """Triangles, the `marked` edges (3 m,) of which have a vertex `gap` beside one end: a needle
    on either side, as intersections leave them."""
    twin = clean(mesh.vertices, mesh.triangles)[0].twin
    marked = marked | (marked[twin] & (twin >= 0))
    length = np.maximum(mesh.lengths, 1e-300)
    return split_edges(mesh, marked, gap / length)


def plain(vertices, triangles, feature=None):
    """A mesh as triangles on the way to be mapped."""
    count = 3 * len(triangles)
    return Triangles(
        np.asarray(vertices, float),
        np.asarray(triangles, np.int64),
        np.zeros((len(vertices), 1)),
        np.arange(len(triangles)),
        np.zeros(count, np.int8) if feature is None else feature,
    )
