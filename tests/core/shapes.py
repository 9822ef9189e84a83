"""Shapes with edges, for tests of features and ridges."""

import numpy as np
from surfaces import icosphere


def cube(cells=8):
    """A cube with sharp edges, each face a grid."""
    points, triangles = [], []
    t = np.linspace(-1, 1, cells + 1)
    u, v = (side.ravel() for side in np.meshgrid(t, t))
    i, j = (side.ravel() for side in np.meshgrid(np.arange(cells), np.arange(cells)))
    a = j * (cells + 1) + i
    quads = np.stack([a, a + 1, a + cells + 2, a + cells + 1], axis=1)
    for axis in range(3):
        for sign in (-1.0, 1.0):
            face = np.zeros((len(u), 3))
            face[:, axis], face[:, (axis + 1) % 3], face[:, (axis + 2) % 3] = sign, u, v
            corners = quads if sign > 0 else quads[:, ::-1]
            first = sum(map(len, points))
            triangles += [first + corners[:, [0, 1, 2]], first + corners[:, [0, 2, 3]]]
            points.append(face)
    points = np.concatenate(points)
    _, keep, new = np.unique(points.round(9), axis=0, return_index=True, return_inverse=True)
    return points[keep], new.ravel()[np.concatenate(triangles)]


def rounded_box(subdivisions, power=6):
    points, triangles = icosphere(subdivisions)
    turn, _ = np.linalg.qr(np.array([[2.0, 0.3, 0.5], [-0.2, 3.0, 0.7], [0.4, -0.6, 1.5]]))
    points = points @ turn
    return points / ((points**power).sum(axis=1) ** (1 / power))[:, None], triangles
