"""Single lines of curvature through the triangles, against closed forms."""

import dataclasses
from itertools import pairwise

import numpy as np
import pytest
from exact_fields import surface_of
from line_guides import guide_of
from scipy.spatial import cKDTree
from surfaces import cylinder, ellipsoid

from core.base.progress import Progress
from core.fields.planes import in_plane, lay_out
from core.retopology.lines.polylines import MOST_BEND, points_of, sparse_rows
from core.retopology.lines.tracing import BORDER, LIMIT, OBSTACLE, Obstacles, Starts, trace
from core.retopology.lines.truncation import laid


def confocal(points, axes=(3.0, 2.0, 1.0)):
    """(p, 2) ellipsoidal coordinates b^2 > l1 > c^2, a^2 > l2 > b^2 of points of an ellipsoid.

    A line of curvature is the cut with a confocal quadric: one of the two is constant on it.
    """
    a, b, c = np.square(axes)
    x, y, z = np.square(points).T
    half = 0.5 * (a + b + c - x - y - z)
    product = a * b + b * c + c * a - x * (b + c) - y * (a + c) - z * (a + b)
    root = np.sqrt(np.maximum(half**2 - product, 0.0))
    return np.stack([half - root, half + root], axis=1)


def beside(points, which, axes=(3.0, 2.0, 1.0)):
    """(p,) length by which points lie beside the cut that their line begins on, along the
    surface, to first order."""
    value = confocal(points, axes)[:, which]
    step = 1e-5
    slope = np.stack(
        [
            (confocal(points + shift) - confocal(points - shift))[:, which] / (2 * step)
            for shift in step * np.eye(3)
        ],
        axis=1,
    )
    normal = points / np.square(axes)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    slope -= np.einsum("pc,pc->p", slope, normal)[:, None] * normal
    # In the planes of symmetry the coordinates turn back, and the first order says nothing.
    steep = np.linalg.norm(slope, axis=1)
    return np.where(steep > 0.5, np.abs(value - value[0]) / steep, 0.0)


@pytest.mark.slow
@pytest.mark.parametrize("subdivisions", [4, 5, 6])
def test_lines_of_the_ellipsoid_are_cuts_with_confocal_quadrics(subdivisions):
    """Over a length of 3 all stay within half an edge, nine of ten within a fifth."""
    mesh = ellipsoid(subdivisions=subdivisions)
    surface = surface_of(mesh)
    planes = lay_out(surface, mesh.curvature_on(surface).lines, Progress())
    count = 60
    triangle = np.random.default_rng(3).integers(0, len(surface.triangles), count)
    z = planes.corner[triangle].mean(axis=1)
    family = np.arange(count) % 2
    direction = np.sqrt(planes.deviator(triangle, z) * np.where(family == 0, 1.0, -1.0))
    limit = np.full(count, 3.0) / surface.unit
    starts = Starts.plain(triangle, z, direction / np.abs(direction), family, limit)
    traces = trace(surface, planes, starts, Obstacles.none(surface), Progress())
    assert (traces.end == LIMIT).sum() >= 57  # one may lose its way in an umbilic's triangle
    points = points_of(surface, planes, traces.triangle, traces.z) * surface.unit + surface.origin
    off = []
    for line in np.flatnonzero(traces.end == LIMIT):
        # Family 0 keeps the larger of the two coordinates, family 1 the smaller.
        path = points[traces.start[line] : traces.start[line + 1]]
        # At an umbilic the two coordinates meet, and nothing can be told to first order.
        if cKDTree(mesh.umbilics.position).query(path)[0].min() < 0.3:
            continue
        off.append(beside(path, 1 - family[line]).max() / mesh.edge_length)
    assert len(off) > 40 and np.median(off) < 0.05
    assert np.quantile(off, 0.9) < 0.2 and max(off) < 0.5


def test_lines_end_at_borders_and_limits():
    mesh = cylinder()
    surface = surface_of(mesh)
    planes = lay_out(surface, mesh.curvature_on(surface).lines, Progress())
    triangle = np.arange(0, len(surface.triangles), 97)
    z = planes.corner[triangle].mean(axis=1)
    along = np.sqrt(-planes.deviator(triangle, z))
    count = len(triangle)
    free = Obstacles.none(surface)
    starts = Starts.plain(
        triangle, z, along / np.abs(along), np.ones(count), np.full(count, 100.0)
    )
    far = trace(surface, planes, starts, free, Progress())
    assert (far.end == BORDER).all()
    starts = dataclasses.replace(starts, limit=np.full(count, 1e-3))
    near = trace(surface, planes, starts, free, Progress())
    assert (near.end == LIMIT).all()
    assert near.travelled[near.start[1:] - 1] == pytest.approx(1e-3)


def test_a_line_goes_by_what_it_does_not_go_towards():
    """The last chord of one that passed an umbilic at its side turned to it by a right angle."""
    mesh = cylinder(columns=128)
    surface = surface_of(mesh)
    planes = lay_out(surface, mesh.curvature_on(surface).lines, Progress())
    middle = surface.vertices[surface.triangles].mean(axis=1)
    point, reach = (np.array([1.0, 0.0, 0.0]) - surface.origin) / surface.unit, 0.4
    away = np.linalg.norm(middle - point, axis=1) * surface.unit
    obstacle = np.where(away < reach, 0, -1)
    place = np.full(len(obstacle), complex(np.nan, np.nan))
    place[obstacle == 0] = laid(surface, np.flatnonzero(obstacle == 0), point)
    # Upwards from below, beside it by so much.
    row = np.flatnonzero(np.abs(middle[:, 2] - middle[:, 2].min()) < 1e-9)
    row = row[np.linalg.norm((middle[row] - point)[:, :2], axis=1) * surface.unit < 0.6]
    z = planes.corner[row].mean(axis=1)
    up = in_plane(surface, row, np.tile([0.0, 0.0, 1.0], (len(row), 1)))
    starts = Starts.plain(row, z, up, np.ones(len(row)), np.full(len(row), np.inf))
    every = trace(surface, planes, starts, Obstacles(obstacle), Progress())
    some = trace(surface, planes, starts, Obstacles(obstacle, place), Progress())
    beside = np.linalg.norm((middle[row] - point)[:, :2], axis=1) * surface.unit / reach
    near, far = beside < 0.8, (beside > 0.9) & (beside < 0.96)
    assert near.sum() > 8 and far.any()
    assert (every.end[near | far] == OBSTACLE).all()
    assert (some.end[near] == OBSTACLE).all() and (some.end[far] == BORDER).all()


def geodesics(surface, planes, triangle, length):
    """Straight lines from the middles of triangles, along the first axes of their planes."""
    count, z = len(triangle), planes.corner[triangle].mean(axis=1)
    limit, ahead = np.full(count, length), np.ones(count, complex)
    starts = Starts.plain(triangle, z, ahead, np.zeros(count), limit, straight=np.inf)
    return trace(surface, planes, starts, Obstacles.none(surface), Progress())


def test_points_are_left_out_only_where_the_surface_does_not_bend():
    """Lines handed on with few points cut through the folds that they went around, and seemed to
    turn there."""
    guide = guide_of("torus")
    surface, planes = guide.surface, guide.planes(Progress())
    start = np.arange(0, len(surface.triangles), 997)
    walk = geodesics(surface, planes, start, 2.0)
    rows = sparse_rows(walk, 1e9, surface)
    line = np.repeat(np.arange(len(start)), np.diff(walk.start))
    normal, most = surface.face_normal_area[0], 0.0
    for one, two in pairwise(rows):
        if line[one] == line[two]:
            # The chords in between lie in the triangles of the points after the first.
            passed = normal[walk.triangle[one + 1 : two + 1]]
            most = max(most, float(np.arccos((passed @ passed[0]).clip(-1.0, 1.0)).max()))
    assert 0.5 * MOST_BEND < most <= MOST_BEND
    assert len(rows) < 0.5 * len(line)


def test_chords_beside_a_fold_lie_in_their_triangles():
    """Over the edge of a flattened tube: points left out beside it made chords that lay in neither
    plane, and lines that went straight on seemed to turn."""
    mesh = cylinder()
    vertices = mesh.vertices * [1.0, 0.001, 1.0]
    surface = surface_of(dataclasses.replace(mesh, vertices=vertices))
    planes = lay_out(surface, mesh.curvature_on(surface).lines, Progress())
    start = np.arange(0, len(surface.triangles), 97)
    walk = geodesics(surface, planes, start, 4.0)
    normal = surface.face_normal_area[0][walk.triangle]
    bend = np.arccos(np.einsum("qc,qc->q", normal[1:], normal[:-1]).clip(-1.0, 1.0))
    bend[walk.start[1:-1] - 1] = 0.0
    fold = np.flatnonzero(bend > MOST_BEND)
    assert len(fold) > 10
    rows = sparse_rows(walk, 1e9, surface)
    # The chord before each fold, from one point to the next, and the one after it.
    assert np.isin(np.concatenate([fold - 1, fold, fold + 1]), rows).all()
    assert len(rows) < 0.5 * len(normal)
