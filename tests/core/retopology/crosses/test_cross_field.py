"""The cross field: analytic surfaces, exact sums, alignment, the two ends of the slider."""

import numpy as np
import pytest
from exact_fields import surface_of
from scipy import sparse
from scipy.sparse.linalg import spsolve
from shapes import cube
from surfaces import cylinder, ellipsoid, icosphere, noisy, plane, quartic, sphere, torus

import core
from core.base.progress import Progress
from core.fields.face_index import face_field_singularities
from core.fields.multigrid import SMALLEST, Multigrid, solve, solve_diagonal
from core.fields.planes import lay_out
from core.mesh.creases import is_convex
from core.mesh.mending.repair import clean
from core.retopology.crosses.cross_field import cross_field
from core.retopology.features import find_features
from core.retopology.settings import GuidanceSettings


def made(mesh, **settings):
    surface = surface_of(mesh)
    field = mesh.curvature_on(surface)
    return surface, field, cross_field(surface, field, GuidanceSettings(**settings), Progress())


def away_from(directions, others):
    """Degrees between crosses (n, 3) in the same tangent planes, at most 45."""
    cosine = np.abs(np.einsum("ij,ij->i", directions, others)).clip(0, 1)
    angle = np.degrees(np.arccos(cosine))
    return np.minimum(angle, 90 - angle)


@pytest.mark.parametrize("smoothness", [0.0, 0.3, 0.65, 1.0])
@pytest.mark.parametrize(
    "mesh",
    [ellipsoid(subdivisions=4), quartic(4), torus(columns=60, rows=24), sphere(subdivisions=4)],
    ids=lambda mesh: mesh.name,
)
def test_indices_sum_to_the_euler_characteristic(mesh, smoothness):
    surface, _, cross = made(mesh, smoothness=smoothness)
    assert cross.triangle_index.sum() == surface.euler_characteristic.sum()
    assert set(np.unique(4 * cross.triangle_index) % 1) == {0.0}


@pytest.mark.once
def test_sums_hold_under_wild_noise():
    mesh = noisy(ellipsoid(subdivisions=4), 0.3)
    detection = core.detect(mesh.vertices, mesh.triangles)
    guidance = core.Guide(mesh.vertices, mesh.triangles, detection).guidance()
    assert guidance.index_sum == guidance.expected_index_sum == 2.0
    assert guidance.poles.total == guidance.poles.expected == 8.0


def test_follows_curvature_where_the_gap_is_large():
    mesh = ellipsoid(subdivisions=5)
    _, field, cross = made(mesh, smoothness=0.2)
    sure = cross.confidence > 0.9
    assert sure.sum() > 1000
    assert np.quantile(away_from(cross.direction[sure], field.d1[sure]), 0.99) < 1.0


def test_lemons_part_across_their_separatrix():
    mesh = ellipsoid(subdivisions=5)
    surface, _, cross = made(mesh)
    rows = np.flatnonzero(cross.triangle_index)
    points = surface.vertices[surface.triangles[rows]].mean(axis=1) * surface.unit + surface.origin
    assert np.allclose(cross.triangle_index[rows], 0.25)
    assert len({tuple(signs) for signs in np.sign(points)}) == 8
    # The separatrix of each lemon lies in y = 0; the two stand at the same x and z.
    for corner in mesh.umbilics.position:
        pair = points[np.argsort(np.linalg.norm(points - corner, axis=1))[:2]]
        apart = pair[1] - pair[0]
        assert abs(apart[1]) > 0.95 * np.linalg.norm(apart)


def test_smoother_means_farther_apart():
    apart = []
    for smoothness in (0.5, 0.65, 0.8, 1.0):
        surface, _, cross = made(ellipsoid(subdivisions=4), smoothness=smoothness)
        rows = np.flatnonzero(cross.triangle_index)
        apart.append(np.abs(surface.vertices[surface.triangles[rows]].mean(axis=1)[:, 1]).mean())
    assert apart == sorted(apart)


def test_crosses_lie_in_their_planes():
    surface, _, cross = made(torus(columns=60, rows=24))
    normal, _ = surface.face_normal_area
    assert np.abs(np.einsum("ij,ij->i", cross.direction, cross.normal)).max() < 1e-9
    assert np.abs(np.einsum("ij,ij->i", cross.face_direction, normal)).max() < 1e-9
    assert np.allclose(np.linalg.norm(cross.face_direction, axis=1), 1.0)


def test_cylinder_and_torus_have_no_singularity():
    for mesh in (cylinder(), torus()):
        _, field, cross = made(mesh)
        assert not cross.triangle_index.any()
        assert np.median(away_from(cross.direction, field.d1)) < 0.5


def test_cube_is_aligned_to_its_edges_with_a_pole_at_each_corner():
    vertices, triangles = cube()
    detection = core.detect(vertices, triangles)
    guidance = core.Guide(vertices, triangles, detection).guidance()
    axes = np.abs(guidance.face_direction)
    assert np.quantile(np.degrees(np.arccos(axes.max(axis=1).clip(0, 1))), 0.9) < 2.0
    assert guidance.poles.total == 8
    corners = np.sign(guidance.poles.position)
    assert len(guidance.poles) == len(np.unique(corners, axis=0)) == 8
    assert np.linalg.norm(guidance.poles.position - corners, axis=1).max() < 0.5
    # Every sharp edge once: 12 edges of 8 cells each, all convex.
    assert len(guidance.feature_side) == 12 * 8
    assert guidance.feature_convex.all()


def test_borders_are_followed():
    mesh = plane()
    surface, _, cross = made(mesh)
    at = np.flatnonzero(surface.border)
    assert len(at)
    assert np.quantile(np.abs(cross.direction[at]).max(axis=1), 0.05) > 0.999


def test_features_by_mark_and_by_angle():
    vertices, triangles = cube(2)
    surface, _ = clean(vertices, triangles)
    none = GuidanceSettings(feature_angle=180.0)
    assert len(find_features(surface, none, None).half_edge) == 0
    marked = np.array([triangles[0, :2], triangles[5, 1:]])
    found = find_features(surface, none, marked).half_edge
    ends = np.sort(
        np.stack(
            [
                surface.source_vertex[surface.triangles.ravel()[found]],
                surface.source_vertex[surface.triangles[:, [1, 2, 0]].ravel()[found]],
            ],
            axis=1,
        )
    )
    assert {tuple(row) for row in ends} == {tuple(sorted(row)) for row in marked.tolist()}
    inside_out, _ = clean(vertices, triangles[:, ::-1])
    sharp = find_features(inside_out, GuidanceSettings(), None).half_edge
    assert not is_convex(inside_out, sharp).any()


def test_marks_on_all_edges_are_no_features():
    mesh = ellipsoid(subdivisions=4)
    surface = surface_of(mesh)
    every = np.concatenate([mesh.triangles[:, [k, (k + 1) % 3]] for k in range(3)])
    assert len(find_features(surface, GuidanceSettings(), every).half_edge) == 0


def test_face_field_has_the_same_sum_at_vertices():
    mesh = ellipsoid(subdivisions=4)
    surface, field, cross = made(mesh, smoothness=0.65)
    planes = lay_out(surface, field.lines, Progress())
    vertex, quarters = face_field_singularities(surface, planes, cross.face_direction)
    assert quarters.sum() == 8
    assert (quarters == 1).all() and len(vertex) == 8


def turning_laplacian(rng, spread=0.3, subdivisions=5):
    """A Hermitian Laplacian (n, n) over an icosphere, with random phases, and its degrees (n,)."""
    points, triangles = icosphere(subdivisions)
    n = len(points)
    tail, head = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    first = tail < head
    tail, head = tail[first], head[first]
    phase = np.exp(1j * spread * rng.normal(size=len(tail)))
    upper = sparse.coo_array((-phase, (tail, head)), shape=(n, n)).tocsr()
    degree = np.bincount(np.concatenate([tail, head]), minlength=n).astype(float)
    return upper + upper.conj().T + sparse.diags_array(degree.astype(complex)), degree


def test_solver_finds_what_was_put_in():
    rng = np.random.default_rng(1)
    matrix, degree = turning_laplacian(rng)
    n = len(degree)
    matrix = (matrix + sparse.diags_array(np.full(n, 0.01 + 0j))).tocsr()
    exact = rng.normal(size=n) + 1j * rng.normal(size=n)
    found = solve(matrix, matrix @ exact, Progress(), tolerance=1e-8)
    assert np.abs(found - exact).max() < 1e-5 * np.abs(exact).max()


def test_solver_is_as_exact_beside_rows_that_weigh_much():
    """As those of creases, a hundred times the others."""
    rng = np.random.default_rng(2)
    matrix, degree = turning_laplacian(rng, spread=0.02, subdivisions=4)
    heavy = rng.random(len(degree)) < 0.05
    weight = np.where(heavy, 100.0 * degree, 1e-6)
    wanted = np.exp(2j * np.pi * rng.random(len(degree)))
    matrix = (matrix + sparse.diags_array(weight.astype(complex))).tocsr()
    exact = spsolve(matrix.tocsc(), weight * wanted)
    found = solve(matrix, weight * wanted, Progress())
    clear = np.abs(exact) > 0.1
    off = np.degrees(np.abs(np.angle(found[clear] * exact[clear].conj()))) / 4.0
    assert off.max() < 0.3


def test_cancelling_stops_the_solver():
    surface = surface_of(ellipsoid(subdivisions=4))
    field = ellipsoid(subdivisions=4).curvature_on(surface)
    with pytest.raises(core.CancelledError):
        cross_field(surface, field, GuidanceSettings(), Progress(cancelled=lambda: True))


@pytest.mark.parametrize("kind", [float, complex])
@pytest.mark.parametrize("most", [100, 2])
def test_the_diagonal_alone_solves_where_it_weighs_enough(kind, most):
    """What has not settled after so many steps is solved by levels."""
    matrix, degree = turning_laplacian(np.random.default_rng(2))
    matrix = matrix + sparse.diags_array(0.1 * degree.astype(complex))
    matrix = matrix.tocsr() if kind is complex else abs(matrix.tocsr())
    if kind is float:
        matrix = (2.0 * sparse.diags_array(matrix.diagonal()) - matrix).tocsr()
    exact = np.random.default_rng(3).normal(size=len(degree)).astype(kind)
    found = solve_diagonal(matrix, matrix @ exact, Progress(), 1e-4, most)
    assert found.dtype == kind
    assert np.linalg.norm(found - exact) < 2e-3 * np.linalg.norm(exact)


def test_levels_are_not_made_when_the_user_wants_to_stop():
    count = 2 * SMALLEST
    chain = sparse.diags_array([-np.ones(count - 1), np.full(count, 2.1)], offsets=[-1, 0])
    matrix = (chain + sparse.triu(chain.T, 1)).tocsr().astype(complex)
    with pytest.raises(core.CancelledError):
        Multigrid(matrix, Progress(cancelled=lambda: True))
    asked = []
    Multigrid(matrix, Progress(cancelled=lambda: asked.append(1)))
    # One level and the factors of the coarsest.
    assert len(asked) == 2
