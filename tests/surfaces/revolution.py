"""Surfaces of revolution as bare meshes: circles of umbilics where both curvatures are equal."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

VASE_CIRCLE = 0.9045569
"""|z| of the circles of umbilics of r = 2 + cos z within one period."""


def vase(z: np.ndarray) -> np.ndarray:
    """Radius r = 2 + cos z."""
    return 2.0 + np.cos(z)


def revolved(
    radius: Callable[[np.ndarray], np.ndarray],
    half: float,
    columns: int,
    rows: int,
    diagonals: str = "one",
    jitter: float = 0.0,
    seed: int = 0,
) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and triangles of a surface around the z axis, open at z = -half and half.

    `diagonals` are "one" way, "other" or "random"; `jitter` moves the vertices inside along the
    surface, by up to that share of a cell.
    """
    random = np.random.default_rng(seed)
    z = np.repeat(np.linspace(-half, half, rows + 1), columns)
    angle = np.tile(2.0 * np.pi * np.arange(columns) / columns, rows + 1)
    shift = random.uniform(-jitter, jitter, (2, len(z)))
    shift[:, :columns] = shift[:, -columns:] = 0.0
    z, angle = z + shift[0] * 2.0 * half / rows, angle + shift[1] * 2.0 * np.pi / columns
    r = radius(z)
    vertices = np.column_stack([r * np.cos(angle), r * np.sin(angle), z])
    row, column = (some.ravel() for some in np.indices((rows, columns)))
    a, b = row * columns + column, row * columns + (column + 1) % columns
    c, d = b + columns, a + columns
    turned = np.full(len(a), diagonals == "other")
    if diagonals == "random":
        turned = random.random(len(a)) < 0.5
    one = np.stack([np.column_stack([a, b, c]), np.column_stack([a, c, d])], axis=1)
    other = np.stack([np.column_stack([a, b, d]), np.column_stack([b, c, d])], axis=1)
    return vertices, np.where(turned[:, None, None], other, one).reshape(-1, 3)
