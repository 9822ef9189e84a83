"""Every trace ends, whatever the mesh and the field."""

import numpy as np
import pytest
from exact_fields import surface_of
from hypothesis import given, settings
from hypothesis import strategies as st
from surfaces import ellipsoid
from surfaces.parts import divided

import core
from core.base.progress import Progress
from core.fields.directions import DirectionField
from core.fields.planes import lay_out
from core.mesh.mending.repair import clean
from core.retopology.lines.headway import MOST_TURNS, Headway
from core.retopology.lines.tracing import Obstacles, Starts, trace

# Steps of a progress that nothing of this size needs.
PATIENCE = 20_000


class Impatient(Progress):
    """Cancels after so many steps, so that a trace without end fails its test."""

    def __init__(self, steps=PATIENCE):
        self.left = steps
        super().__init__(cancelled=self._asked)

    def _asked(self):
        self.left -= 1
        return self.left < 0


def box(width=1.0):
    corners = np.array([[x, y, z] for x in (0, width) for y in (0, 1) for z in (0, 1)], float)
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return corners, np.array([t for a, b, c, d in sides for t in ((a, b, c), (a, c, d))])


def octahedron():
    corners = np.vstack([np.eye(3), -np.eye(3)])
    return corners, np.array(
        [(0, 1, 2), (1, 3, 2), (3, 4, 2), (4, 0, 2), (1, 0, 5), (3, 1, 5), (4, 3, 5), (0, 4, 5)]
    )


def bipyramid(sides=40, height=1.0):
    angle = 2 * np.pi * np.arange(sides) / sides
    rim = np.c_[np.cos(angle), np.sin(angle), 0 * angle]
    here, there = np.arange(sides), (np.arange(sides) + 1) % sides
    top, bottom = np.full(sides, sides), np.full(sides, sides + 1)
    vertices = np.vstack([rim, [0, 0, height], [0, 0, -height]])
    return vertices, np.concatenate([np.c_[here, there, top], np.c_[there, here, bottom]])


@pytest.mark.parametrize(
    "solid, times",
    [(box(), 2), (box(), 3), (box(1e-3), 2), (octahedron(), 3), (bipyramid(), 1)],
    ids=["cube", "fine cube", "plate", "octahedron", "bipyramid"],
)
def test_lines_of_solids_with_flat_faces_end(solid, times):
    vertices, triangles = solid
    for _ in range(times):
        vertices, triangles = divided(vertices, triangles)
    guide = core.Guide(vertices, triangles, core.detect(vertices, triangles))
    guide.separatrices(progress=Impatient())
    try:
        guide.lines(progress=Impatient())
    except core.GuidanceError as error:
        assert "no preferred direction" in str(error)


def test_a_line_is_lost_once_a_turn_around_a_vertex_brings_it_nowhere():
    surface = surface_of(ellipsoid(subdivisions=2))
    fan = int(np.diff(surface.neighbour_start).max())
    headway = Headway(surface, 3)
    ids, triangle = np.array([0, 2]), np.array([5, 6])
    # One that goes on and one that does not; every now and then that one does, too.
    height = surface.least_height[triangle]
    for _ in range(3):
        for _ in range(fan):
            assert not headway.lost(ids, triangle, height * (1.0, 1e-6)).any()
        assert not headway.lost(ids, triangle, height).any()
    for _ in range(fan):
        assert not headway.lost(ids, triangle, height * (1.0, 0.0)).any()
    assert headway.lost(ids, triangle, height * (1.0, 0.0)).tolist() == [False, True]


def test_no_line_takes_more_chords_than_the_mesh_has_triangles_for():
    surface = surface_of(ellipsoid(subdivisions=1))
    headway = Headway(surface, 1)
    row = np.zeros(1, np.int64)
    for _ in range(MOST_TURNS * len(surface.triangles)):
        assert not headway.lost(row, row, np.ones(1))
    assert headway.lost(row, row, np.ones(1))


@pytest.mark.slow
@settings(max_examples=40)
@given(
    seed=st.integers(0, 2**32 - 1),
    flatness=st.sampled_from([1.0, 1e-3, 1e-7]),
    solid=st.sampled_from([box(), octahedron(), bipyramid(12)]),
)
def test_no_field_on_no_mesh_makes_a_trace_without_end(seed, flatness, solid):
    random = np.random.default_rng(seed)
    vertices, triangles = divided(*divided(*solid))
    vertices = (vertices + 0.01 * random.normal(size=vertices.shape)) * (1.0, 1.0, flatness)
    surface, _ = clean(vertices, triangles)
    n, m = len(surface.vertices), len(surface.triangles)
    normal = random.normal(size=(n, 3))
    direction = np.cross(normal, random.normal(size=(n, 3)))
    normal, direction = (
        part / np.linalg.norm(part, axis=1, keepdims=True) for part in (normal, direction)
    )
    field = DirectionField(direction, normal, random.random(n))
    planes = lay_out(surface, field, Progress())
    triangle = random.integers(0, m, 20)
    z = planes.corner[triangle].mean(axis=1)
    ahead = np.exp(1j * random.uniform(0, 2 * np.pi, 20))
    # Long enough that only the mesh bounds it.
    starts = Starts.plain(triangle, z, ahead, np.arange(20) % 2, np.full(20, 1e6))
    found = trace(surface, planes, starts, Obstacles.none(surface), Impatient())
    assert np.diff(found.start).max() <= MOST_TURNS * m + 2
    assert np.isfinite(found.z).all() and np.isfinite(found.travelled).all()


@pytest.mark.once
def test_lines_ask_whether_to_stop_within_a_round():
    mesh = ellipsoid(subdivisions=5)
    guide = core.Guide(mesh.vertices, mesh.triangles, core.detect(mesh.vertices, mesh.triangles))
    asked = []
    guide.lines(progress=Progress(lambda fraction, name: asked.append((name, fraction))))
    tracing = np.array([fraction for name, fraction in asked if name == "Tracing lines"])
    # The rounds begin at these shares of the work.
    rounds = 1.0 - 0.8 * 0.85 ** np.arange(100)
    assert (np.abs(tracing[:, None] - rounds).min(axis=1) > 1e-9).sum() > 3
