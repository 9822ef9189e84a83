"""Surfaces cut out of a grid: the errors of such meshes are shared by neighbours."""

from __future__ import annotations

from itertools import permutations

import numpy as np

from .implicit import ImplicitSurface


def marching_tetrahedra(surface: ImplicitSurface, cells: int) -> tuple[np.ndarray, np.ndarray]:
    """The zero set of f on a grid, linear on the six tetrahedra of each cell; wound outwards."""
    side = np.linspace(-surface.half, surface.half, cells + 1)
    grid = np.stack(np.meshgrid(side, side, side, indexing="ij"), axis=-1)
    # Off the planes of symmetry.
    points = grid.reshape(-1, 3) + 0.137 * (side[1] - side[0])
    value = surface.values(points)
    number = np.arange(len(points)).reshape([cells + 1] * 3)
    corner = number[:-1, :-1, :-1].ravel()
    step = np.array([(cells + 1) ** 2, cells + 1, 1])
    # From the first corner of each cell to the opposite one along its sides, in any order.
    tetrahedra = np.concatenate(
        [corner[:, None] + np.cumsum([0, *step[list(order)]]) for order in permutations(range(3))]
    )
    inside = value[tetrahedra] < 0
    count = inside.sum(axis=1)
    sides: list[np.ndarray] = []
    for wanted in (1, 2, 3):
        some = tetrahedra[count == wanted]
        first = np.argsort(~inside[count == wanted], axis=1, kind="stable")
        a, b, c, d = np.take_along_axis(some, first, axis=1).T
        if wanted == 1:
            sides.append(np.stack([[a, b], [a, c], [a, d]]))
        elif wanted == 3:
            sides.append(np.stack([[a, d], [b, d], [c, d]]))
        else:
            sides.append(np.stack([[a, c], [a, d], [b, d]]))
            sides.append(np.stack([[a, c], [b, d], [b, c]]))
    pairs = np.sort(np.concatenate(sides, axis=2), axis=1).transpose(2, 0, 1).reshape(-1, 2)
    unique, place = np.unique(pairs, axis=0, return_inverse=True)
    low, high = value[unique].T
    share = (low / (low - high))[:, None]
    vertices = (1 - share) * points[unique[:, 0]] + share * points[unique[:, 1]]
    triangles = place.reshape(-1, 3)
    a, b, c = vertices[triangles].transpose(1, 0, 2)
    outward = surface.jet((a + b + c) / 3).gradient
    inwards = np.einsum("ij,ij->i", np.cross(b - a, c - a), outward) < 0
    triangles[inwards] = triangles[inwards][:, ::-1]
    return vertices, triangles
