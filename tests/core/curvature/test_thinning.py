"""Long thin triangles: more vertices one way make nothing worse, and cost what they are."""

import numpy as np
import pytest
import surfaces
from exact_fields import surface_of

import core
from core.base.progress import Progress
from core.mesh.mending.repair import clean
from core.mesh.neighbourhoods import Neighbourhood
from core.mesh.normals import vertex_normals
from core.mesh.rings import adjacency
from core.mesh.thinning import thinned

AXES = (3.0, 2.0, 1.0)


def globe(segments: int, rings: int, pole: int) -> tuple[np.ndarray, np.ndarray]:
    """An ellipsoid of meridians and parallels whose poles lie on the given axis."""
    theta = np.pi * np.arange(1, rings)[:, None] / rings
    phi = 2 * np.pi * np.arange(segments) / segments
    around = [np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta) + 0 * phi]
    points = np.stack(around, axis=2).reshape(-1, 3)
    vertices = np.concatenate([[[0, 0, 1.0]], points, [[0, 0, -1.0]]])
    j = np.arange(segments)
    k = (j + 1) % segments
    triangles = [np.stack([0 * j, 1 + j, 1 + k], axis=1)]
    for one in range(1, 1 + (rings - 2) * segments, segments):
        two = one + segments
        triangles += [
            np.stack([one + j, two + j, two + k], axis=1),
            np.stack([one + j, two + k, one + k], axis=1),
        ]
    last = 1 + (rings - 2) * segments
    triangles.append(np.stack([0 * j + len(vertices) - 1, last + k, last + j], axis=1))
    return np.roll(vertices, pole + 1, axis=1) * AXES, np.concatenate(triangles)


@pytest.mark.parametrize(
    "segments, rings, pole",
    [(16, 16, 2), (16, 100, 2), (16, 200, 2), (24, 300, 2), (200, 16, 0), (400, 16, 0),
     (24, 240, 1)],
)  # fmt: skip
def test_more_vertices_one_way_lose_no_umbilic(segments, rings, pole):
    vertices, triangles = globe(segments, rings, pole)
    detection = core.detect(vertices, triangles)
    true = surfaces.ellipsoid(AXES).umbilics.position
    away = np.linalg.norm(detection.umbilics.position[:, None] - true, axis=2)
    a, b, c = vertices[triangles].transpose(1, 0, 2)
    longest = np.max([np.linalg.norm(a - b, axis=1), np.linalg.norm(b - c, axis=1)])
    assert away.shape == (4, 4)
    assert away.min(axis=0).max() < 0.6 * longest


def samples_at(surface, vertices):
    cells = thinned(surface, vertex_normals(surface), None, Progress())
    around = Neighbourhood(surface, adjacency(surface), thinned=cells)
    found = {}
    for rows, members, held in around.blocks(vertices, 10_000):
        for row, column, count in zip(rows, members.T, held, strict=True):
            found[row] = column[:count]
    return [found[row] for row in range(len(vertices))]


@pytest.mark.parametrize("rings", [100, 400, 1000])
def test_samples_do_not_grow_with_the_vertices(rings):
    vertices, triangles = globe(12, rings, 2)
    surface, _ = clean(vertices, triangles)
    equator = np.flatnonzero(np.abs(surface.vertices[:, 2]) < 0.1)[::37]
    for row, members in zip(equator, samples_at(surface, equator), strict=True):
        assert 15 <= len(members) <= 60
        assert len(np.unique(members)) == len(members)
        # They reach to both sides, not along one meridian only.
        offset = surface.vertices[members] - surface.vertices[row]
        _, width, length = np.linalg.eigvalsh(offset.T @ offset)
        assert length < 10.0**2 * width


def test_a_fan_of_any_number_of_blades_costs_no_square():
    count = 3000
    angle = 2 * np.pi * np.arange(count) / count
    rim = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    outer = 2.0 * rim + [0, 0, -1.0]
    vertices = np.concatenate([[[0, 0, 0.3]], rim, outer, [[0, 0, -1.3]]])
    j = np.arange(count)
    k = (j + 1) % count
    triangles = np.concatenate([
        np.stack([0 * j, 1 + j, 1 + k], axis=1),
        np.stack([1 + j, 1 + count + j, 1 + count + k], axis=1),
        np.stack([1 + j, 1 + count + k, 1 + k], axis=1),
        np.stack([0 * j + 1 + 2 * count, 1 + count + k, 1 + count + j], axis=1),
    ])  # fmt: skip
    surface, _ = clean(vertices, triangles)
    ring = np.flatnonzero(np.isclose(np.linalg.norm(vertices - [0, 0, 0], axis=1), 1.0))
    assert len(ring) == count
    assert max(map(len, samples_at(surface, ring[::100]))) < 200


def test_even_meshes_are_left_alone():
    for mesh in (
        surfaces.ellipsoid(subdivisions=4),
        surfaces.random_ellipsoid(3000),
        surfaces.noisy(surfaces.random_ellipsoid(3000), 0.05),
        surfaces.seed_patch(grid=True),
        surfaces.torus(),
    ):
        surface = surface_of(mesh)
        assert thinned(surface, vertex_normals(surface), None, Progress()) is None


def test_walls_and_borders_stay_cells_of_their_own():
    points, triangles = surfaces.grid_points(8, 200, (0.0, 0.0), (1.0, 1.0))
    arch = np.sin(np.pi * points[:, 0])
    surface, _ = clean(np.column_stack([points, arch]), triangles)
    crease_vertices = np.abs(points[:, 0] - 0.5) < 1e-9
    assert crease_vertices.any()
    cells = thinned(surface, vertex_normals(surface), crease_vertices, Progress())
    alone = np.bincount(cells.cell)[cells.cell] == 1
    assert alone[crease_vertices | surface.border].all()
    assert not alone[~crease_vertices & ~surface.border].all()
    np.testing.assert_array_equal(cells.cell[cells.seed], np.arange(len(cells.seed)))
    # Cells are whole: an edge of the surface leads to every other vertex of a cell.
    owner = np.repeat(np.arange(len(points)), np.diff(surface.neighbour_start))
    mates = np.zeros(len(points), bool)
    mates[owner[cells.cell[owner] == cells.cell[surface.neighbours]]] = True
    assert mates[~alone].all()
