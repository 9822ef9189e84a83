"""The merge tree against sublevel sets grown one vertex at a time."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from surfaces import random_points

from core.mesh.mending.repair import clean
from core.mesh.surface import Surface
from core.umbilics.pairing.merge_tree import label_roots, merge_tree


class _Sets:
    """Disjoint sets, and the lowest level at which two members came together."""

    def __init__(self, count: int) -> None:
        self.member = [{i} for i in range(count)]
        self.level = np.full((count, count), np.inf)

    def join(self, one: int, two: int, level: float) -> None:
        mine, yours = self.member[one], self.member[two]
        if mine is yours:
            return
        for i in mine:
            for j in yours:
                self.level[i, j] = self.level[j, i] = level
        mine |= yours
        for j in yours:
            self.member[j] = mine


def _levels(surface: Surface, gap: np.ndarray, triangle: np.ndarray, regions: list) -> np.ndarray:
    """(k, k) gap at which the sublevel sets around two umbilics join, by the definition."""
    n, k = len(gap), len(triangle)
    sets = _Sets(n + k + len(regions))
    edges = []
    for i in range(n):
        for j in surface.neighbours[surface.neighbour_start[i] : surface.neighbour_start[i + 1]]:
            edges.append((max(gap[i], gap[j]), i, int(j)))
    for number, rows in enumerate([*([row] for row in triangle), *regions]):
        edges += [(gap[i], int(i), n + number) for i in np.unique(surface.triangles[rows])]
    for level, i, j in sorted(edges):
        sets.join(i, j, level)
    return sets.level[n : n + k, n : n + k]


@given(st.integers(4, 30), st.integers(0, 10_000), st.booleans(), st.sampled_from([3, 10**6]))
@settings(max_examples=60, deadline=None)
def test_umbilics_join_where_sublevel_sets_do(count, seed, with_region, values):
    random = np.random.default_rng(seed)
    points, triangles = random_points(count, (0, 0), (1, 1), seed)
    surface = clean(np.column_stack([points, np.zeros(count)]), triangles)[0]
    # Few different values make many ties.
    gap = random.integers(0, values, len(surface.vertices)) / 7.0
    m = len(surface.triangles)
    triangle = random.permutation(m)[: random.integers(1, min(m, 9))]
    regions = [np.setdiff1d(random.integers(0, m, 3), triangle)] if with_region and m > 9 else []
    regions = [rows for rows in regions if len(rows)]
    k = len(triangle)
    low, high, saddle = merge_tree(surface, gap, triangle, np.ones(k, dtype=bool), regions)
    assert len(low) == k - 1
    assert (np.diff(saddle) >= 0).all()
    sets = _Sets(k)
    for one, two, level in zip(low, high, saddle, strict=True):
        sets.join(one, two, level)
    expected = _levels(surface, gap, triangle, regions)
    apart = ~np.eye(k, dtype=bool)
    assert np.array_equal(sets.level[apart], expected[apart])


def test_roots_are_numbered():
    number, count = label_roots(np.array([1, 1, 1, 4, 4, 3], dtype=np.int32))
    assert number.tolist() == [0, 0, 0, 1, 1, 1]
    assert count == 2
