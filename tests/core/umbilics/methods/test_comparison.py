import numpy as np
from surfaces import ellipsoid, seed_patch, sphere

import core
from core.umbilics.compare import (
    BASELINES,
    METHODS,
    compare,
    comparison_rows,
    comparison_table,
    within_edges,
)


def test_the_patch_by_all_three() -> None:
    mesh = seed_patch(5400)
    results = compare(
        mesh.vertices,
        mesh.triangles,
        core.Settings(curvature="given", persistence=0.0),
        given=mesh.curvature,
    )
    assert METHODS == ("S", "I", "C")
    assert tuple(result.method for result in results) == (*METHODS, *BASELINES)
    for result in results[:3]:
        points = result.detection.umbilics.position
        inner = points[np.all(np.abs(points[:, :2]) < 1.1, axis=1)]
        distance = np.linalg.norm(inner[:, None] - mesh.umbilics.position[None], axis=2)
        assert np.all(distance.min(axis=0) < 2 * mesh.edge_length)
    by_shape = results[0]
    assert by_shape.missed == by_shape.unmatched == 0
    assert by_shape.confirmed == len(by_shape.detection.umbilics)


def test_a_closed_mesh_is_refused_by_c_alone() -> None:
    mesh = ellipsoid(subdivisions=3)
    results = compare(mesh.vertices, mesh.triangles, core.Settings(charts="seams"))
    assert [result.detection is None for result in results[:3]] == [False, False, True]
    assert "seams" in results[2].refusal
    rows = comparison_rows(results)
    assert len({len(row) for row in rows}) == 1
    assert rows[3][1] == "refused"
    assert results[2].refusal in comparison_table(results)


def test_distance_counts_in_edges() -> None:
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.0]])
    triangles = np.array([[0, 1, 2]])
    points = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 9.0]])
    near = within_edges(vertices, triangles, np.array([0, 0]), points, np.array([[0.0, 0.0, 2.0]]))
    assert near.tolist() == [True, False]
    none = within_edges(vertices, triangles, np.array([0]), points[:1], np.zeros((0, 3)))
    assert none.tolist() == [False]


def test_the_usual_ways_stand_beside_them() -> None:
    mesh = seed_patch(5400)
    settings = core.Settings(curvature="given", persistence=0.0)
    results = compare(mesh.vertices, mesh.triangles, settings, given=mesh.curvature)
    by = {result.method: result for result in results}
    assert tuple(by)[3:] == BASELINES
    gap, difference, ratio = (by[name] for name in BASELINES)
    found = gap.detection.umbilics
    # Truly least at its vertex: by the neighbours in every triangle that holds it.
    corners = mesh.triangles[np.isin(mesh.triangles, found.vertex).any(axis=1)]
    exact = mesh.k1 - mesh.k2
    for vertex in found.vertex:
        ring = np.unique(corners[(corners == vertex).any(axis=1)])
        assert exact[vertex] == exact[ring].min()
    near = np.linalg.norm(found.position[:, None] - mesh.umbilics.position[None], axis=2)
    assert (near.min(axis=0) < 2 * mesh.edge_length).all()
    # Vertices are farther away than the points that S puts between them.
    assert gap.error > 3 * by["S"].error
    # H^2 - K of the one-ring converges nowhere on such a mesh: everywhere there are minima.
    assert len(difference.detection.umbilics) > 20 * len(by["S"].detection.umbilics)
    alike = ratio.detection.umbilics.vertex
    one, two = np.abs(mesh.k1), np.abs(mesh.k2)
    like = (np.minimum(one, two) > 0.95 * np.maximum(one, two)) & (mesh.k1 * mesh.k2 > 0)
    assert len(alike)
    assert like[alike].all()


def test_the_difference_of_meyer_is_zero_on_a_sphere_and_right_on_a_cylinder() -> None:
    from exact_fields import surface_of
    from surfaces import cylinder

    from core.umbilics.methods.at_vertices import mean_square_less_gaussian

    ball = surface_of(sphere(subdivisions=4))
    # Of a radius of one half both are 4.
    assert np.abs(mean_square_less_gaussian(ball)).max() < 0.02 * 4.0
    tube = cylinder()
    surface = surface_of(tube)
    values = mean_square_less_gaussian(surface)[~surface.near_border(1)]
    # A quarter of the squared gap, in the units of the surface.
    wanted = 0.25 * (tube.k1[0] - tube.k2[0]) ** 2 * surface.unit**2
    np.testing.assert_allclose(values, wanted, rtol=0.02)
