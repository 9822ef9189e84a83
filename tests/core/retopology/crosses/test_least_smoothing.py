"""A cross field is smoothed no more than saves poles; what saves none only turns it away."""

import numpy as np
import pytest
from exact_fields import surface_of
from surfaces import ellipsoid, quartic

import core
from core.base.progress import Progress
from core.fields.connection import weights_and_areas
from core.mesh.mending.repair import clean
from core.retopology.crosses.least_smoothing import QUAD_EDGE, Smoothed, least_smoothed
from core.retopology.crosses.smoothing import smoothing_lengths


def wavy_torus(columns=60, rows=24):
    """A torus whose tube swells and shrinks along a spiral; it has no pole at any smoothness."""
    u, v = 2 * np.pi * np.arange(columns) / columns, 2 * np.pi * np.arange(rows) / rows
    u, v = np.meshgrid(u, v, indexing="ij")
    tube = 0.8 * (1 + 0.1 * np.cos(3 * u + 2 * v))
    away = 2 + tube * np.cos(v)
    points = np.stack([away * np.cos(u), away * np.sin(u), tube * np.sin(v)], axis=-1)
    i, j = np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij")

    def at(di, dj):
        return ((i + di) % columns * rows + (j + dj) % rows).ravel()

    a, b, c, d = at(0, 0), at(1, 0), at(1, 1), at(0, 1)
    triangles = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return points.reshape(-1, 3), triangles


def planned(vertices, triangles, **settings):
    """A guide and what is planned by it."""
    guide = core.Guide(vertices, triangles, core.detect(vertices, triangles))
    return guide, guide.guidance(core.GuidanceSettings(**settings))


def mean_angle(guide, guidance):
    """Degrees between the crosses and the measured directions."""
    cosine = np.abs(np.einsum("nc,nc->n", guidance.direction, guide.detection.curvature.d1))
    angle = np.degrees(np.arccos(cosine.clip(0, 1)))
    return float(np.minimum(angle, 90 - angle).mean())


def test_what_costs_no_pole_follows_the_curvature_closer():
    guide, found = planned(*wavy_torus())
    usual = guide.guidance(core.GuidanceSettings(smoothness=0.45))
    assert len(found.poles) == len(usual.poles) == 0
    assert mean_angle(guide, found) < 0.5 * mean_angle(guide, usual)


@pytest.mark.slow
@pytest.mark.parametrize("mesh", [quartic(), ellipsoid(subdivisions=4)], ids=["poles", "nothing"])
def test_smoothed_as_usual_where_less_brings_poles_or_is_not_seen(mesh):
    guide, found = planned(mesh.vertices, mesh.triangles)
    usual = guide.guidance(core.GuidanceSettings(smoothness=0.45))
    assert np.array_equal(found.direction, usual.direction)


def test_strokes_change_the_smoothing_nowhere():
    vertices, triangles = wavy_torus()
    guide, plain = planned(vertices, triangles)
    # A stroke across both families, around a part of the tube.
    rows = np.arange(6) * 25
    strokes = core.Strokes(np.array([0, 6]), vertices[rows], np.array([0.3]))
    drawn = guide.guidance(strokes=strokes)
    far = np.linalg.norm(vertices[:, None] - vertices[rows], axis=2).min(axis=1) > 2.0
    assert np.abs(np.einsum("nc,nc->n", plain.direction, drawn.direction)[far]).min() > 0.99
    assert np.abs(np.einsum("nc,nc->n", plain.direction, drawn.direction)).min() < 0.9


def test_every_component_has_its_own_smoothing():
    one = ellipsoid(subdivisions=4)
    parts = 4
    vertices = np.concatenate([one.vertices + np.array([10.0 * k, 0.0, 0.0]) for k in range(parts)])
    triangles = np.concatenate([one.triangles + k * len(one.vertices) for k in range(parts)])
    surface, _ = clean(vertices, triangles)
    m, n = len(one.triangles), len(one.vertices)
    of = surface.component[np.arange(parts) * n]
    edge = smoothing_lengths(surface, weights_and_areas(surface)[1], QUAD_EDGE)
    # More poles, as many, as many too near each other, as many and no nearer to the curvature.
    far = np.array([0, m // 3, m // 2])
    asked = []

    def smoothed(length, _):
        ratio = float(np.median(length / edge))
        asked.append(ratio)
        less = ratio < 1.4
        index = np.zeros(len(surface.triangles))
        angle = np.full(len(surface.vertices), 1.0 if less else 4.0)
        for k in range(parts):
            index[k * m + far] = 0.25
            angle[surface.component == of[k]] += 0.0 if k < 3 or not less else 3.0
        if less:
            index[0 * m + m // 4] = 0.25
            index[2 * m + far[0]], index[2 * m + neighbour(surface, 2 * m + far[0])] = 0.25, -0.25
            index[2 * m + far[1]] = 0.0
        return Smoothed(
            np.full((len(angle), 3), ratio), np.full(len(angle), ratio), index, length, angle
        )

    def neighbour(surface, triangle):
        return surface.twin[3 * triangle] // 3 - 2 * m

    found = least_smoothed(surface, smoothed, np.ones(len(surface.vertices)), Progress())
    ratio = [float(found.strength[surface.component == of[k]].mean()) for k in range(parts)]
    assert ratio == pytest.approx([asked[0], 0.5, asked[0], asked[0]])
    assert asked[0] > 1.4 and asked[1:] == pytest.approx([0.5, 0.7, 1.0])
    assert found.index[m + far].tolist() == [0.25] * 3
    assert np.allclose(found.length / edge, np.array(ratio)[np.argsort(of)][surface.component])


def test_what_all_components_take_is_looked_for_no_further():
    surface = surface_of(ellipsoid(subdivisions=2))
    asked = []

    def smoothed(length, _):
        asked.append(length)
        size = len(surface.vertices)
        angle = np.full(size, 4.0 - len(asked))
        return Smoothed(
            np.zeros((size, 3)), np.zeros(size), np.zeros(len(surface.triangles)), length, angle
        )

    found = least_smoothed(surface, smoothed, np.ones(len(surface.vertices)), Progress())
    assert len(asked) == 2 and np.array_equal(found.length, asked[1])
