"""The cross field against the minimum that it is said to be, set up and solved in another way."""

from dataclasses import replace

import numpy as np
import pytest
from exact_fields import surface_of
from scipy.linalg import eigh
from scipy.spatial.transform import Rotation
from surfaces import ellipsoid, plane, sphere

from core.base.progress import Progress
from core.fields.connection import LEAST_WEIGHT
from core.fields.transport import tangents
from core.mesh.normals import vertex_normals
from core.retopology.crosses.cross_field import cross_field
from core.retopology.crosses.smoothing import (
    FIXED_WEIGHT,
    LEAST_CONFIDENCE,
    curvature_data,
    smoothing_length,
)
from core.retopology.features import Features
from core.retopology.settings import GuidanceSettings

NO_CRESTS = (np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros(0))


def features(half_edges=(), crests=NO_CRESTS):
    edge = np.sort(np.asarray(half_edges, np.int64))
    return Features(edge, np.ones(len(edge), np.int8), np.full(len(edge), -1), *crests)


def watched():
    """Progress that fails where it runs backwards or beyond its end."""
    last = [0.0]

    def report(fraction, _name):
        assert last[0] - 1e-9 <= fraction <= 1.0 + 1e-9
        last[0] = fraction

    return Progress(report)


def fourth(e1, e2, vectors):
    value = (vectors * e1).sum(axis=-1) + 1j * (vectors * e2).sum(axis=-1)
    return (value / np.abs(value)) ** 4


def carried(vectors, source, target):
    """Tangent vectors (r, 3) turned by the smallest rotations from normals to others."""
    axis = np.cross(source, target)
    sine = np.linalg.norm(axis, axis=1, keepdims=True)
    turn = np.arctan2(sine[:, 0], (source * target).sum(axis=1))
    return Rotation.from_rotvec(turn[:, None] * axis / np.maximum(sine, 1e-300)).apply(vectors)


def laplacian(surface, normal):
    """Dense (n, n): half the sums of cotangents, fourth powers carried along edges."""
    e1, e2 = tangents(normal)
    place, n = surface.vertices, len(normal)
    weight, matrix = np.zeros((n, n)), np.zeros((n, n), complex)
    for k in range(3):
        a, b, c = np.roll(surface.triangles, -k, axis=1).T
        one, two = place[a] - place[c], place[b] - place[c]
        area = np.linalg.norm(np.cross(one, two), axis=1)
        cotangent = (one * two).sum(axis=1) / area
        np.add.at(weight, (a, b), 0.5 * cotangent)
        np.add.at(weight, (b, a), 0.5 * cotangent)
    a, b = np.nonzero(weight)
    size = np.maximum(weight[a, b], LEAST_WEIGHT)
    matrix[a, b] = -size * fourth(e1[a], e2[a], carried(e1[b], normal[b], normal[a]))
    np.add.at(matrix, (a, a), size)
    return matrix


def areas(surface):
    area = surface.face_normal_area[1] / 3.0
    return np.bincount(surface.triangles.ravel(), np.repeat(area, 3))


def powers(cross):
    """(n,) the field as fourth powers in the frames of its normals."""
    return cross.strength * fourth(*tangents(cross.normal), cross.direction)


def doubtful(field, confidence):
    """The field with errors that make its directions so much believed everywhere."""
    gap = 0.1 + np.zeros(len(field.k1))
    doubt = np.sqrt(1.0 / confidence - 1.0 - 0.15**2) / 4.0
    mean = 0.5 * (field.k1 + field.k2)
    return replace(field, k1=mean + 0.5 * gap, k2=mean - 0.5 * gap, noise=doubt * gap)


@pytest.fixture(scope="module")
def small():
    mesh = ellipsoid((1.6, 1.3, 1.0), subdivisions=3)
    surface = surface_of(mesh)
    return surface, mesh.curvature_on(surface)


@pytest.mark.parametrize("held", [False, True], ids=["free", "held"])
@pytest.mark.parametrize("smoothness", [0.65, 0.8])
def test_it_is_the_minimum_of_its_energy(small, smoothness, held):
    surface, field = small
    tail = surface.triangles.ravel()
    head = np.roll(surface.triangles, -1, axis=1).ravel()
    # Two that meet and agree in part only, and one alone.
    edges = np.array([300, 301, 1205] if held else [], int)
    cross = cross_field(
        surface, field, GuidanceSettings(smoothness=smoothness), watched(), features=features(edges)
    )
    on = np.unique([tail[edges], head[edges]])
    normal = field.normal.copy()
    normal[on] = vertex_normals(surface)[on]
    e1, e2 = tangents(normal)
    axis = np.ascontiguousarray((e1 + 1j * e2).T)
    confidence, data = curvature_data(surface, field, normal, axis, None, 4)
    length = smoothing_length(surface, smoothness)
    matrix = laplacian(surface, normal)
    weight = np.maximum(confidence, LEAST_CONFIDENCE) * areas(surface) / length**2
    for vertex in on:
        at = edges[(tail[edges] == vertex) | (head[edges] == vertex)]
        along = surface.vertices[head[at]] - surface.vertices[tail[at]]
        wanted = fourth(e1[vertex], e2[vertex], along).mean()
        confidence[vertex], data[vertex] = abs(wanted), wanted / abs(wanted)
        weight[vertex] = FIXED_WEIGHT * matrix[vertex, vertex].real * abs(wanted)
    least = np.linalg.solve(matrix + np.diag(weight), weight * data)
    assert np.abs(cross.normal - normal).max() < 1e-12
    # No two poles are near enough to be taken together after the solution.
    assert np.abs(powers(cross) - least).max() < 1e-3
    assert np.allclose(cross.confidence, confidence)
    assert np.isclose(cross.smoothing, length)


def test_triangles_have_the_mean_of_their_corners(small):
    surface, field = small
    cross = cross_field(surface, field, GuidanceSettings(), watched(), features=features())
    normal, corner = surface.face_normal_area[0], surface.vertices[surface.triangles]
    x = corner[:, 1] - corner[:, 0]
    x /= np.linalg.norm(x, axis=1)[:, None]
    y = np.cross(normal, x)
    mean = sum(
        cross.strength[v] * fourth(x, y, carried(cross.direction[v], cross.normal[v], normal))
        for v in surface.triangles.T
    )
    own = fourth(x, y, cross.face_direction)
    assert np.abs(own - mean / np.abs(mean)).max() < 1e-6


def test_crests_pull_and_yield_to_what_pulls_there():
    """Amid vertices that are held along the axes a crest turns the field, by less than half."""
    surface = surface_of(plane())
    field = plane().curvature_on(surface)
    middle = int(np.linalg.norm(surface.vertices[:, :2], axis=1).argmin())
    tail = surface.triangles.ravel()
    head = np.roll(surface.triangles, -1, axis=1).ravel()
    straight = (np.abs(surface.vertices[head] - surface.vertices[tail]) < 1e-9).sum(axis=1) == 2
    held = np.flatnonzero(straight & (tail != middle) & (head != middle))
    angle = np.radians(20.0)
    across = np.array([[np.cos(angle), np.sin(angle), 0.0]])
    turned = []
    for weight in (0.0, 0.5, 1.0):
        crests = np.array([middle]), across, np.array([weight])
        cross = cross_field(
            surface, field, GuidanceSettings(), watched(), features=features(held, crests)
        )
        x, y, _ = cross.direction[middle]
        turned.append((np.degrees(np.arctan2(y, x)) + 45.0) % 90.0 - 45.0)
    assert abs(turned[0]) < 1e-6
    assert 1.0 < turned[1] < turned[2] < 10.0


@pytest.mark.parametrize("confidence", [5e-3, 2e-4, 0.0])
def test_without_directions_it_is_the_smoothest(confidence):
    """A closed surface with hardly any direction takes the smoothest field, in the sense of the
    Laplacian's least eigenvalue; with a little more the directions decide."""
    mesh = sphere(subdivisions=2)
    surface = surface_of(mesh)
    x = np.cross(mesh.normal[surface.source_vertex], [0.3, 0.5, 0.8])
    d1 = x / np.linalg.norm(x, axis=1)[:, None]
    exact = mesh.curvature_on(surface)
    field = replace(exact, d1=d1, d2=np.cross(exact.normal, d1))
    cross = cross_field(
        surface,
        doubtful(field, confidence or 2e-4),
        GuidanceSettings(smoothness=0.0),
        watched(),
        features=features(),
        undirected=np.full(len(surface.triangles), confidence == 0.0),
    )
    assert np.allclose(cross.confidence, confidence)
    away = np.abs((cross.direction * d1).sum(axis=1))
    follows = np.maximum(away, np.sqrt(1.0 - np.minimum(away, 1.0) ** 2)) > np.cos(np.radians(2.0))
    u, matrix, area = powers(cross), laplacian(surface, field.normal), areas(surface)
    smooth = (u.conj() @ matrix @ u).real / (area @ np.abs(u) ** 2)
    least = eigh(matrix, np.diag(area), eigvals_only=True, subset_by_index=[0, 0])[0]
    if confidence > 1e-3:
        assert follows.mean() > 0.75
    else:
        assert smooth < 1.01 * least
        assert np.isclose(np.abs(u).mean(), 1.0)
