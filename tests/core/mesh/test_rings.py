"""Rings around vertices and triangles: each vertex once that a walk of so many edges reaches."""

import numpy as np
import pytest
import surfaces
from scipy import sparse
from scipy.sparse import csgraph

from core.mesh import rings
from core.mesh.mending.repair import clean
from core.mesh.rings import (
    adjacency,
    by_similar_size,
    grow,
    grow_side_by_side,
    selection,
    side_by_side,
)

# Closed, and with a border.
SPHERE, PATCH = surfaces.icosphere(3), surfaces.seed_patch(300)
MESHES = {"closed": SPHERE, "open": (PATCH.vertices, PATCH.triangles)}


@pytest.mark.parametrize("most", [rings.MOST_GATHERED, 3000], ids=["at once", "in parts"])
@pytest.mark.parametrize("further", [2, rings.BY_FRONTS, 2 * rings.BY_FRONTS, 40])
@pytest.mark.parametrize("kind", MESHES)
def test_rings_hold_what_a_walk_reaches(kind, further, most, monkeypatch):
    monkeypatch.setattr(rings, "MOST_GATHERED", most)
    surface, _ = clean(*MESHES[kind])
    graph, n = adjacency(surface), len(surface.vertices)
    hops = csgraph.shortest_path(graph, unweighted=True)
    # A vertex may be named twice, as where two corners of a triangle lie in one cell.
    corners = np.concatenate([surface.triangles[:40], surface.triangles[40:50, [0, 0, 1]]])
    away = hops[corners].min(axis=1)
    seen = []
    for rows, reach in grow(selection(corners, n), graph, further):
        found = np.zeros((len(rows), n), int)
        np.add.at(found, (np.repeat(np.arange(len(rows)), np.diff(reach.indptr)), reach.indices), 1)
        np.testing.assert_array_equal(found, away[rows] <= further)
        seen.append(rows)
    np.testing.assert_array_equal(np.sort(np.concatenate(seen)), np.arange(len(corners)))
    assert (len(seen) > 1) == (most == 3000)


@pytest.mark.parametrize("most", [rings.MOST_GATHERED, 3000], ids=["at once", "in parts"])
@pytest.mark.parametrize("further", [2, 5, 40])
@pytest.mark.parametrize("kind", MESHES)
def test_rings_of_nodes_side_by_side_hold_what_a_walk_reaches(kind, further, most, monkeypatch):
    """All once, in whatever order they come; a node named twice has its rings twice."""
    monkeypatch.setattr(rings, "MOST_GATHERED", most)
    monkeypatch.setattr(rings, "SIDE_BY_SIDE", 64)
    surface, _ = clean(*MESHES[kind])
    graph, n = adjacency(surface), len(surface.vertices)
    hops = csgraph.shortest_path(graph, unweighted=True)
    nodes = np.append(np.random.default_rng(0).permutation(n), [0, 0])
    seen = []
    for rows, reach in grow_side_by_side(nodes, surface.vertices[nodes], graph, further):
        expected = hops[nodes[rows]] <= further
        np.testing.assert_array_equal(reach.toarray(), expected)
        assert len(reach.indices) == expected.sum()
        seen.append(rows)
    np.testing.assert_array_equal(np.sort(np.concatenate(seen)), np.arange(len(nodes)))


def test_points_side_by_side_follow_one_another():
    points = np.random.default_rng(0).random((5000, 3))
    order = side_by_side(points)
    np.testing.assert_array_equal(np.sort(order), np.arange(len(points)))
    in_a_row = points[order][: 19 * 256].reshape(19, 256, 3)
    assert np.ptp(in_a_row, axis=1).mean() < 0.6


@pytest.mark.parametrize("filled", [0, rings.FILLED, 1 << 30])
@pytest.mark.parametrize("most", [1, 300, 1 << 16])
def test_blocks_of_similar_size_hold_every_row_once(most, filled, monkeypatch):
    """The members of each first, and then what fills it up."""
    monkeypatch.setattr(rings, "FILLED", filled)
    random = np.random.default_rng(0)
    reach = sparse.random_array((400, 60), density=0.4, format="csr", rng=random).astype(bool)
    # One row of nothing and one of all.
    reach = sparse.vstack([reach, np.zeros((1, 60), bool), np.ones((1, 60), bool)], format="csr")
    filling = random.integers(60, 99, reach.shape[0])
    seen, wide = [], []
    for rows, members, held in by_similar_size(reach, most, filling):
        assert members.size <= most or len(rows) == 1
        for row, column, count in zip(rows, members.T, held, strict=True):
            np.testing.assert_array_equal(column[:count], reach[[row]].indices)
            assert (column[count:] == filling[row]).all()
        seen.append(rows)
        wide.append(len(members))
    expected = np.flatnonzero(np.diff(reach.indptr))
    np.testing.assert_array_equal(np.sort(np.concatenate(seen)), expected)
    if most == 1 << 16:
        different = len(set(np.diff(reach.indptr))) - 1
        assert len(wide) == {0: different, 1 << 30: 1}.get(filled, len(wide)) <= different
