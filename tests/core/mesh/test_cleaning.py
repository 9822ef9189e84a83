"""Any soup becomes an oriented manifold, and what was mended is said."""

import numpy as np
import pytest
import surfaces
from hypothesis import given, settings
from hypothesis import strategies as st

import core
from core.mesh.mending.repair import clean
from core.retopology.quads.surface.subdivision import Triangles, split_edges

TETRAHEDRON = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])


def assert_manifold(surface) -> None:
    """Every directed edge once, twins back to back, one fan around every vertex."""
    m, n = len(surface.triangles), len(surface.vertices)
    tails = surface.triangles.ravel().astype(np.int64)
    heads = np.roll(surface.triangles, -1, axis=1).ravel()
    assert len(np.unique(tails * n + heads)) == 3 * m
    linked = np.flatnonzero(surface.twin >= 0)
    twin = surface.twin[linked]
    np.testing.assert_array_equal(surface.twin[twin], linked)
    np.testing.assert_array_equal(tails[twin], heads[linked])
    np.testing.assert_array_equal(heads[twin], tails[linked])
    open_edges = np.flatnonzero(surface.twin < 0)
    assert (np.bincount(tails[open_edges], minlength=n) <= 1).all()
    np.testing.assert_array_equal(np.unique(tails), np.arange(n))
    assert surface.neighbour_start[-1] == len(surface.neighbours)


def test_a_clean_mesh_passes_through_untouched():
    mesh = surfaces.ellipsoid(subdivisions=2)
    surface, warnings = clean(mesh.vertices, mesh.triangles)
    assert warnings == []
    np.testing.assert_array_equal(surface.triangles, mesh.triangles)
    np.testing.assert_allclose(surface.vertices * surface.unit + surface.origin, mesh.vertices)
    assert_manifold(surface)
    assert list(surface.euler_characteristic) == [2] and surface.closed.all()


def test_inconsistent_windings_are_turned_to_the_majority():
    mesh = surfaces.sphere(subdivisions=2)
    triangles = mesh.triangles.copy()
    triangles[::5] = triangles[::5, ::-1]
    surface, warnings = clean(mesh.vertices, triangles)
    assert any("wound against" in text for text in warnings)
    volume = np.einsum(
        "ij,ij->",
        surface.vertices[surface.triangles[:, 0]],
        np.cross(
            surface.vertices[surface.triangles[:, 1]], surface.vertices[surface.triangles[:, 2]]
        ),
    )
    assert volume > 0
    assert_manifold(surface)


def test_moebius_strip_is_cut_and_named_one_sided():
    count = 40
    turn = np.linspace(0, 2 * np.pi, count, endpoint=False)
    across = np.array([-0.3, 0.0, 0.3])
    radius = 1 + across[None] * np.cos(turn / 2)[:, None]
    points = np.stack(
        [
            radius * np.cos(turn)[:, None],
            radius * np.sin(turn)[:, None],
            across[None] * np.sin(turn / 2)[:, None],
        ],
        axis=2,
    ).reshape(-1, 3)
    triangles = []
    for i in range(count):
        for j in range(2):
            a, b = 3 * i + j, 3 * i + j + 1
            last = i == count - 1
            c = (2 - j) if last else 3 * (i + 1) + j
            d = (1 - j) if last else 3 * (i + 1) + j + 1
            triangles += [[a, c, b], [b, c, d]]
    surface, warnings = clean(points, np.array(triangles))
    assert any("one-sided" in text for text in warnings)
    assert_manifold(surface)
    assert len(surface.triangles) == len(triangles)


def test_two_tetrahedra_at_one_vertex_become_two_pieces():
    vertices = np.vstack([CORNERS, -CORNERS[1:]])
    triangles = np.vstack([TETRAHEDRON, np.array([0, 4, 5, 6])[TETRAHEDRON][:, ::-1]])
    surface, warnings = clean(vertices, triangles)
    assert any("1 pinched vertex" in text for text in warnings)
    assert_manifold(surface)
    assert list(surface.euler_characteristic) == [2, 2]
    np.testing.assert_array_equal(np.bincount(surface.source_vertex), [2, 1, 1, 1, 1, 1, 1])


def test_three_sheets_on_an_edge_are_taken_apart():
    vertices = np.array([[0.0, 0, 0], [0, 0, 1], [1, 0, 0], [-1, 1, 0], [-1, -1, 0]])
    triangles = np.array([[0, 1, 2], [0, 1, 3], [0, 1, 4]])
    surface, warnings = clean(vertices, triangles)
    assert any("three or more triangles" in text for text in warnings)
    assert_manifold(surface)
    assert len(surface.vertices) == 9


def test_a_fin_that_is_left_out_opens_nothing():
    mesh = surfaces.sphere(subdivisions=3)
    edges = [mesh.triangles[7, :2], mesh.triangles[300, :2]]
    tips = [1.2 * mesh.vertices[edge].mean(axis=0) for edge in edges]
    n = len(mesh.vertices)
    fins = [[*edges[0], n], [*edges[1], n + 1]]
    surface, warnings = clean(np.vstack([mesh.vertices, tips]), np.vstack([mesh.triangles, fins]))
    assert_manifold(surface)
    assert surface.closed.all() and list(surface.euler_characteristic) == [2]
    assert len(surface.triangles) == len(mesh.triangles)
    assert any("2 edges with three or more" in text for text in warnings)
    assert any("2 pieces of fewer than" in text for text in warnings)


def test_a_fin_that_is_kept_leaves_the_surface_closed():
    # A fan of six rows stands on a path of edges across a sphere.
    mesh = surfaces.sphere(subdivisions=3)
    path = [int(mesh.vertices[:, 0].argmin())]
    while len(path) < 6:
        beside = mesh.triangles[(mesh.triangles == path[-1]).any(axis=1)].ravel()
        path.append(int(beside[mesh.vertices[beside, 0].argmax()]))
    n, length = len(mesh.vertices), len(path)
    rows = [mesh.vertices[path] * (1.0 + 0.05 * k) for k in range(1, 7)]
    grid = np.vstack([path, n + np.arange(6 * length).reshape(6, length)])
    a, b = grid[:-1, :-1].ravel(), grid[:-1, 1:].ravel()
    c, d = grid[1:, 1:].ravel(), grid[1:, :-1].ravel()
    fin = np.vstack([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    surface, warnings = clean(np.vstack([mesh.vertices, *rows]), np.vstack([mesh.triangles, fin]))
    assert_manifold(surface)
    assert sorted(surface.euler_characteristic.tolist()) == [1, 2]
    assert surface.closed.sum() == 1
    assert any("5 edges with three or more" in text for text in warnings)


def test_duplicates_and_repeated_corners_are_left_out():
    triangles = np.vstack([TETRAHEDRON, TETRAHEDRON[:1], TETRAHEDRON[1:2, ::-1], [[0, 0, 1]]])
    surface, warnings = clean(CORNERS, triangles)
    assert any("2 duplicate triangles" in text for text in warnings)
    assert any("1 triangle with repeated corners" in text for text in warnings)
    np.testing.assert_array_equal(surface.source_triangle, [0, 1, 2, 3])
    assert list(surface.euler_characteristic) == [2]


def test_vertices_that_are_not_finite_lose_their_triangles_only():
    mesh = surfaces.sphere(subdivisions=2)
    vertices = mesh.vertices.copy()
    vertices[7] = np.nan
    surface, warnings = clean(vertices, mesh.triangles)
    assert any("not finite" in text for text in warnings)
    assert len(surface.triangles) == len(mesh.triangles) - (mesh.triangles == 7).any(axis=1).sum()
    assert_manifold(surface)


@pytest.mark.parametrize(
    "vertices, triangles, words",
    [
        (CORNERS, np.zeros((0, 3), int), "no faces"),
        (CORNERS[:, :2], TETRAHEDRON, r"\(n, 3\)"),
        (CORNERS, TETRAHEDRON[:, :2], r"\(m, 3\)"),
        (CORNERS, TETRAHEDRON.astype(float), "whole numbers"),
        (CORNERS, TETRAHEDRON + 1, "there are 4"),
        (CORNERS, TETRAHEDRON - 1, "-1"),
        (CORNERS * np.nan, TETRAHEDRON, "finite"),
        (CORNERS * 0 + 3, TETRAHEDRON, "one point"),
        (CORNERS, np.zeros((3, 3), int), "three different"),
        ([["a", "b", "c"]], TETRAHEDRON, "numbers"),
    ],
)
def test_unusable_input_is_refused_in_words(vertices, triangles, words):
    with pytest.raises(core.InvalidMeshError, match=words):
        clean(vertices, triangles)


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1), st.integers(4, 30), st.integers(1, 60))
def test_any_soup_becomes_a_manifold(seed, points, count):
    random = np.random.default_rng(seed)
    vertices = random.standard_normal((points, 3))
    triangles = random.integers(0, points, (count, 3))
    try:
        surface, _ = clean(vertices, triangles)
    except core.InvalidMeshError:
        assert not (np.diff(np.sort(triangles, axis=1), axis=1) > 0).all(axis=1).any()
        return
    assert_manifold(surface)


def shell(radius, middle=(0.0, 0.0, 0.0), inwards=False):
    ball = surfaces.sphere(subdivisions=2)
    triangles = ball.triangles[:, ::-1] if inwards else ball.triangles
    return ball.vertices * radius + middle, triangles


@pytest.mark.parametrize(
    ("shells", "wrong"),
    [
        ([shell(2.0), shell(1.0, inwards=True)], 0),
        ([shell(2.0), shell(0.5, (1, 0, 0), True), shell(0.5, (-1, 0, 0), True)], 0),
        ([shell(2.0), shell(1.0, (0, 0, 5), True)], 1),
        ([shell(2.0, inwards=True), shell(1.0)], 1),
        # What lies in a hollow is a body again.
        ([shell(3.0), shell(2.0, inwards=True), shell(1.0)], 0),
        ([shell(3.0), shell(2.0, inwards=True), shell(1.0, inwards=True)], 1),
    ],
)
def test_walls_of_a_cavity_point_into_it(shells, wrong):
    counts = np.cumsum([0, *(len(vertices) for vertices, _ in shells)])
    vertices = np.concatenate([vertices for vertices, _ in shells])
    triangles = np.concatenate([t + first for (_, t), first in zip(shells, counts, strict=False)])
    _, warnings = clean(vertices, triangles)
    said = [f"The normals of {wrong} closed piece point inwards"] if wrong else []
    assert [warning.split(",")[0] for warning in warnings] == said


def loft(rows, columns, radius):
    """A closed surface as a grid, its poles rings of vertices of such a radius, not joined."""
    height = np.linspace(0.0, np.pi, rows)
    around = 2.0 * np.pi * np.arange(columns) / columns
    wide = np.maximum(np.sin(height), radius)
    wide[[0, -1]] = radius
    u, v = np.meshgrid(np.arange(rows - 1), np.arange(columns), indexing="ij")
    u, v, beside = u.ravel(), v.ravel(), ((v + 1) % columns).ravel()
    above, below = u * columns, (u + 1) * columns
    a, b, c, d = above + v, below + v, below + beside, above + beside
    points = np.stack(
        [
            3.0 * np.outer(wide, np.cos(around)),
            2.0 * np.outer(wide, np.sin(around)),
            np.tile(np.cos(height)[:, None], columns),
        ],
        axis=-1,
    )
    return points.reshape(-1, 3), np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


@pytest.mark.parametrize("radius", [0.0, 1e-17, 1e-9, 5e-8])
def test_rings_of_no_length_are_poles(radius):
    vertices, triangles = loft(40, 60, radius)
    surface, warnings = clean(vertices, triangles)
    assert surface.closed.all() and surface.euler_characteristic.sum() == 2
    assert_manifold(surface)
    assert len(warnings) == 1 and "118 vertices taken together" in warnings[0]
    copies, kept = surface.joined.T
    assert np.abs(vertices[copies] - vertices[kept]).max() <= 6.0 * radius
    # Every vertex of the input hears of what is found at its pole.
    found = core.detect(vertices, triangles)
    assert found.index_sum == found.expected_index_sum == 2.0
    assert len(found.umbilics) == 4 and (found.umbilics.kind == "lemon").all()
    assert np.isfinite(found.curvature.k1).all()
    for ring in (slice(0, 60), slice(-60, None)):
        assert len(np.unique(found.curvature.k1[ring])) == 1
    assert clean(vertices, triangles, join_borders=False)[0].border.any()


def test_a_small_hole_and_a_small_piece_stay():
    vertices, triangles = loft(40, 60, 1e-4)
    assert clean(vertices, triangles)[0].border.any()
    ball, faces = surfaces.icosphere(2)
    both = np.concatenate([vertices, 1e-9 * ball + 4.0])
    # A piece that is open and as small as the steps of single precision has a shape of its own.
    surface, _ = clean(both, np.concatenate([triangles, faces[1:] + len(vertices)]))
    assert len(surface.joined) == 0
    assert len(surface.triangles) == len(triangles) + len(faces) - 1


def test_triangles_without_area_between_others_go():
    mesh = surfaces.ellipsoid(subdivisions=2)
    surface, _ = clean(mesh.vertices, mesh.triangles)
    random = np.random.default_rng(0)
    marked = random.random(len(surface.twin)) < 0.2
    marked |= marked[surface.twin]
    spoiled = split_edges(
        Triangles(
            mesh.vertices,
            mesh.triangles.astype(np.int64),
            np.zeros((len(mesh.vertices), 1)),
            np.arange(len(mesh.triangles)),
            np.zeros(len(marked), np.int8),
        ),
        marked,
        np.zeros(len(marked)),
    )
    found, warnings = clean(spoiled.vertices, spoiled.triangles)
    assert len(warnings) == 1 and "Edges without a length" in warnings[0]
    assert len(found.triangles) == len(mesh.triangles)
    assert found.closed.all() and found.euler_characteristic.sum() == 2
    assert len(core.detect(spoiled.vertices, spoiled.triangles).umbilics) == 4
