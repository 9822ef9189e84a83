import numpy as np
import pytest
from fields import surface_of
from surfaces import cylinder, ellipsoid, renumbered, seed_patch, torus

from core.fans import ordered_fans


@pytest.mark.parametrize(
    "mesh",
    [renumbered(ellipsoid(subdivisions=2)), torus(columns=20, rows=9), cylinder(), seed_patch(300)],
    ids=lambda mesh: mesh.name,
)
def test_neighbouring_corners_share_a_side(mesh) -> None:
    surface = surface_of(mesh)
    fans = ordered_fans(surface)
    assert np.array_equal(np.sort(fans.corners), np.arange(3 * len(surface.triangles)))
    owner = np.repeat(np.arange(len(surface.vertices)), np.diff(fans.start))
    assert np.array_equal(surface.triangles.ravel()[fans.corners], owner)
    ring = fans.ring(surface.triangles)
    back = np.roll(surface.triangles, 1, axis=1).ravel()[fans.corners]
    following = np.arange(len(ring)) + 1
    last = np.isin(following, fans.start)
    inner_last = last & ~surface.border[owner]
    following[last] = fans.start[owner[last]]
    continued = ~last | inner_last
    # The side on which a corner ends is the one on which the next begins.
    assert np.array_equal(back[continued], ring[following[continued]])


def test_the_ring_of_an_inner_vertex_is_its_neighbourhood() -> None:
    surface = surface_of(ellipsoid(subdivisions=2))
    fans = ordered_fans(surface)
    ring = fans.ring(surface.triangles)
    for vertex in range(0, len(surface.vertices), 7):
        got = ring[fans.start[vertex] : fans.start[vertex + 1]]
        rows = slice(surface.neighbour_start[vertex], surface.neighbour_start[vertex + 1])
        assert np.array_equal(np.sort(got), surface.neighbours[rows])
