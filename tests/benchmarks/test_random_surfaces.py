"""Surfaces of benchmarks/quads --random that once broke a guarantee."""

import numpy as np

import core
from benchmarks.random_surfaces import random_surface
from core.retopology.quads.conformity import conformity, scaled_jacobian
from core.retopology.quads.layout.counting import grids_of_about
from core.retopology.quads.preparation import Given, prepare


def test_creases_end_where_quads_fit_around():
    """Poles that moved had left a single right angle around the end of a crease."""
    _, vertices, triangles, quads = random_surface(134)
    detection = core.detect(vertices, triangles)
    given = Given(triangles, detection, None, None, None, None)
    guide = core.Guide(vertices, triangles, detection)
    laid = prepare(guide, given, core.RemeshSettings(quads=quads), core.Progress()).parts
    made = grids_of_about(laid, quads, core.Progress())
    found = conformity(made[0].merged[made[0].quads], int(made[0].merged.max()) + 1)
    assert found.manifold and found.characteristic == laid[0].working.surface.euler_characteristic
    assert abs(len(made[0].quads) / quads - 1.0) < 0.03


def test_chance_creases_are_no_features():
    """Edges along tubes of few triangles around bend as far as creases do here and there."""
    _, vertices, triangles, quads = random_surface(78)
    made = core.remesh(vertices, triangles, core.RemeshSettings(quads=quads))
    assert scaled_jacobian(made.vertices, made.quads).min() > 0.5
    assert np.nanmean(made.angle) < 8.0
