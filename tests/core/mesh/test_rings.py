"""Rings around vertices and triangles: each vertex once that a walk of so many edges reaches."""

import numpy as np
import pytest
import surfaces
from scipy.sparse import csgraph

from core.mesh import rings
from core.mesh.mending.repair import clean
from core.mesh.rings import adjacency, grow, selection

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
