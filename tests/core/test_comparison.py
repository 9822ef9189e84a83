import numpy as np
from surfaces import ellipsoid, seed_patch

import core
from core.umbilics.compare import compare, comparison_table, table, within_edges


def test_the_patch_by_all_three() -> None:
    mesh = seed_patch(5400)
    results = compare(
        mesh.vertices,
        mesh.triangles,
        core.Settings(curvature="given", persistence=0.0),
        given=mesh.curvature,
    )
    assert [result.method for result in results] == ["S", "I", "C"]
    for result in results:
        points = result.detection.umbilics.position
        inner = points[np.all(np.abs(points[:, :2]) < 1.1, axis=1)]
        distance = np.linalg.norm(inner[:, None] - mesh.umbilics.position[None], axis=2)
        assert np.all(distance.min(axis=0) < 2 * mesh.edge_length)
    by_shape = results[0]
    assert by_shape.missed == by_shape.unmatched == 0
    assert by_shape.confirmed == len(by_shape.detection.umbilics)


def test_a_closed_mesh_is_refused_by_c_alone() -> None:
    mesh = ellipsoid(subdivisions=3)
    results = compare(mesh.vertices, mesh.triangles)
    assert [result.detection is None for result in results] == [False, False, True]
    assert "seams" in results[2].refusal
    rows = table(results)
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
