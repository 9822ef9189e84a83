"""Cells of vertices, and windows made of them."""

import dataclasses

import numpy as np
import pytest
from surfaces import ellipsoid, random_ellipsoid

from core.base.progress import Progress
from core.mesh.cells import Cells
from core.mesh.mending.repair import clean
from core.mesh.neighbourhoods import Neighbourhood
from core.mesh.rings import adjacency, spread

RINGS = 6
HELD = 1 + 3 * RINGS * (RINGS + 1)
SURFACES = {
    "even": ellipsoid((1.2, 1.1, 1.0), 5),
    "stretched": ellipsoid((6.0, 2.0, 1.0), 5),
    "random": random_ellipsoid(8000),
}


def cells_of(mesh):
    surface, _ = clean(mesh.vertices, mesh.triangles)
    middles, near = spread(adjacency(surface), 2, 3, Progress())
    return surface, middles, Cells(surface, middles, near)


@pytest.mark.parametrize("name", SURFACES)
def test_every_vertex_is_in_the_cell_of_the_nearest_middle_within_reach(name):
    surface, middles, cells = cells_of(SURFACES[name])
    assert sorted(cells.order) == list(range(len(surface.vertices)))
    assert cells.size.sum() == len(surface.vertices)
    for number, middle in enumerate(middles):
        assert middle in cells.order[cells.start[number] :][: cells.size[number]]


@pytest.mark.parametrize("name", SURFACES)
def test_windows_hold_the_nearest_vertices(name):
    """All but a few at their rims of those that a search of the whole surface finds."""
    surface, middles, cells = cells_of(SURFACES[name])
    stretch = 3.0 if name == "stretched" else 1.5
    around = Neighbourhood(surface, adjacency(surface), rings=RINGS, focused=False)
    around = dataclasses.replace(around, stretch=stretch, windows=cells)
    seen, shares = np.zeros(len(middles), int), []
    for rows, members in around.blocks(middles, 1 << 14):
        seen[rows] += 1
        assert members.shape == (HELD, len(rows))
        for row, some in zip(rows, members.T, strict=True):
            offset = surface.vertices - surface.vertices[middles[row]]
            nearest = np.argsort(np.einsum("nc,nc->n", offset, offset))[:HELD]
            assert len(set(some)) == HELD
            shares.append(len(set(some) & set(nearest)) / HELD)
    assert (seen == 1).all()
    assert np.mean(shares) > 0.93
    assert np.quantile(shares, 0.01) > 0.8


def test_a_window_holds_no_more_than_the_component():
    surface, middles, cells = cells_of(ellipsoid((1.2, 1.1, 1.0), 1))
    around = Neighbourhood(surface, adjacency(surface), rings=RINGS, stretch=1.5, windows=cells)
    for _, members in around.blocks(middles, 1 << 14):
        assert len(members) == len(surface.vertices)
