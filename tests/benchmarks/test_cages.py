"""Catmull-Clark cages of the benchmark: their limit surface, and what is found on it."""

from __future__ import annotations

import numpy as np
import pytest

import core
from benchmarks import cages
from benchmarks.scoring import tally


def test_limit_of_a_grid_over_a_quadratic_has_its_curvatures():
    n, spacing = 9, 0.1
    x, y = (axis.ravel() for axis in np.meshgrid(*2 * [spacing * (np.arange(n) - 4)]))
    place = np.arange(n * n).reshape(n, n)
    corners = np.stack([place[:-1, :-1], place[:-1, 1:], place[1:, 1:], place[1:, :-1]], axis=-1)
    xx, xy, yy = 1.3, -0.7, 0.4
    height = 0.5 * (xx * x * x + 2.0 * xy * x * y + yy * y * y)
    quads = cages.Quads(np.column_stack([x, y, height]), corners.reshape(-1, 4))
    limit, field = quads.limit()
    inner = ~quads.extraordinary
    # Cubic splines take a quadratic to itself, shifted along its axis.
    assert np.ptp((limit[:, 2] - height)[inner]) < 1e-12
    p, q = xx * x + xy * y, xy * x + yy * y
    area = 1.0 + p * p + q * q
    gauss = (xx * yy - xy * xy) / area**2
    # Upwards is outwards, where a bowl is hollow.
    mean = -0.5 * ((1 + q * q) * xx - 2 * p * q * xy + (1 + p * p) * yy) / area**1.5
    assert np.abs(field.k1 * field.k2 - gauss)[inner].max() < 1e-12
    assert np.abs(0.5 * (field.k1 + field.k2) - mean)[inner].max() < 1e-12
    # Along a principal direction the normal moves by the curvature, and straight on.
    h = 1e-5
    for d, k in ((field.d1, field.k1), (field.d2, field.k2)):
        moved = _normal(x + h * d[:, 0], y + h * d[:, 1], (xx, xy, yy)) - _normal(
            x - h * d[:, 0], y - h * d[:, 1], (xx, xy, yy)
        )
        assert np.abs(moved / (2 * h) - k[:, None] * d)[inner].max() < 1e-8


def _normal(x, y, bends):
    xx, xy, yy = bends
    normal = np.column_stack([-xx * x - xy * y, -xy * x - yy * y, np.ones_like(x)])
    return normal / np.linalg.norm(normal, axis=1)[:, None]


@pytest.mark.slow
def test_umbilics_of_a_cage_are_found():
    for case in cages.cases_of(0):
        detection = core.detect(case.vertices, case.triangles)
        found = detection.umbilics
        count = tally(case, found.position, found.index, found.kind, found.certain)
        assert detection.index_sum == case.umbilics.index.sum() == 2.0
        assert count.false == 0
        assert count.kinds_wrong == 0
    # The finest level resolves most of them.
    assert count.true >= 20 and count.found == count.true


@pytest.mark.parametrize("diagonal", [0, 1])
@pytest.mark.parametrize("level", [3, 4])
def test_a_cube_s_sides_have_flat_points_and_its_corners_stars(level, diagonal):
    """However its quads are cut in two."""
    corner = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
    sides = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    cube = cages.Quads(corner, np.array(sides))
    for _ in range(level):
        cube = cube.subdivided()
    cube = cages.Quads(cube.vertices, np.roll(cube.corners, diagonal, axis=1))
    found = core.detect(cube.vertices, cube.triangles).umbilics
    places = np.concatenate([np.eye(3), -np.eye(3), corner / np.sqrt(3.0)])
    direction = found.position / np.linalg.norm(found.position, axis=1)[:, None]
    nearest = (direction @ places.T).argmax(axis=1)
    total = np.bincount(nearest, weights=found.index, minlength=14)
    assert total.tolist() == [1.0] * 6 + [-0.5] * 8
