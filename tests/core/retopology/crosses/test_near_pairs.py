"""Opposite poles that no quad could part leave the field; what is held and what is far stays."""

import numpy as np
import pytest
from exact_fields import surface_of
from surfaces import torus

from core.base.progress import Progress
from core.fields.directions import DirectionField
from core.fields.winding import certified_index
from core.retopology.field.agreement import with_index
from core.retopology.field.near_pairs import without_near_pairs


@pytest.fixture(scope="module")
def paired():
    """A torus with two opposite quarter poles, its crosses and the index, the poles' triangles and
    their distance."""
    mesh = torus(columns=60, rows=24)
    surface = surface_of(mesh)
    field = mesh.curvature_on(surface)
    plain = DirectionField(field.d1, field.normal, field.gap, symmetry=4)
    middle = surface.vertices[surface.triangles].mean(axis=1)
    one = len(middle) // 3
    away = np.linalg.norm(middle - middle[one], axis=1)
    two = int(np.abs(away - 0.1).argmin())
    wanted = np.zeros(len(middle))
    wanted[one], wanted[two] = 0.25, -0.25
    none = np.zeros(len(middle))
    found = with_index(surface, plain, wanted, none, np.zeros(len(plain.normal)), Progress())
    assert np.array_equal(found.index, wanted)
    return surface, found.field, found.index, (one, two), float(away[two])


def left(paired, apart, held=None):
    """The directions and index after pairs nearer than `apart` are gone."""
    surface, field, index, _, _ = paired
    sure = np.ones(len(surface.vertices))
    held = np.zeros(len(sure), bool) if held is None else held
    return without_near_pairs(surface, field, index, sure, held, apart, Progress())


def test_a_near_pair_leaves_and_far_off_nothing_changes(paired):
    surface, field, _, (one, _), distance = paired
    direction, index = left(paired, 2.0 * distance)
    assert not index.any()
    across = np.cross(field.normal, direction)
    counted = certified_index(surface, direction, across, Progress(), symmetry=4)
    assert not counted.any()
    away = np.linalg.norm(surface.vertices - surface.vertices[surface.triangles[one, 0]], axis=1)
    far = away > 1.4
    assert far.any() and np.array_equal(direction[far], field.direction[far])


def test_a_pair_farther_apart_stays(paired):
    _, field, before, _, distance = paired
    direction, index = left(paired, 0.9 * distance)
    assert np.array_equal(index, before) and direction is field.direction


def test_a_pair_on_a_feature_or_across_one_stays(paired):
    surface, field, before, (one, two), distance = paired
    on = np.zeros(len(surface.vertices), bool)
    on[surface.triangles[one, 0]] = True
    direction, index = left(paired, 2.0 * distance, on)
    assert np.array_equal(index, before) and direction is field.direction
    # All around one of them.
    middle = surface.vertices[surface.triangles].mean(axis=1)
    away = np.linalg.norm(surface.vertices - middle[one], axis=1)
    ring = (away > 0.3 * distance) & (away < 0.8 * distance)
    ring[surface.triangles[[one, two]]] = False
    direction, index = left(paired, 2.0 * distance, ring)
    assert np.array_equal(direction[ring], field.direction[ring])
