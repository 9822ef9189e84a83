"""Smooth surfaces out of control meshes of triangles, as modelling programs make them."""

from __future__ import annotations

import numpy as np


def loop_subdivided(vertices: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """One level of Loop's scheme (1987, Smooth Subdivision Surfaces Based on Triangles), borders as
    cubic splines of their own."""
    n = len(vertices)
    sides = np.sort(np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)]), axis=1)
    edges, of = np.unique(sides, axis=0, return_inverse=True)
    of = of.ravel()
    across = np.zeros((len(edges), 3))
    np.add.at(across, of, vertices[np.concatenate([triangles[:, (k + 2) % 3] for k in range(3)])])
    inner = (np.bincount(of) == 2)[:, None]
    ends = vertices[edges].sum(axis=1)
    middle = np.where(inner, 0.375 * ends + 0.125 * across, 0.5 * ends)
    valence = np.bincount(edges.ravel(), minlength=n)
    around, along = np.zeros((2, n, 3))
    rim = edges[~inner[:, 0]]
    for one, other in ((0, 1), (1, 0)):
        np.add.at(around, edges[:, one], vertices[edges[:, other]])
        np.add.at(along, rim[:, one], vertices[rim[:, other]])
    count = np.maximum(valence, 1)
    share = (0.625 - (0.375 + 0.25 * np.cos(2 * np.pi / count)) ** 2) / count
    moved = (1.0 - valence * share)[:, None] * vertices + share[:, None] * around
    border = np.zeros(n, bool)
    border[rim] = True
    moved[border] = 0.75 * vertices[border] + 0.125 * along[border]
    ab, bc, ca = (n + of.reshape(3, -1))
    a, b, c = triangles.T
    four = (a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)
    return np.concatenate([moved, middle]), np.concatenate([np.stack(one, axis=1) for one in four])
