"""The certified index: consistent over every surface, equal to the known one."""

import numpy as np
import pytest
import surfaces
from exact_fields import surface_of
from hypothesis import given, settings
from hypothesis import strategies as st

from core.base.progress import Progress
from core.curvature.from_normals import curvature_from_normals
from core.fields.winding import Winding, _by_vertex_normals, certified_index
from core.mesh.normals import vertex_normals


def test_exact_directions_give_the_true_umbilics():
    mesh = surfaces.random_ellipsoid(count=4000)
    surface = surface_of(mesh)
    field = mesh.curvature_on(surface)
    index = certified_index(surface, field.d1, field.d2, Progress())
    rows = np.flatnonzero(index)
    assert list(index[rows]) == [0.5] * 4
    centre = mesh.vertices[mesh.triangles[rows]].mean(axis=1)
    size = np.linalg.norm(np.ptp(mesh.vertices[mesh.triangles[rows]], axis=1), axis=1)
    distance = np.linalg.norm(centre[:, None] - mesh.umbilics.position[None], axis=2).min(axis=1)
    assert (distance < size).all()


@settings(max_examples=25)
@given(st.integers(0, 2**32 - 1))
def test_any_line_field_with_any_normals_sums_to_the_euler_characteristic(seed):
    random = np.random.default_rng(seed)
    for mesh, characteristic in (
        (surfaces.sphere(subdivisions=1), 2),
        (surfaces.torus(columns=9, rows=7), 0),
    ):
        surface = surface_of(mesh)
        normal = random.standard_normal(surface.vertices.shape)
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        d1 = np.cross(normal, random.standard_normal(normal.shape))
        d1 /= np.linalg.norm(d1, axis=1)[:, None]
        index = certified_index(surface, d1, np.cross(normal, d1), Progress())
        assert index.sum() == characteristic
        np.testing.assert_array_equal(2 * index, np.rint(2 * index))


def test_opposite_normals_and_flat_triangles_do_no_harm():
    mesh = surfaces.sphere(subdivisions=2)
    surface = surface_of(mesh)
    field = mesh.curvature_on(surface)
    d1, d2 = field.d1.copy(), field.d2.copy()
    d2[::3] = -d2[::3]
    assert certified_index(surface, d1, d2, Progress()).sum() == 2


@pytest.mark.parametrize("seed", range(3))
def test_renumbering_changes_nothing(seed):
    mesh = surfaces.noisy(surfaces.ellipsoid(subdivisions=3), 0.2, seed=seed)
    shuffled = surfaces.renumbered(mesh, seed=seed)
    sums = []
    for each in (mesh, shuffled):
        surface = surface_of(each)
        field = each.curvature_on(surface)
        index = certified_index(surface, field.d1, field.d2, Progress())
        sums.append(np.sort(index[index != 0]))
    np.testing.assert_array_equal(*sums)


@pytest.mark.parametrize("seed", range(5))
def test_exact_half_turns_are_shared_by_both_triangles(seed):
    """A turn of pi may be taken for one of -pi; both sides of an edge have to agree on it."""
    random = np.random.default_rng(seed)
    surface = surface_of(surfaces.sphere(subdivisions=2))
    normal = random.standard_normal(surface.vertices.shape)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    d1 = np.cross(normal, random.standard_normal(normal.shape))
    d1 /= np.linalg.norm(d1, axis=1)[:, None]
    free = np.ones(len(normal), bool)
    angle = np.zeros(len(normal))
    turns = turns_of(surface, d1, np.cross(normal, d1))
    for (tail, head), turn in zip(sides(surface), turns, strict=True):
        if free[tail] and free[head]:
            free[[tail, head]] = False
            angle[head] = 0.5 * (np.pi - turn)
    d1 = np.cos(angle)[:, None] * d1 + np.sin(angle)[:, None] * np.cross(normal, d1)
    turns = turns_of(surface, d1, np.cross(normal, d1))
    assert (np.abs(np.abs(turns) - np.pi) < 1e-12).sum() > 50
    assert certified_index(surface, d1, np.cross(normal, d1), Progress()).sum() == 2


def turns_of(surface, d1, d2):
    """The turn of a line field along each side of each triangle."""
    half_edges = np.arange(3 * len(surface.triangles))
    return Winding.of(surface, d1, d2, Progress()).turns(surface, half_edges, d1, d2)


def sides(surface):
    """The tail and the head of each side of each triangle."""
    return zip(
        surface.triangles.ravel().tolist(),
        surface.triangles[:, [1, 2, 0]].ravel().tolist(),
        strict=True,
    )


@given(st.integers(0, 1 << 30), st.sampled_from([0, 1, 40, 400]))
@settings(max_examples=20)
def test_a_winding_follows_changes_of_its_field(seed: int, changes: int) -> None:
    random = np.random.default_rng(seed)
    mesh = surfaces.noisy(surfaces.ellipsoid(subdivisions=3), 0.3 * random.random(), seed=seed)
    surface = surface_of(mesh)
    field = curvature_from_normals(surface, vertex_normals(surface))
    before = Winding.of(surface, field.d1, field.d2, Progress())
    rows = random.choice(len(field.d1), changes, replace=False)
    d1 = field.d1.copy()
    d1[rows] = field.d2[rows]
    d2 = np.cross(field.normal, d1)
    after = before.after(surface, rows, d1, d2)
    assert np.array_equal(after.index, certified_index(surface, d1, d2, Progress()))


@given(st.integers(0, 1 << 30), st.sampled_from([2, 4]), st.floats(0.0, 2.0))
@settings(max_examples=30)
def test_no_triangle_with_an_index_is_passed_over(seed: int, symmetry: int, wild: float) -> None:
    """Only triangles at edges along which the field or the normals turn much are looked at."""
    random = np.random.default_rng(seed)
    surface = surface_of(surfaces.ellipsoid(subdivisions=3))
    normal = vertex_normals(surface) + wild * random.standard_normal(surface.vertices.shape)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    smooth = np.array([1.0, 0.3, 0.2]) + wild * random.standard_normal(normal.shape)
    d1 = np.cross(normal, smooth)
    d1 /= np.linalg.norm(d1, axis=1)[:, None]
    d2 = np.cross(normal, d1)
    rows = np.arange(len(surface.triangles))
    every = _by_vertex_normals(surface, d1, d2, Progress(), symmetry, rows)
    assert every.any()
    np.testing.assert_array_equal(_by_vertex_normals(surface, d1, d2, Progress(), symmetry), every)
