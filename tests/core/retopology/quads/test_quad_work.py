"""Short cuts on the way to quads change nothing, and the work is bounded by what is asked for."""

from collections import Counter
from dataclasses import replace

import hypothesis
import numpy as np
import pytest
from hypothesis.strategies import floats, integers
from quad_guarantees import closest_in
from scipy import sparse
from surfaces import ellipsoid, icosphere, sphere, torus

import core
from core.base.factors import definite_factors
from core.fields.multigrid import Multigrid
from core.mesh.mending.repair import clean
from core.retopology.crosses import cross_field
from core.retopology.quads.field.crosses import crosses
from core.retopology.quads.finishing import projection
from core.retopology.quads.layout import laying_out
from core.retopology.quads.mapping import untangling
from core.retopology.quads.mapping.elimination import free_basis
from core.retopology.quads.mapping.seamless_map import pose
from core.retopology.quads.surface import working_surface as working
from core.retopology.quads.surface.decimation import coarsened
from core.retopology.quads.surface.subdivision import CREASE_BIT, Triangles


def bare(surface, feature=None):
    """A surface as triangles that carry nothing."""
    half_edges = 3 * len(surface.triangles)
    return Triangles(
        surface.vertices,
        surface.triangles.astype(np.int64),
        np.zeros((len(surface.vertices), 1)),
        np.arange(len(surface.triangles)),
        np.zeros(half_edges, np.int8) if feature is None else feature,
    )


@hypothesis.given(integers(0, 10**6), integers(1, 12), integers(2, 14))
def test_free_unknowns_span_what_conditions_allow(seed, conditions, unknowns):
    random = np.random.default_rng(seed)
    rows = random.integers(-2, 3, (conditions, unknowns)) * (random.random(unknowns) < 0.7)
    # One that follows from two others.
    rows = np.vstack([rows, rows[0] + rows[-1]]).astype(float)
    basis = free_basis(sparse.csr_array(rows), unknowns).toarray()
    assert np.abs(rows @ basis).max(initial=0.0) < 1e-6
    rank = np.linalg.matrix_rank(rows)
    assert basis.shape[1] == unknowns - rank
    assert not basis.size or np.linalg.matrix_rank(basis) == basis.shape[1]


@pytest.fixture(scope="module")
def problem():
    """The map of a torus along its rings: its cut has branches and no pole."""
    mesh = torus(columns=30, rows=14)
    surface, _ = clean(mesh.vertices, mesh.triangles)
    corner = surface.triangles
    along = np.cross([0.0, 0.0, 1.0], surface.vertices[corner].mean(axis=1))
    size = np.full(len(corner), 0.1)
    none = np.zeros(len(surface.twin), bool)
    return pose(crosses(surface.vertices, corner, surface.twin, along, size, none))


def test_a_part_of_the_map_moves_in_every_way_that_keeps_it_seamless(problem):
    assert problem.conditions.shape[0]
    whole = problem.conditions.toarray()
    basis = problem.whole_basis
    assert np.abs(problem.conditions @ basis).max() < 1e-9
    assert basis.shape[1] == problem.count - np.linalg.matrix_rank(whole)
    near = problem.crosses.vertices[:, 0] > 0.0
    moving = np.flatnonzero(problem.owner @ (~near).astype(float) == 0.0)
    part = problem.basis(moving)
    still = np.ones(problem.count, bool)
    still[moving] = False
    assert still.any() and not abs(part[np.flatnonzero(still)]).sum()
    assert np.abs(problem.conditions @ part).max() < 1e-9
    assert part.shape[1] == len(moving) - np.linalg.matrix_rank(whole[:, moving])


def test_factors_solve():
    random = np.random.default_rng(0)
    tail, head = random.integers(0, 60, (2, 200))
    graph = sparse.coo_array((np.ones(200), (tail, head)), shape=(60, 60)).tocsr()
    graph = graph + graph.T
    matrix = sparse.diags_array(np.asarray(graph.sum(axis=1)).ravel() + 0.1) - graph
    right = random.normal(size=60)
    assert np.allclose(matrix @ definite_factors(matrix).solve(right), right)


@pytest.mark.slow
@hypothesis.settings(max_examples=12)
@hypothesis.given(integers(0, 10**6), floats(0.05, 0.6), integers(1, 4))
def test_coarsening_ends_near_what_is_asked_for(seed, share, holes):
    random = np.random.default_rng(seed)
    mesh = sphere(subdivisions=4)
    vertices = mesh.vertices * random.uniform(0.5, 1.5, 3)
    vertices = vertices + 0.1 * np.sin(5.0 * vertices[:, [1, 2, 0]])
    kept = np.ones(len(mesh.triangles), bool)
    middle = vertices[mesh.triangles].mean(axis=1)
    for centre in middle[random.integers(0, len(middle), holes)]:
        kept &= np.linalg.norm(middle - centre, axis=1) > 0.2
    surface, _ = clean(vertices, mesh.triangles[kept])
    line = surface.vertices[surface.triangles][:, :, 0] > 0.0
    crease = (line.sum(axis=1) == 2)[:, None] & line & np.roll(line, -1, axis=1)
    crease = crease.ravel() & (surface.twin >= 0)
    crease[surface.twin[crease]] = True
    feature = np.where(crease, CREASE_BIT, 0).astype(np.int8)
    fine = bare(surface, feature)
    most = int(share * len(fine.triangles))
    coarse = coarsened(fine, most, core.Progress())
    other, warnings = clean(coarse.vertices, coarse.triangles)
    assert not warnings
    assert np.array_equal(other.euler_characteristic, surface.euler_characteristic)
    # Borders and features stay, and so do the triangles along them.
    held = np.count_nonzero(surface.twin < 0) + np.count_nonzero(crease)
    assert len(coarse.triangles) <= 1.1 * most + 6 * held
    assert np.isclose(coarse.lengths[coarse.feature > 0].sum(), fine.lengths[crease].sum())
    # No vertex has moved.
    place = {tuple(row) for row in fine.vertices.tolist()}
    assert all(tuple(row) in place for row in coarse.vertices.tolist())


@pytest.mark.slow
@pytest.mark.parametrize("level", [4, 5, 6])
def test_what_is_mapped_is_bounded_by_what_is_asked_for(level, monkeypatch):
    """However fine the input is, as many triangles are solved on as the quads need."""
    monkeypatch.setattr(working, "MOST", 4000)
    mesh = sphere(subdivisions=level)
    surface, _ = clean(mesh.vertices, mesh.triangles)
    for quads in (100, 800):
        size = float(np.sqrt(4.0 * np.pi / quads)) / surface.unit
        fine = replace(bare(surface), values=np.zeros((len(surface.vertices), 13)))
        made = working.working_surface(fine, surface, size, core.Progress())
        most = max(working.PER_QUAD * quads, 4000)
        assert len(made.surface.triangles) <= 1.05 * working.SLACK * most
        assert (made.fine is not None) == (len(surface.triangles) > working.SLACK * most)


@pytest.mark.slow
def test_coarse_and_fine_inputs_get_the_same_poles():
    """The same surface, of sixteen times as many triangles, is covered alike."""
    found = []
    for level in (4, 6):
        mesh = ellipsoid(subdivisions=level)
        settings = core.RemeshSettings(quads=300, relaxation=8)
        made = core.remesh(mesh.vertices, mesh.triangles, settings)
        found.append(np.sort(made.pole_valence).tolist())
        off = ((made.vertices / [3.0, 2.0, 1.0]) ** 2).sum(axis=1) - 1.0
        assert np.abs(off).max() < 0.02
    assert found[0] == found[1] == [3] * 8


@pytest.mark.slow
def test_every_long_step_asks_whether_to_stop(monkeypatch):
    """Fields without a direction of their own, too, whose matrix gets its levels once."""
    steps = (
        (laying_out, "planned_field"),
        (cross_field, "_smoothest"),
        (untangling, "first_map"),
        (untangling, "_stiffened"),
    )
    inside, asked, levels = [], Counter(), Counter()

    def watched(module, name):
        plain = getattr(module, name)

        def step(*arguments, **named):
            inside.append(name)
            try:
                return plain(*arguments, **named)
            finally:
                inside.pop()

        monkeypatch.setattr(module, name, step)

    for module, name in steps:
        watched(module, name)
    made = Multigrid.__init__

    def counted(self, matrix, progress):
        levels.update(inside)
        made(self, matrix, progress)

    monkeypatch.setattr(Multigrid, "__init__", counted)
    mesh = sphere(subdivisions=4)
    progress = core.Progress(cancelled=lambda: asked.update(inside))
    core.remesh(mesh.vertices, mesh.triangles, core.RemeshSettings(quads=300), progress)
    assert set(asked) == {name for _, name in steps}
    assert levels["_smoothest"] == 1


@pytest.mark.parametrize("facing", [True, False])
def test_points_that_threads_look_up_are_those_looked_up_at_once(monkeypatch, facing):
    mesh = ellipsoid(subdivisions=3)
    surface, _ = clean(mesh.vertices, mesh.triangles)
    closest = projection.ClosestPoints(surface.vertices, surface.triangles, surface.twin)
    points = np.random.default_rng(0).normal(scale=0.4, size=(500, 3))
    normals = points if facing else None
    at_once = closest(points, normals)
    monkeypatch.setattr(projection, "BLOCK", 37)
    for one, other in zip(closest(points, normals), at_once, strict=True):
        np.testing.assert_array_equal(one, other)


def test_triangles_of_any_size_are_found_at_the_same_cost(monkeypatch):
    """Places are exact beside a vertex far off, and no more triangles are looked at for it."""
    plain, looked_at = projection._closest, Counter()

    def counted(points, plane):
        looked_at[far] += plane[..., 0].size
        return plain(points, plane)

    monkeypatch.setattr(projection, "_closest", counted)
    for far in (1.0, 30.0, 300.0):
        random = np.random.default_rng(0)
        vertices, triangles = icosphere(3)
        vertices[0] *= far
        surface, _ = clean(vertices, triangles)
        closest = projection.ClosestPoints(surface.vertices, surface.triangles, surface.twin)
        corner = surface.vertices[surface.triangles]
        large = np.flatnonzero((surface.triangles == 0).any(axis=1))
        rows = np.concatenate([random.choice(large, 1000), random.integers(0, len(corner), 1000)])
        on = np.einsum("pk,pkc->pc", random.dirichlet(np.ones(3), len(rows)), corner[rows])
        off = on[::40] * random.uniform(0.5, 1.5, (50, 1))
        _, place = closest(np.concatenate([on, off]))
        np.testing.assert_allclose(place[: len(on)], on, atol=1e-9)
        for point, found in zip(off, place[len(on) :], strict=True):
            least = np.linalg.norm(closest_in(corner, point) - point, axis=1).min()
            assert np.linalg.norm(found - point) == pytest.approx(least, abs=1e-9)
        assert closest.faced(on, closest.normal[rows], np.full(len(on), 1e-6)).all()
    assert max(looked_at[30.0], looked_at[300.0]) < 2 * looked_at[1.0]
