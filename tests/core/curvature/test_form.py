"""What wide fits see of surfaces with detail at every size, and that others have no such form."""

from dataclasses import replace

import numpy as np
import pytest
from surfaces import ellipsoid

import core
from core.base.progress import Progress
from core.curvature.field import CurvatureField
from core.curvature.form import form_of, levels_of
from core.curvature.tolerances import INDEPENDENT
from core.fields.transport import tangents
from core.mesh.mending.repair import clean
from core.mesh.normals import vertex_normals

LEVEL = 5
OCTAVES = 5


def rough(seed, size=0.03, octaves=OCTAVES):
    """Vertices and triangles of an ellipsoid with waves of ever half the length and about a third
    of the height, whose curvature is that much larger at every size."""
    made = ellipsoid((1.5, 1.2, 1.0), LEVEL)
    random, heights = np.random.default_rng(seed), np.zeros(len(made.vertices))
    for octave in range(octaves):
        for _ in range(8):
            way = random.normal(size=3)
            way *= 3.0 * 2.0**octave / np.linalg.norm(way)
            waves = np.sin(made.vertices @ way + random.uniform(0.0, 2.0 * np.pi))
            heights += size * 0.35**octave * waves
    away = made.vertices / np.linalg.norm(made.vertices, axis=1, keepdims=True)
    return made.vertices + heights[:, None] * away, made.triangles


def horned(vertices, length):
    """The vertices with a horn of that length along the last axis."""
    away = vertices / np.linalg.norm(vertices, axis=1, keepdims=True)
    angle = np.arccos(np.clip(away[:, 2], -1.0, 1.0))
    return vertices + (length * np.exp(-np.square(angle / 0.3)))[:, None] * away


def found(vertices, triangles):
    surface, _ = clean(vertices, triangles)
    curvature = core.detect(vertices, triangles).curvature
    values = {
        name: value * (surface.unit if value.ndim == 1 else 1.0)
        for name, value in vars(curvature).items()
    }
    levels = levels_of(surface, vertex_normals(surface), Progress())
    field, radius = CurvatureField(**values), np.zeros(len(surface.vertices))
    return form_of(surface, levels, field, radius, Progress()) if levels else None


def test_a_surface_with_a_size_of_its_own_has_no_form():
    made = ellipsoid((1.5, 1.2, 1.0), LEVEL)
    assert found(made.vertices, made.triangles) is None


@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("octaves", [2, 3])
def test_a_surface_whose_detail_ends_has_a_size_of_its_own(seed, octaves):
    assert found(*rough(seed, octaves=octaves)) is None


@pytest.mark.parametrize("seed", [0, 1])
def test_where_the_surface_turns_too_far_narrower_fits_of_the_form_see_it(seed):
    vertices, triangles = rough(seed)
    form = found(horned(vertices, 0.6), triangles)
    assert form is not None
    tip = vertices[:, 2] > np.cos(0.1) * np.linalg.norm(vertices, axis=1)
    assert form.share[tip].mean() > 0.95


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_border_leaves_out_what_lies_within_a_fit_of_it_and_nothing_else(seed):
    vertices, triangles = rough(seed)
    inner = triangles[vertices[triangles][:, :, 2].min(axis=1) > -0.3]
    used, place = np.unique(inner, return_inverse=True)
    vertices, triangles = vertices[used], place.reshape(inner.shape)
    form = found(vertices, triangles)
    surface, _ = clean(vertices, triangles)
    rim = surface.vertices[surface.border] * surface.unit + surface.origin
    raw = core.detect(vertices, triangles).candidates
    raw = raw.select(raw.resolved)
    away = np.linalg.norm(raw.position[:, None] - rim, axis=2).min(axis=1)
    reach = form.widest * surface.unit
    assert raw.at_border[away < 0.95 * reach].all()
    assert not raw.at_border[away > 1.05 * reach].any()


@pytest.mark.parametrize("seed", [0, 1])
def test_detail_at_every_size_has_a_form(seed):
    form = found(*rough(seed))
    assert form is not None
    assert form.share.mean() > 0.5


@pytest.mark.parametrize("seed", [0, 1])
def test_umbilics_of_the_form_balance_and_none_is_certain(seed):
    detection = core.detect(*rough(seed))
    assert detection.index_sum == 2.0
    assert not detection.umbilics.certain.any()
    turning = detection.triangle_index[detection.umbilics.triangle]
    assert (turning == detection.umbilics.index).all()


def looked_at(vertices, triangles):
    """The surface and its vertex normals."""
    surface, _ = clean(vertices, triangles)
    return surface, vertex_normals(surface)


def test_levels_begin_where_the_surface_turns_little_enough(monkeypatch):
    surface, normals = looked_at(*rough(0))
    usual = [level.radius for level in levels_of(surface, normals, Progress())]
    assert len(usual) == 3
    # Between what this body turns within the widest and the next radius.
    monkeypatch.setattr("core.curvature.form.MOST_TURN", 0.22)
    levels = levels_of(surface, normals, Progress())
    assert [level.radius for level in levels] == usual[1:]


def form_over_cylinders(surface, normals, levels):
    """The form of a surface whose own shape operators are those of cylinders, without errors."""
    n = len(normals)
    own = CurvatureField(np.ones(n), np.zeros(n), *tangents(normals), normals, np.zeros(n))
    return form_of(surface, levels, own, np.zeros(n), Progress())


def test_errors_of_the_form_are_what_its_change_says():
    surface, normals = looked_at(*rough(0))
    levels = levels_of(surface, normals, Progress())
    wider = [replace(level, factor=2.0 * level.factor) for level in levels]
    one, two = (
        form_over_cylinders(surface, normals, some).field.noise for some in (levels, wider)
    )
    assert np.median(one) > 0.0
    np.testing.assert_allclose(two, 2.0 * one)


def test_wide_fits_say_nothing_of_what_faces_another_way():
    surface, normals = looked_at(*rough(0))
    levels = levels_of(surface, normals, Progress())
    turned = np.arange(0, len(normals), 50)
    other = normals.copy()
    other[turned] *= -1.0
    share = form_over_cylinders(surface, other, levels).share
    assert (share[turned] == 0.0).all()
    usual = form_over_cylinders(surface, normals, levels).share
    assert (usual[turned] > 0.0).any()
    usual[turned] = 0.0
    np.testing.assert_array_equal(share, usual)


@pytest.mark.parametrize("seed", [0, 1])
def test_the_other_side_of_a_thin_body_is_none_of_what_fits_see(seed):
    """With it the change would rise at the rim as it does where a surface has a size."""
    vertices, triangles = rough(seed)
    levels = levels_of(*looked_at(vertices * [1.0, 1.0, 0.15], triangles), Progress())
    assert levels and levels[0].sees_detail


@pytest.mark.parametrize("horn", [0.0, 0.6])
@pytest.mark.parametrize("seed", [0, 1])
def test_opposite_umbilics_of_the_form_are_as_far_apart_as_independent_fits(seed, horn):
    vertices, triangles = rough(seed, 0.1)
    vertices = horned(vertices, horn)
    form = found(vertices, triangles)
    surface, _ = clean(vertices, triangles)
    raw = core.detect(vertices, triangles).umbilics
    corners = surface.triangles[raw.triangle]
    places = surface.vertices[corners].mean(axis=1)
    reach = INDEPENDENT * form.radius[corners].mean(axis=1)
    apart = np.linalg.norm(places[:, None] - places, axis=2)
    opposite = raw.index[:, None] * raw.index < 0.0
    assert opposite.any()
    assert (apart > np.minimum(reach[:, None], reach))[opposite].all()
