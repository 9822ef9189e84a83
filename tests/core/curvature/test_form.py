"""What wide fits see of surfaces with detail at every size, and that others have no such form."""

import numpy as np
import pytest
from surfaces import ellipsoid

import core
from core.base.progress import Progress
from core.curvature.field import CurvatureField
from core.curvature.form import form_of, levels_of
from core.curvature.tolerances import INDEPENDENT
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
