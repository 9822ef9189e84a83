"""Creases by angle and by mark, and what importers mark that is none."""

import numpy as np
import surfaces

import core
from core.mesh.creases import bent_half_edges, is_convex, marked_half_edges
from core.mesh.mending.repair import clean


def edges_of(triangles):
    """(e, 2) vertices of the edges."""
    return np.unique(np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)


def named(surface, half_edges):
    """The vertex pairs of half-edges, as a set."""
    tail = surface.triangles.ravel()[half_edges]
    head = surface.triangles[:, [1, 2, 0]].ravel()[half_edges]
    pairs = np.sort(surface.source_vertex[np.column_stack([tail, head])], axis=1)
    return set(map(tuple, pairs.tolist()))


def roof(slope):
    """Two grids that meet at x = 0, each falling at `slope` radians."""
    points, triangles = surfaces.grid_points(20, 20, (-1.0, -1.0), (1.0, 1.0))
    return np.column_stack([points, -np.tan(slope) * np.abs(points[:, 0])]), triangles


def test_edges_are_bent_where_the_normal_turns_further():
    surface, _ = clean(*roof(0.3))
    turned = np.degrees(0.6)
    ridge = named(surface, bent_half_edges(surface, turned - 1.0))
    assert len(ridge) == 20
    ends = np.array(sorted(ridge))
    assert np.abs(surface.vertices[ends, 0] - surface.vertices[ends[0, 0], 0]).max() < 1e-12
    assert not named(surface, bent_half_edges(surface, turned + 1.0))


def test_a_ridge_is_convex_from_either_side_of_it_a_valley_is_not_a_border_is():
    for slope, convex in ((0.3, True), (-0.3, False)):
        surface, _ = clean(*roof(slope))
        edge = bent_half_edges(surface, 20.0)
        assert len(edge) == 20
        for side in (edge, surface.twin[edge]):
            assert (is_convex(surface, side) == convex).all()
        assert is_convex(surface, np.flatnonzero(surface.twin < 0)).all()


def test_each_marked_edge_is_found_once_in_either_order():
    vertices, triangles = roof(0.0)
    surface, _ = clean(vertices, triangles)
    marked = np.random.default_rng(0).permutation(edges_of(triangles))[:100]
    wanted = set(map(tuple, marked.tolist()))
    marked[::2] = marked[::2, ::-1]
    found = marked_half_edges(surface, marked)
    assert len(found) == 100
    assert named(surface, found) == wanted
    # Vertices of the input that no triangle has.
    assert len(marked_half_edges(surface, np.array([[len(vertices), len(vertices) + 1]]))) == 0
    assert len(marked_half_edges(surface, None)) == 0


def test_marks_on_more_than_a_fifth_of_the_edges_are_the_importers():
    vertices, triangles = roof(0.0)
    surface, _ = clean(vertices, triangles)
    edges = np.random.default_rng(0).permutation(edges_of(triangles))
    # A fifth of the edges, as if each belonged to two triangles.
    fifth = len(triangles) * 3 // 10
    assert len(marked_half_edges(surface, edges[:fifth])) == fifth
    assert len(marked_half_edges(surface, edges[: fifth + 1])) == 0
    # On a mesh of a few triangles all edges may be creases.
    few, _ = clean(vertices, triangles[:200])
    edges = edges_of(triangles[:200])
    assert len(marked_half_edges(few, edges)) == len(edges)


def test_marks_on_every_edge_are_the_importers_and_change_nothing():
    ball, triangles = surfaces.icosphere(4)
    vertices = ball * (3.0, 2.0, 1.0)
    without = core.detect(vertices, triangles)
    marked = core.detect(vertices, triangles, sharp=edges_of(triangles))
    np.testing.assert_array_equal(marked.curvature.k1, without.curvature.k1)
    np.testing.assert_array_equal(marked.umbilics.position, without.umbilics.position)


def test_marks_count_as_creases_unless_switched_off():
    vertices, triangles = roof(0.3)
    surface, _ = clean(vertices, triangles)
    ridge = np.array(sorted(named(surface, bent_half_edges(surface, 20.0))))
    flat = np.abs(np.abs(vertices[:, 0]) - 0.1) < 0.01
    assert flat.any()
    bent = {
        marks: np.abs(
            core.detect(
                vertices, triangles, core.Settings(scale=3.0, crease_marks=marks), sharp=ridge
            ).curvature.k2[flat]
        ).max()
        for marks in (True, False)
    }
    assert bent[True] < 1e-9
    assert bent[False] > 0.05
