"""The page about features measures what it says."""

from types import SimpleNamespace

import numpy as np
import pytest
from surfaces import grid_points

from benchmarks import features as page
from core.mesh.input_map import places_in_input
from core.mesh.mending.repair import clean

COUNT = 41


def thin_sheet(thickness):
    """A square of side 2 and its back, sewn together around the rim."""
    points, triangles = grid_points(COUNT, COUNT, (-1.0, -1.0), (1.0, 1.0))
    half = np.full(len(points), 0.5 * thickness)
    rim = np.abs(points).max(axis=1) > 1.0 - 1e-9
    half[rim] = 0.0
    back = np.where(rim, np.arange(len(points)), np.arange(len(points)) + len(points))
    vertices = np.concatenate([np.column_stack([points, side]) for side in (half, -half)])
    return vertices, np.concatenate([triangles, back[triangles[:, ::-1]]])


def poles_at(surface, *places):
    """Poles of valence 3 and 5 in turn, in the middles of the triangles nearest to places."""
    middle = surface.vertices[surface.triangles].mean(axis=1) * surface.unit + surface.origin
    row = np.array([np.linalg.norm(middle - place, axis=1).argmin() for place in places])
    triangle, weights = places_in_input(surface, row, np.full((len(row), 3), 1.0 / 3.0))
    valence = np.where(np.arange(len(row)) % 2 == 0, 3, 5)
    return SimpleNamespace(
        position=middle[row], triangle=triangle, barycentric=weights, valence=valence
    )


@pytest.mark.parametrize(
    ("places", "near"),
    [
        # Beside each other on one side; then on two sides of the sheet, far from its rim.
        (((0.0, 0.0, 0.05), (0.3, 0.1, 0.05)), 1),
        (((0.0, 0.0, 0.05), (0.0, 0.0, -0.05)), 0),
        # Around the rim the way is short.
        (((0.0, 0.95, 0.05), (0.0, 0.95, -0.05)), 1),
        (((0.0, 0.0, 0.05), (0.6, 0.0, 0.05)), 0),
        # In one triangle.
        (((0.0, 0.0, 0.05), (0.0, 0.0, 0.05)), 1),
    ],
)
def test_opposite_poles_are_near_along_the_surface(places, near):
    surface, _ = clean(*thin_sheet(0.1))
    assert page.near_pairs(surface, poles_at(surface, *places), 0.5) == near


def test_poles_of_one_kind_are_no_pair():
    surface, _ = clean(*thin_sheet(0.1))
    poles = poles_at(surface, (0.0, 0.0, 0.05), (0.9, 0.9, 0.05), (0.2, 0.0, 0.05))
    assert page.near_pairs(surface, poles, 0.5) == 0


@pytest.mark.parametrize(("fold", "near"), [(0.0, 1), (0.4, 1), (2.6, 0)])
def test_poles_in_needles_that_share_an_edge_are_near_over_it(fold, near):
    """Their corners are far; folded onto each other they are near in space alone."""
    across = 0.3 * np.array([[0.0, np.cos(fold), np.sin(fold)], [0.0, -1.0, 0.0]])
    vertices = np.array([(-5.0, 0.0, 0.0), (5.0, 0.0, 0.0), *across])
    surface, _ = clean(vertices, np.array([(0, 1, 2), (1, 0, 3)]))
    poles = poles_at(surface, *vertices[2:])
    assert page.near_pairs(surface, poles, 0.25 if near else 0.1) == near
