"""The alternative to one scale does what it is measured as, and leaves no trace."""

from __future__ import annotations

import numpy as np
import surfaces

from benchmarks.accuracy import measure
from benchmarks.cases import GRADED, make
from benchmarks.scale import CONSTANT, EVERYWHERE, HALF, summary, table
from benchmarks.scale_per_vertex import Neighbourhoods, scale_per_vertex
from core.base.progress import Progress
from core.base.settings import Settings
from core.curvature import estimate as curvature
from core.mesh.neighbourhoods import Neighbourhood
from core.mesh.repair import clean


def test_each_half_gets_its_own_scale():
    ball = surfaces.random_ellipsoid(6000, (1.3, 1.0, 0.8), 0)
    vertices, noisy = ball.vertices.copy(), ball.vertices[:, 0] > 0
    shift = np.random.default_rng(0).normal(size=vertices.shape)
    vertices[noisy] += 0.003 * shift[noisy]
    surface, _ = clean(vertices, ball.triangles)
    with scale_per_vertex():
        each = curvature.estimate(surface, Settings(), None, None, Progress())
    assert isinstance(each.neighbourhood, Neighbourhoods)
    x = vertices[surface.source_vertex, 0]
    number = each.neighbourhood.number
    assert np.median(number[x < -0.5]) == 0
    assert np.median(number[x > 0.5]) >= 2
    assert each.radius[x > 0.5].mean() > 1.5 * each.radius[x < -0.5].mean()
    one = curvature.estimate(surface, Settings(), None, None, Progress())
    assert isinstance(one.neighbourhood, Neighbourhood)


def test_graded_meshes_are_denser_at_one_end():
    case = make("ellipsoid 3 2 1", GRADED, 0)
    edge, x = case.edge_at(case.vertices), case.vertices[:, 0]
    assert edge[x < -2.5].mean() > 3.0 * edge[x > 2.5].mean()
    same = case.with_noise(0.05, 1, np.median(edge) / edge)
    moved = np.linalg.norm(same.vertices - case.vertices, axis=1)
    assert 0.9 < moved[x < 0].mean() / moved[x > 0].mean() < 1.1


def test_the_table_adds_seeds_up():
    row = measure(make("torus", "regular", 0), None)
    patch = measure(make("patch", "regular", 0), None)
    text = table(
        {
            (EVERYWHERE, "torus", 0.0): [(row, row)] * 2,
            (HALF, "torus", 0.05): [(row, row)],
            (CONSTANT, "patch", 0.0): [(patch, row)] * 2,
        }
    )
    assert "| torus | everywhere alike | 0 | 0 | 0 | 0 |  | 0 | 0 |  |" in text
    error = f"{patch.ours.mean_error:.2f}"
    assert f"| patch | {CONSTANT} | 0 | 6 | 6 | 0 | {error} | 0 | 0 |  |" in text
    sentence = summary([(patch, row)])
    assert "finds 3 of 3 with 0 false ones, a scale of each vertex 0 of 3 with 0." in sentence
