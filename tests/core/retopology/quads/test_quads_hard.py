"""Quads on shapes that maps are hard to find for: creases all around, few large faces, caps."""

import hypothesis
import numpy as np
import pytest
from hypothesis.strategies import floats, integers
from quad_guarantees import holds
from quad_surfaces import bumpy, cube, plain, with_needles
from scipy import sparse
from surfaces import cylinder, ellipsoid

import core
from core.base.progress import Progress
from core.fields.multigrid import solve_part
from core.mesh.mending.repair import clean
from core.retopology.quads.conformity import conformity, torn
from core.retopology.quads.layout import giving_way, laying_out
from core.retopology.quads.layout import integers as integers_
from core.retopology.quads.preparation import Given, prepare
from core.retopology.quads.surface.flipping import flipped
from core.retopology.quads.surface.subdivision import CREASE_BIT, Triangles

FEW = (hypothesis.Phase.explicit, hypothesis.Phase.generate)


def lathe(profile, segments=24):
    """A closed surface of revolution about z: a profile of (radius, height) between two points on
    the axis, turned, its rings and segments joined by triangles."""
    profile = np.asarray(profile, float)
    angle = 2.0 * np.pi * np.arange(segments) / segments
    ring = np.stack([np.cos(angle), np.sin(angle), np.ones(segments)], axis=1)
    points = (ring[None] * profile[1:-1, [0, 0, 1]][:, None]).reshape(-1, 3)
    row = np.arange(len(points)).reshape(-1, segments)
    beside = np.roll(row, -1, axis=1)
    ends = len(points), len(points) + 1
    triangles = [
        np.stack([row[:-1], beside[:-1], beside[1:]], axis=-1).reshape(-1, 3),
        np.stack([row[:-1], beside[1:], row[1:]], axis=-1).reshape(-1, 3),
        np.stack([np.full(segments, ends[0]), beside[0], row[0]], axis=-1),
        np.stack([np.full(segments, ends[1]), row[-1], beside[-1]], axis=-1),
    ]
    tips = np.array([[0.0, 0.0, profile[0, 1]], [0.0, 0.0, profile[-1, 1]]])
    return np.concatenate([points, tips]), np.concatenate(triangles)


def goblet(stem, bowl):
    """A foot, a grooved stem and a lip: creases all around, one above the other."""
    return [
        (0, -1),
        (0.45, -1),
        (0.9, -1),
        (0.9, -0.9),
        (0.5, -0.75),
        (stem, -0.6),
        (stem + 0.1, -0.5),
        (stem + 0.1, -0.4),
        (stem, -0.3),
        (stem, -0.1),
        (bowl, 0.4),
        (bowl + 0.05, 0.7),
        (bowl + 0.2, 0.9),
        (bowl + 0.2, 1.0),
        (0.4, 1.0),
        (0, 1),
    ]


def off_features(surface, features, direction):
    """Degrees that crosses in the triangles beside features are off their edges."""
    edge = features.half_edge
    edge = np.concatenate([edge, surface.twin[edge][surface.twin[edge] >= 0]])
    face, side = edge // 3, edge % 3
    corner = surface.vertices[surface.triangles]
    along = corner[face, (side + 1) % 3] - corner[face, side]
    across = np.cross(surface.face_normal_area[0][face], direction[face])
    turn = np.arctan2(
        np.einsum("ec,ec->e", along, across), np.einsum("ec,ec->e", along, direction[face])
    )
    return np.abs((np.degrees(turn) + 45.0) % 90.0 - 45.0)


def test_poles_that_move_leave_crosses_along_features():
    """Poles wanted on the foot of a goblet: the field between its creases keeps to them."""
    vertices, triangles = lathe(goblet(0.3, 0.6))
    guide = core.Guide(vertices, triangles, core.detect(vertices, triangles))
    angle = 0.25 * np.pi * np.arange(8)
    place = np.stack([0.6 * np.cos(angle), 0.6 * np.sin(angle), np.full(8, -1.0)], axis=1)
    wanted = core.WantedPoles(place, np.full(8, 3))
    made = guide.guidance(wanted=wanted)
    direction = made.face_direction[guide.surface.source_triangle]
    off = off_features(guide.surface, guide.features(), direction)
    assert len(off) > 100 and np.quantile(off, 0.95) < 15.0


@hypothesis.settings(max_examples=3, deadline=None, derandomize=True, phases=FEW)
@hypothesis.given(
    stem=floats(0.15, 0.4),
    bowl=floats(0.45, 0.7),
    segments=integers(16, 32),
    quads=integers(300, 600),
)
@pytest.mark.slow
def test_turned_pieces_have_few_poles(stem, bowl, segments, quads):
    vertices, triangles = lathe(goblet(stem, bowl), segments)
    made = core.remesh(vertices, triangles, core.RemeshSettings(quads=quads))
    holds(vertices, triangles, made)
    assert len(made.pole_valence) <= 24
    assert not any("No layout" in sentence for sentence in made.warnings)


def bracket():
    """A solid of the shape of an L out of as few triangles as its faces have, caps among them."""
    outline = [(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)]
    # The corner at (1, 1) lies on the longest side of no triangle; (0, 1.5) on that of one.
    outline.insert(6, (0, 1.5))
    n = len(outline)
    points = np.array([(x, y, z) for z in (0.0, 1.0) for x, y in outline], float)
    # One side of the L: fans that leave a cap at the corner which lies on an edge.
    face = [(0, 1, 2), (0, 2, 3), (0, 3, 5), (3, 4, 5), (0, 5, 6)]
    triangles = [(a, c, b) for a, b, c in face] + [(a + n, b + n, c + n) for a, b, c in face]
    for a in range(n):
        b = (a + 1) % n
        triangles += [(a, b, b + n), (a, b + n, a + n)]
    return points, np.array(triangles)


@pytest.mark.slow
def test_flat_faces_have_no_poles_inside():
    """Between the few corners of large faces no fit touches the surface: what it says there is no
    direction, and its normals do not turn the field."""
    vertices, triangles = bracket()
    made = core.remesh(vertices, triangles, core.RemeshSettings(quads=400))
    holds(vertices, triangles, made, 400)
    assert len(made.pole_valence) <= 14
    pole = made.vertices[made.pole >= 0]
    corner = np.linalg.norm(pole[:, None] - vertices[None], axis=2).min(axis=1)
    side = np.linalg.norm(made.vertices[made.quads[:, 1]] - made.vertices[made.quads[:, 0]], axis=1)
    assert corner.max() < np.median(side)


def test_flips_open_caps_and_keep_the_surface():
    vertices, triangles = bracket()
    mesh = as_triangles(vertices, triangles)
    # A feature along the longest side of the cap, which its corner lies on.
    on = (np.sort(np.stack(mesh.ends), axis=0) == [[0], [5]]).all(axis=0)
    assert on.sum() == 2
    mesh = as_triangles(vertices, triangles, on)
    made = flipped(mesh)
    assert np.array_equal(made.vertices, vertices)
    assert smallest_angle(mesh) < 1e-9 < 0.2 < smallest_angle(made)
    assert np.isclose(volume(made), volume(mesh)) and np.isclose(volume(made), 5.0)
    assert np.isclose(made.lengths[made.feature > 0].sum(), mesh.lengths[on].sum())
    assert np.count_nonzero(made.feature) == 4
    surface, warnings = clean(made.vertices, made.triangles)
    assert surface.closed.all() and not len(warnings)
    twin = made.feature[surface.twin]
    assert np.array_equal(made.feature, twin)


def test_curved_surfaces_are_not_flipped():
    vertices, triangles = bumpy(4, level=3)
    mesh = as_triangles(vertices, triangles)
    assert np.array_equal(flipped(mesh).triangles, mesh.triangles)


def test_two_triangles_in_a_plane_are_no_flat_face():
    """A roof of two flat sides, each cut along its longer diagonal, as marching cubes have."""
    x, y, z = np.meshgrid([0.0, 1.0], [0.0, 1.0, 2.0], [0.0], indexing="ij")
    vertices = np.stack([x.ravel() + 0.5 * y.ravel(), y.ravel(), z.ravel()], axis=1)
    vertices[vertices[:, 1] == 1.0, 2] = 0.5
    a, b = np.array([0, 1]), np.array([3, 4])
    triangles = np.concatenate([np.stack([a, b, b + 1], 1), np.stack([a, b + 1, a + 1], 1)])
    mesh = as_triangles(vertices, triangles)
    assert np.array_equal(flipped(mesh).triangles, mesh.triangles)
    # In one plane the four of them are one.
    flat = as_triangles(vertices * (1.0, 1.0, 0.0), triangles)
    assert smallest_angle(flipped(flat)) > smallest_angle(flat)


def as_triangles(vertices, triangles, feature=None):
    kind = np.zeros(3 * len(triangles), np.int8)
    if feature is not None:
        kind[feature] = CREASE_BIT
    m = len(triangles)
    return Triangles(
        vertices, np.asarray(triangles, np.int64), np.zeros((len(vertices), 0)), np.arange(m), kind
    )


def smallest_angle(mesh):
    at = mesh.vertices[mesh.triangles]
    out, back = np.roll(at, -1, axis=1) - at, np.roll(at, 1, axis=1) - at
    sine = np.linalg.norm(np.cross(out, back), axis=2)
    return float(np.arctan2(sine, np.einsum("mkc,mkc->mk", out, back)).min())


def volume(mesh):
    a, b, c = (mesh.vertices[mesh.triangles[:, k]] for k in range(3))
    return float(np.einsum("mc,mc->", np.cross(a, b), c)) / 6.0


@pytest.mark.slow
def test_a_blunt_triangle_gets_quads_and_not_cut_triangles():
    """Two corners are sharper than half a right angle: their poles lie near those of the field."""
    vertices = np.array([[-3.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 2.0, 1.5]])
    at = np.linspace(0.0, 1.0, 7)
    rows = [(i, j) for i in range(7) for j in range(7 - i)]
    number = {pair: row for row, pair in enumerate(rows)}
    points = np.array(
        [
            vertices[0] + at[i] * (vertices[1] - vertices[0]) + at[j] * (vertices[2] - vertices[0])
            for i, j in rows
        ]
    )
    triangles = []
    for i, j in rows:
        if i + j < 6:
            triangles.append((number[i, j], number[i + 1, j], number[i, j + 1]))
        if i + j < 5:
            triangles.append((number[i + 1, j], number[i + 1, j + 1], number[i, j + 1]))
    made = core.remesh(points, np.array(triangles), core.RemeshSettings(quads=200))
    holds(points, np.array(triangles), made, 200)
    assert len(made.pole_valence) <= 3
    assert not any("No layout" in sentence for sentence in made.warnings)


@pytest.mark.slow
@pytest.mark.parametrize("marked", [False, True])
def test_layouts_begin_anew_without_creases(monkeypatch, marked):
    """Where no map is found with creases there is one without, and marks stay if they can; the
    curvature is heard again where the directions were smoothed in vain."""
    vertices, triangles = cube(4)
    sharp = None
    if marked:
        on = (vertices[:, 2] == 1.0) & (vertices[:, 0] == 0.0)
        edges = np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)])
        sharp = edges[on[edges].all(axis=1)]
    found = laying_out.injective_map

    def never_with_creases(problem, progress):
        x, faults = found(problem, progress)
        features = problem.crosses
        bent = np.einsum("ec,ec->e", *(features.normal[h // 3] for h in halves(features))) < 0.5
        return x, faults | bent.any()

    def halves(crosses):
        edge = np.flatnonzero(crosses.feature)
        return edge, crosses.twin[edge]

    monkeypatch.setattr(laying_out, "injective_map", never_with_creases)
    # Giving way in places takes one crease a time at most, and no time is to be lost with that.
    for module in (giving_way, laying_out):
        monkeypatch.setattr(module, "least_feature", lambda *_: None)
    detection = core.detect(vertices, triangles)
    guide = core.Guide(vertices, triangles, detection)
    given = Given(triangles, detection, sharp, None, None, None)
    laid = prepare(guide, given, core.RemeshSettings(quads=100), Progress()).parts
    assert len(laid) == 1
    wishes = laid[0].wishes
    assert wishes.dropped == 12 and wishes.smoothed == wishes.unmarked == 0
    assert (wishes.feature > 0).any() == marked and not (wishes.feature & CREASE_BIT).any()


def test_poles_leave_where_a_map_has_failed(monkeypatch):
    mesh = ellipsoid((3.0, 2.0, 1.0), 4)
    found, tried = laying_out.injective_map, []

    def fails_at_first(problem, progress):
        x, faults = found(problem, progress)
        tried.append(problem.crosses)
        return x, faults | (problem.crosses.singular if len(tried) == 1 else False)

    monkeypatch.setattr(laying_out, "injective_map", fails_at_first)
    guide = core.Guide(mesh.vertices, mesh.triangles, core.detect(mesh.vertices, mesh.triangles))
    given = Given(mesh.triangles, guide.detection, None, None, None, None)
    prepare(guide, given, core.RemeshSettings(quads=300), Progress())
    first, second = tried
    assert np.count_nonzero(first.singular) == np.count_nonzero(second.singular) == 8
    assert not (first.singular & second.singular).any()


@hypothesis.settings(max_examples=3, deadline=None, derandomize=True, phases=FEW)
@hypothesis.given(seed=integers(0, 10**6), holes=integers(2, 6), quads=integers(40, 120))
@pytest.mark.slow
def test_small_holes_stay_open(seed, holes, quads):
    """Quads larger than the holes: around each there are three edges at least."""
    vertices, triangles = bumpy(seed, level=3)
    random = np.random.default_rng(seed)
    gone = random.choice(len(vertices), holes, replace=False)
    triangles = triangles[~np.isin(triangles, gone).any(axis=1)]
    made = core.remesh(vertices, triangles, core.RemeshSettings(quads=quads))
    found = conformity(made.quads, len(made.vertices))
    surface, _ = clean(vertices, triangles)
    assert found.manifold and not torn(made.quads, len(made.vertices)).any()
    assert found.characteristic == surface.euler_characteristic.sum()
    assert len(made.quads) < 4 * quads


def test_borders_have_three_edges_whatever_the_scale():
    mesh = cylinder()
    detection = core.detect(mesh.vertices, mesh.triangles)
    guide = core.Guide(mesh.vertices, mesh.triangles, detection)
    given = Given(mesh.triangles, detection, None, None, None, None)
    laid = prepare(guide, given, core.RemeshSettings(quads=100), Progress()).parts[0]
    layout, crosses = laid.layout, laid.map_.crosses
    lengths = integers_.whole_lengths(layout, 1e-3, set(), 0, Progress())
    around = {True: 0, False: 0}
    for track, length in zip(layout.arc_track.tolist(), lengths.tolist(), strict=True):
        if layout.tracks[track].border:
            start = crosses.tail[layout.tracks[track].chain[0]]
            around[bool(crosses.vertices[start, 2] > 0.0)] += length
    assert min(around.values()) >= 3


def test_borders_with_a_corner_of_one_quad_have_four_edges():
    """A tube of eight sides that is cut aslant: the quad at its tip has two edges of the border,
    and with the third it would lie on the hole."""
    mesh = cylinder(columns=8, rows=8)
    vertices = mesh.vertices.copy()
    vertices[:, 2] *= 1.0 + 1.5 * (1.0 + vertices[:, 0]) * (vertices[:, 2] > 0.0)
    detection = core.detect(vertices, mesh.triangles)
    guide = core.Guide(vertices, mesh.triangles, detection)
    given = Given(mesh.triangles, detection, None, None, None, None)
    laid = prepare(guide, given, core.RemeshSettings(quads=100), Progress()).parts[0]
    layout, crosses = laid.layout, laid.map_.crosses
    lengths = integers_.whole_lengths(layout, 1e-3, set(), 0, Progress())
    low = crosses.vertices[:, 2].min() + 1e-9
    around = 0
    for track, length in zip(layout.arc_track.tolist(), lengths.tolist(), strict=True):
        start = crosses.tail[layout.tracks[track].chain[0]] if layout.tracks[track].border else -1
        around += length if start >= 0 and crosses.vertices[start, 2] > low else 0
    assert around == 4


@pytest.mark.slow
def test_quads_tell_where_they_are_torn():
    vertices, triangles = cube(2)
    made = core.remesh(vertices, triangles, core.RemeshSettings(quads=54))
    count = len(made.vertices)
    assert not torn(made.quads, count).any()
    twice = np.concatenate([made.quads, made.quads[:1]])
    assert set(np.flatnonzero(torn(twice, count))) == set(made.quads[0])
    pinched = made.quads.copy()
    far = int(np.argmax(np.linalg.norm(made.vertices - made.vertices[0], axis=1)))
    pinched[pinched == far] = 0
    assert np.flatnonzero(torn(pinched, count)).tolist() == [0]
    assert not conformity(twice, count).manifold and not conformity(pinched, count).manifold


@pytest.mark.slow
def test_a_layout_without_whole_numbers_is_said_and_not_refused(monkeypatch):
    """A layout whose lengths contradict what must stay apart; there is a bound to the search."""
    vertices, triangles = bumpy(1, level=3)
    monkeypatch.setattr(integers_, "_dive", lambda *_, **__: None)
    monkeypatch.setattr(integers_, "_searched", lambda *_: None)
    made = core.remesh(vertices, triangles, core.RemeshSettings(quads=200))
    found = conformity(made.quads, len(made.vertices))
    assert found.manifold and found.characteristic == 2 and not found.border.any()
    assert any("No layout" in sentence for sentence in made.warnings)


def test_systems_of_wide_weights_are_solved():
    """Weights of twelve orders of magnitude, as those of directions that are hard to turn."""
    random = np.random.default_rng(0)
    n = 4000
    tail = np.arange(n - 1)
    weight = 10.0 ** random.uniform(0.0, 12.0, n - 1)
    off = sparse.coo_array((-weight, (tail, tail + 1)), shape=(n, n))
    matrix = (off + off.T).tocsr()
    matrix = matrix - sparse.diags_array(matrix.sum(axis=1)) + sparse.diags_array(np.ones(n))
    value = random.normal(size=n)
    found = solve_part(matrix.tocsr(), matrix @ value, Progress())
    assert np.abs(matrix @ (found - value)).max() < 1e-6 * np.abs(matrix @ value).max()


@pytest.mark.slow
@pytest.mark.parametrize("shape", ["goblet", "box"])
def test_vertices_one_step_of_their_numbers_apart(shape):
    """Booleans leave such along creases: no layout was found for them."""
    vertices, triangles = lathe(goblet(0.15, 0.5)) if shape == "goblet" else cube(2)
    surface, _ = clean(vertices, triangles)
    normal, _ = surface.face_normal_area
    bend = np.einsum(
        "ec,ec->e", normal[np.arange(len(surface.twin)) // 3], normal[surface.twin // 3]
    )
    marked = (bend < 0.7) & (np.random.default_rng(0).random(len(bend)) < 0.3)
    spoiled = with_needles(plain(vertices, triangles), marked, 1.2e-7)
    made = core.remesh(spoiled.vertices, spoiled.triangles, core.RemeshSettings(quads=600))
    assert not any("No layout" in word for word in made.warnings)
    holds(spoiled.vertices, spoiled.triangles, made)
