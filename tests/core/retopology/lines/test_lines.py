"""Lines of curvature and separatrices against closed forms."""

import dataclasses
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from exact_fields import field_on_plane, flat_surface, surface_of
from mesh_files import read_mesh
from scipy.spatial import cKDTree
from surfaces import cylinder, ellipsoid, noisy, random_ellipsoid, sphere, torus

import core
from core.base.progress import Progress
from core.fields.planes import barycentric_of, in_plane, lay_out
from core.retopology.lines import tracing
from core.retopology.lines.bundles import joined_bundles
from core.retopology.lines.polylines import MOST_BEND, points_of, sparse_rows
from core.retopology.lines.separatrices import BUNDLED, ENDS
from core.retopology.lines.streamlines import AUTO_SPACING
from core.retopology.lines.tracing import (
    BORDER,
    FEATURE,
    LIMIT,
    MET,
    OBSTACLE,
    Obstacles,
    Starts,
    trace,
)
from core.retopology.lines.truncation import Barriers, ended_on_features, laid, truncated

MESHES = {
    "ellipsoid": ellipsoid(subdivisions=5),
    "fine ellipsoid": ellipsoid(subdivisions=6),
    "random ellipsoid": random_ellipsoid(20000),
    "torus": torus(),
    "cylinder": cylinder(),
}


def guided(mesh):
    detection = core.detect(mesh.vertices, mesh.triangles)
    return core.Guide(mesh.vertices, mesh.triangles, detection)


@cache
def guide_of(name):
    return guided(MESHES[name])


@cache
def lines_of(name):
    return guide_of(name).lines()


@cache
def rough_guide():
    """Of a noisy ellipsoid. Normals alone feel the noise; jets would choose a larger scale."""
    mesh = noisy(MESHES["ellipsoid"], 0.05)
    settings = core.Settings(curvature="normals", normal_smoothing=3)
    detection = core.detect(mesh.vertices, mesh.triangles, settings)
    return core.Guide(mesh.vertices, mesh.triangles, detection)


@pytest.fixture
def real_separatrices(meshes_folder):
    """A function from the name of a real mesh to its mesh, its guide and its separatrices, both
    ways."""
    return lambda name: _separatrices_of(meshes_folder / name)


@cache
def _separatrices_of(path):
    vertices, triangles = read_mesh(path)
    guide = core.Guide(vertices, triangles, core.detect(vertices, triangles))
    return vertices, triangles, guide, guide.separatrices(both_ways=True)


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


@pytest.mark.slow
@pytest.mark.parametrize("name", ["ellipsoid", "random ellipsoid"])
@pytest.mark.parametrize("smoothness", [0.0, 0.5])
def test_separatrices_join_the_lemons_along_the_middle_ellipse(name, smoothness):
    settings = core.GuidanceSettings(line_smoothness=smoothness)
    lines = guide_of(name).separatrices(settings, both_ways=True)
    assert len(lines) == 8
    assert (lines.target >= 0).all() and (lines.target != lines.source).all()
    assert np.abs(lines.position[:, 1]).max() < 0.5 * MESHES[name].edge_length
    # Once each, the four arcs are the whole ellipse x^2 / 9 + z^2 = 1.
    arcs = guide_of(name).separatrices(settings)
    assert len(arcs) == 4
    assert arcs.length.sum() == pytest.approx(13.3649, rel=0.005)
    assert sorted(arcs.family) == [0, 0, 1, 1]


@pytest.mark.once
@pytest.mark.parametrize("name", ["ellipsoid", "torus", "cylinder"])
def test_lines_are_evenly_spaced(name):
    mesh, lines = MESHES[name], lines_of(name)
    corner = mesh.vertices[mesh.triangles]
    area = (
        0.5
        * np.linalg.norm(
            np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1
        ).sum()
    )
    spacing = AUTO_SPACING * np.sqrt(area)
    for family in (0, 1):
        some = lines.select(lines.family == family)
        assert len(some) > 5
        line = np.repeat(np.arange(len(some)), np.diff(some.start))
        tree = cKDTree(some.position)
        pairs = tree.query_pairs(0.4 * spacing, output_type="ndarray")
        apart = line[pairs[:, 0]] != line[pairs[:, 1]]
        assert apart.mean() < 0.005
        # No place of the surface is far from a line.
        distance, _ = tree.query(mesh.vertices)
        assert np.quantile(distance, 0.97) < 1.3 * spacing
        assert np.median(distance) < 0.5 * spacing


@pytest.mark.once
def test_lines_of_the_torus_are_its_circles():
    lines = lines_of("torus")
    for number in range(len(lines)):
        x, y, z = lines.points(number).T
        if lines.family[number] == 0:  # the tube: an angle around the axis is kept
            assert np.ptp(np.unwrap(np.arctan2(y, x))) < 0.02
        else:
            assert np.ptp(z) < 0.05  # over a length of up to 17; an edge is 0.1
    assert lines.closed.mean() > 0.6
    assert lines.closed[lines.family == 1].mean() > 0.9


@pytest.mark.once
def test_points_lie_in_their_triangles():
    mesh = random_ellipsoid(5000)
    lines = guided(mesh).lines()
    corner = mesh.vertices[mesh.triangles[lines.triangle]]
    there = np.einsum("pk,pkc->pc", lines.barycentric, corner)
    assert np.abs(there - lines.position).max() < 1e-9
    assert (lines.barycentric >= 0).all()
    assert np.allclose(lines.barycentric.sum(axis=1), 1.0)
    # So do the chords that end at them, but where points in between were left out.
    first = np.isin(np.arange(len(lines.position)), lines.start[:-1])
    middle = 0.5 * (lines.position + np.roll(lines.position, 1, axis=0))
    a, b, c = np.moveaxis(corner, 1, 0)
    normal = np.cross(b - a, c - a)
    inside = [
        np.einsum("pc,pc->p", np.cross(two - one, middle - one), normal)
        for one, two in ((a, b), (b, c), (c, a))
    ]
    beside = np.min(inside, axis=0) < -1e-6 * np.einsum("pc,pc->p", normal, normal)
    assert beside[~first].mean() < 0.15


@pytest.mark.once
def test_no_chord_is_without_length():
    for lines in (lines_of("random ellipsoid"), rough_guide().lines()):
        first = np.isin(np.arange(len(lines.position)), lines.start[:-1])
        step = np.linalg.norm(lines.position - np.roll(lines.position, 1, axis=0), axis=1)[~first]
        assert step.min() > 1e-6 * np.median(step)


def last_turns(lines):
    """Degrees by which lines that end at umbilics turn with their last chord, in the surface."""
    turns = []
    for number in np.flatnonzero(lines.target >= 0):
        point = lines.points(number)
        if len(point) > 2:
            normal = lines.normal[lines.start[number + 1] - 2]
            before, last = np.diff(point[-3:], axis=0)
            before, last = (some - (some @ normal) * normal for some in (before, last))
            size = np.linalg.norm(before) * np.linalg.norm(last)
            turns.append(np.degrees(np.arccos(np.clip(before @ last / size, -1.0, 1.0))))
    return np.array(turns)


@pytest.mark.once
def test_separatrices_come_into_umbilics_straight_on():
    turns = last_turns(rough_guide().separatrices(both_ways=True))
    assert len(turns) > 10 and turns.max() < 60.0


def test_separatrices_leave_their_line_as_late_as_that_is_straight():
    found = guide_of("random ellipsoid").separatrices(both_ways=True)
    last = []
    for line in np.flatnonzero(found.target >= 0):
        chord = np.linalg.norm(np.diff(found.points(line), axis=0), axis=1)
        last.append(chord[-1] / np.median(chord))
    assert len(last) == 8 and max(last) < 3.0


@pytest.mark.once
def test_no_line_turns_sharply():
    mesh, lines = MESHES["ellipsoid"], lines_of("ellipsoid")
    for number in range(len(lines)):
        step = np.diff(lines.points(number), axis=0)
        step = step[np.linalg.norm(step, axis=1) > 0.2 * mesh.edge_length]
        step /= np.linalg.norm(step, axis=1, keepdims=True)
        assert np.einsum("ij,ij->i", step[1:], step[:-1]).min(initial=1.0) > 0.6


@pytest.mark.slow
@pytest.mark.parametrize("name", ["fine ellipsoid", "torus"])
def test_closed_lines_close_without_a_kink(name):
    lines = lines_of(name)
    assert lines.closed.mean() > 0.6
    for number in np.flatnonzero(lines.closed):
        points = lines.points(number)
        step = np.diff(np.vstack([points[-4:], points[:4]]), axis=0)
        step /= np.linalg.norm(step, axis=1, keepdims=True)
        assert np.einsum("ij,ij->i", step[1:], step[:-1]).min() > 0.5


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


def test_separatrices_that_come_to_nothing_else_end_at_what_they_pass(monkeypatch):
    """Were no line to go towards anything, those that end just before an umbilic would miss it."""
    usual = guide_of("ellipsoid").separatrices(both_ways=True)
    assert (usual.target >= 0).all()
    monkeypatch.setattr(tracing, "LEAST_AIM", 2.0)
    limit = float(usual.length.max()) - MESHES["ellipsoid"].edge_length
    short = core.GuidanceSettings(length_limit=limit)
    found = guide_of("ellipsoid").separatrices(short, both_ways=True)
    assert (found.target >= 0).all()


@pytest.mark.once
def test_sphere_says_that_it_has_no_direction():
    guide = guided(sphere())
    with pytest.raises(core.GuidanceError, match="no preferred direction"):
        guide.lines()
    assert len(guide.separatrices()) == 0


@pytest.mark.once
def test_one_family_alone():
    guide = guided(torus(columns=60, rows=24))
    for family, name in enumerate(("first", "second")):
        lines = guide.lines(core.GuidanceSettings(families=name))
        assert set(lines.family) == {family}


@pytest.mark.slow
def test_spacing_is_in_length():
    guide = guided(torus(columns=60, rows=24))
    counts = [len(guide.lines(core.GuidanceSettings(spacing=s))) for s in (0.2, 0.4)]
    assert counts[0] > 1.6 * counts[1]


@pytest.mark.slow
def test_smoothing_lengthens_the_lines_of_a_noisy_surface():
    guide = rough_guide()
    lengths = [
        np.median(guide.lines(core.GuidanceSettings(line_smoothness=s)).length) for s in (0.0, 0.6)
    ]
    assert lengths[1] > 1.2 * lengths[0]


def turning(lines, step):
    """Degrees that lines turn per step of their length."""
    turned = steps = 0.0
    for number in range(len(lines)):
        points = lines.points(number)
        chord = np.linalg.norm(np.diff(points, axis=0), axis=1)
        arc = np.concatenate([[0.0], np.cumsum(chord)])
        at = np.arange(0.0, arc[-1], step)
        even = np.stack([np.interp(at, arc, axis) for axis in points.T], axis=1)
        ahead = np.diff(even, axis=0)
        ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
        cosine = np.einsum("ij,ij->i", ahead[1:], ahead[:-1])
        turned += np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))).sum()
        steps += len(cosine)
    return turned / steps


@pytest.mark.slow
def test_smoothing_straightens_the_separatrices_of_a_noisy_surface():
    guide, step = rough_guide(), 2 * MESHES["ellipsoid"].edge_length
    raw, smooth = (
        guide.separatrices(core.GuidanceSettings(line_smoothness=s), both_ways=True)
        for s in (0.0, 0.6)
    )
    # They still begin at every umbilic, as many.
    assert list(smooth.source) == list(raw.source)
    ratio = turning(smooth, step) / turning(raw, step)
    assert ratio < 0.8, ratio


@pytest.mark.slow
def test_separatrices_do_not_follow_the_swirls_of_dropped_pairs():
    """In the field as it was, with 852 swirls, they turned by 34 degrees a step and 3 of 24
    arrived."""
    mesh = noisy(ellipsoid(subdivisions=5), 0.05)
    detection = core.detect(mesh.vertices, mesh.triangles, core.Settings(curvature="normals"))
    found = core.Guide(mesh.vertices, mesh.triangles, detection).separatrices(both_ways=True)
    assert turning(found, 2 * mesh.edge_length) < 16.0
    assert (found.target >= 0).sum() > 6


@pytest.mark.slow
def test_smoothing_a_clean_surface_changes_little():
    lines = guide_of("torus").lines(core.GuidanceSettings(line_smoothness=0.4))
    for number in np.flatnonzero(lines.family == 0):
        x, y, _ = lines.points(number).T
        assert np.ptp(np.unwrap(np.arctan2(y, x))) < 0.02


def vase(columns, rows, jitter=0.0, seed=0):
    """r = 2 + cos z for |z| < 2 pi: meridians and parallels change families where |cos z| = 1 / r,
    on circles of umbilics."""
    z, around = np.meshgrid(
        np.linspace(-2 * np.pi, 2 * np.pi, rows), np.arange(columns), indexing="ij"
    )
    random = np.random.default_rng(seed)
    inner = np.abs(z) < 2 * np.pi - 1e-9
    z = z + inner * jitter * random.uniform(-1, 1, z.shape) * 4 * np.pi / (rows - 1)
    angle = 2 * np.pi / columns * (around + jitter * random.uniform(-1, 1, z.shape))
    r = 2.0 + np.cos(z)
    points = np.stack([r * np.cos(angle), r * np.sin(angle), z], axis=2).reshape(-1, 3)
    below = (np.arange(rows - 1)[:, None] * columns + np.arange(columns)).ravel()
    aside = (np.arange(rows - 1)[:, None] * columns + (np.arange(columns) + 1) % columns).ravel()
    return points, np.concatenate(
        [np.c_[below, aside, aside + columns], np.c_[below, aside + columns, below + columns]]
    )


@pytest.mark.slow
@pytest.mark.parametrize("columns, rows, jitter", [(128, 257, 0.0), (64, 129, 0.0), (96, 193, 0.3)])
def test_lines_do_not_turn_on_circles_of_umbilics(columns, rows, jitter):
    vertices, triangles = vase(columns, rows, jitter)
    lines = core.Guide(vertices, triangles, core.detect(vertices, triangles)).lines()
    turning = 0
    for number in range(len(lines)):
        points = lines.points(number)
        step, middle = np.diff(points, axis=0), 0.5 * (points[1:] + points[:-1])
        length = np.linalg.norm(step, axis=1)
        radius = np.linalg.norm(middle[:, :2], axis=1)
        slope = -np.sin(middle[:, 2])
        meridian = np.c_[slope[:, None] * middle[:, :2] / radius[:, None], np.ones(len(middle))]
        meridian /= np.linalg.norm(meridian, axis=1, keepdims=True)
        along = np.abs(np.einsum("ij,ij->i", step, meridian)) / np.maximum(length, 1e-12)
        shares = [length[along > 0.9].sum(), length[along < 0.42].sum()]
        turning += min(shares) > 0.15 * length.sum()
    assert len(lines) > 150 and turning == 0


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["spot_os.obj", "hand_closed_os.obj", "rocker-arm.obj", "bunny_hr_os.obj"]
)
def test_separatrices_of_real_meshes_end_at_umbilics(name, real_separatrices):
    """Around the ring of the rocker arm many would wind for ever, beside a closed line."""
    vertices, triangles, guide, found = real_separatrices(name)
    ends = np.array(ENDS)[found.end]
    rays = np.isfinite(guide.detection.umbilics.separatrix).all(axis=2).sum()
    assert len(found) == 2 * rays and np.isin(ends, ENDS[:4]).mean() > 0.95
    assert len(found) > 50 or name == "rocker-arm.obj"
    assert np.array_equal(ends == "umbilic", found.target >= 0)
    # One in seven turned farther with its last chord before it came in from farther off, and some
    # between umbilics next to each other after that.
    assert last_turns(found).max() < 60.0
    if name in ("spot_os.obj", "hand_closed_os.obj"):
        assert (found.target >= 0).mean() > 0.9
    if name == "rocker-arm.obj":
        # Those ends lie on creases or crests.
        last = found.position[found.start[1:] - 1][ends == "feature"]
        crests = guide.ridges(core.GuidanceSettings(least_bend=40.0)).position
        creases = guide.surface.vertices * guide.surface.unit + guide.surface.origin
        creases = creases[guide.surface.triangles.ravel()[guide.features().half_edge]]
        edge = np.linalg.norm(vertices[triangles[:, 0]] - vertices[triangles[:, 1]], axis=1).mean()
        assert len(last) > 3
        assert cKDTree(np.vstack([crests, creases])).query(last)[0].max() < edge


@pytest.fixture(scope="module")
def winding():
    """A square whose lines are spirals that go clockwise from the x axis, the planes of its
    triangles, one of the lines, and where the triangles are."""
    surface, place = flat_surface(cells=81)
    angle = np.angle(place) + 0.5 * np.pi + 0.03
    planes = lay_out(surface, field_on_plane(np.exp(2j * angle)).lines, Progress())
    middle = surface.vertices[surface.triangles].mean(axis=1) * surface.unit + surface.origin
    triangle = np.linalg.norm(middle - (0.5, 0.0, 0.0), axis=1).argmin(keepdims=True)
    z = planes.corner[triangle].mean(axis=1)
    ahead, limit = np.sqrt(planes.deviator(triangle, z)), np.array([9.0]) / surface.unit
    starts = Starts.plain(triangle, z, ahead, np.zeros(1), limit)
    spiral = trace(surface, planes, starts, Obstacles.none(surface), Progress())
    return surface, planes, spiral, middle


def test_a_line_without_end_is_cut_where_it_winds(winding):
    """A turn of radius r lies 2 pi r tan(0.03) inside."""
    surface, planes, spiral, _ = winding
    assert spiral.end == LIMIT
    wide = truncated(surface, planes, spiral, 0.15 / surface.unit)
    assert 0.75 < wide.travelled[-1] * surface.unit / (2 * np.pi * 0.5) < 1.1
    narrow = truncated(surface, planes, spiral, 0.01 / surface.unit)
    assert len(narrow.travelled) == len(spiral.travelled) and narrow.end == LIMIT


def test_a_winding_line_ends_on_the_last_feature_that_it_crosses(winding):
    surface, planes, spiral, middle = winding
    wide = truncated(surface, planes, spiral, 0.15 / surface.unit)
    none = np.zeros((0, 3))
    assert wide.end == MET

    def ended(*rays, hard=()):
        """Where the line ends with pieces of crests along rays at the angles given."""
        tail, head, rows = [none], [none], [np.zeros(0, np.int64)]
        for ray in rays:
            way = np.array([np.cos(ray), np.sin(ray), 0.0])
            along = middle @ way
            near = np.linalg.norm(middle - along[:, None] * way, axis=1) < 0.02
            near &= along > 0
            rows.append(np.flatnonzero(near))
            for ends, shift in ((tail, -0.05), (head, 0.05)):
                ends.append(((along[near, None] + shift) * way - surface.origin) / surface.unit)
        barriers = Barriers(
            np.array(hard, np.int64), np.concatenate(rows), np.vstack(tail), np.vstack(head)
        )
        found = ended_on_features(surface, planes, wide, barriers)
        last = points_of(surface, planes, found.triangle[-1:], found.z[-1:])[0]
        return found, last * surface.unit + surface.origin

    same, _ = ended()
    assert same.end == MET and len(same.z) == len(wide.z)
    for rays, expected in (((5.0,), 5.0), ((5.0, 4.0), 4.0), ((4.0, 5.0), 4.0)):
        found, last = ended(*rays)
        assert found.end == FEATURE
        assert np.arctan2(last[1], last[0]) % (2 * np.pi) == pytest.approx(expected, abs=1e-6)
        assert 0.4 < np.hypot(last[0], last[1]) < 0.65
    # A hard edge is crossed where the line's point lies on it.
    at = len(wide.z) // 2
    corner = barycentric_of(planes, wide.triangle[[at]], wide.z[[at]])[0].argmin()
    found, last = ended(hard=[3 * wide.triangle[at] + (corner + 1) % 3])
    assert found.end == FEATURE and found.travelled[-1] == wide.travelled[at]


@pytest.mark.slow
def test_automatic_smoothness_goes_by_the_noise_of_the_directions():
    mesh = ellipsoid(subdivisions=4)
    clean, exact = guided(mesh), core.GuidanceSettings(line_smoothness=0.0)
    assert np.array_equal(clean.lines().position, clean.lines(exact).position)
    unknown = np.full_like(clean.detection.curvature.noise, np.nan)
    curvature = dataclasses.replace(clean.detection.curvature, noise=unknown)
    blind = dataclasses.replace(clean.detection, curvature=curvature)
    lines = core.Guide(mesh.vertices, mesh.triangles, blind).lines()
    assert np.array_equal(lines.position, clean.lines(exact).position)
    rough = noisy(mesh, 0.05)
    # Operators that come without an error tell it by how neighbours differ.
    by_normals = core.detect(rough.vertices, rough.triangles, core.Settings(curvature="normals"))
    assert np.isnan(by_normals.curvature.noise).all()
    guide = core.Guide(rough.vertices, rough.triangles, by_normals)
    assert not np.array_equal(guide.lines().position, guide.lines(exact).position)
    # Fits over two rings follow the noise; a little more, and their field would be smoothed first.
    rough = noisy(mesh, 0.03)
    detection = core.detect(rough.vertices, rough.triangles, core.Settings(scale=2.0))
    guide = core.Guide(rough.vertices, rough.triangles, detection)
    found, wild = (
        turning(guide.separatrices(one, both_ways=True), 2 * mesh.edge_length)
        for one in (core.GuidanceSettings(), exact)
    )
    assert found < 0.9 * wild


def beside_others(lines, apart):
    """Share of the length of lines on which they run beside others of their family."""
    line = np.repeat(np.arange(len(lines)), np.diff(lines.start))
    point = lines.position
    place = np.hstack([point, 2 * apart * lines.normal, 10 * apart * lines.family[line][:, None]])
    pairs = cKDTree(place).query_pairs(apart, output_type="ndarray")
    pairs = pairs[line[pairs[:, 0]] != line[pairs[:, 1]]]
    pairs = np.concatenate([pairs, pairs[:, ::-1]])
    # Where two lines share their points they are one.
    other = pairs[:, 0] * len(lines) + line[pairs[:, 1]]
    shared = np.linalg.norm(point[pairs[:, 0]] - point[pairs[:, 1]], axis=1) < 1e-9
    near = np.zeros(len(point), bool)
    near[pairs[~np.isin(other, other[shared]), 0]] = True
    step = np.linalg.norm(np.diff(point, axis=0), axis=1)
    inner = line[1:] == line[:-1]
    return step[inner & near[1:] & near[:-1]].sum() / step[inner].sum()


@pytest.mark.slow
@pytest.mark.parametrize("name", ["hand_closed_os.obj", "bunny_hr_os.obj"])
def test_separatrices_do_not_run_in_bundles(name, real_separatrices):
    """As traced, 0.28 and 0.51 of their length on these meshes did."""
    _, _, guide, found = real_separatrices(name)
    area = guide.surface.face_normal_area[1].sum() * guide.surface.unit**2
    assert beside_others(found, BUNDLED * AUTO_SPACING * np.sqrt(area)) < 0.15


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


def test_lines_that_meet_go_on_as_one():
    """Three from the left, two of which come together; one back from where they end."""
    x = np.linspace(0.0, 1.0, 101)
    high = np.where(x < 0.5, 0.5 - x, 0.0)
    ways = [(x, 0 * x), (x, 0.02 + high), (x, 1.0 + 0 * x), (1.0 - 1.2 * x, 0.01 + 0 * x)]
    points = np.concatenate([np.c_[a, b, 0 * a] for a, b in ways])
    line = np.repeat(np.arange(4), 101)
    source, target = np.array([0, 1, 2, 9]), np.array([9, 8, 7, 5])
    normal = np.tile([0.0, 0.0, 1.0], (len(points), 1))
    joined = joined_bundles(points, normal, line, np.zeros(4), source, target, 0.05, 0.2)
    assert joined.target.tolist() == [9, 9, 7, 0]
    first, second, third, fourth = (joined.row[joined.line == number] for number in range(4))
    assert np.array_equal(first, np.arange(101)) and np.array_equal(third, 202 + np.arange(101))
    # Its own points up to where it comes near, then those of the first.
    assert (second[:40] == 101 + np.arange(40)).all() and second[-1] == 100
    assert np.abs(points[second][60:, 1]).max() == 0.0
    assert fourth[-1] == 0 and (np.diff(fourth[1:]) == -1).all()


def test_a_line_beside_one_that_leads_back_still_joins_the_next():
    """It starts beside a loop of its own umbilic, then comes to a line that arrives elsewhere."""
    ways = [np.linspace(0.0, 0.4, 41), np.linspace(0.0, 1.4, 141), np.linspace(0.6, 1.5, 91)]
    height = [0.0, 0.02, 0.0]
    points = np.concatenate([np.c_[x, 0 * x + y, 0 * x] for x, y in zip(ways, height, strict=True)])
    line = np.repeat(np.arange(3), [len(x) for x in ways])
    source, target = np.array([3, 3, 4]), np.array([3, -1, 6])
    normal = np.tile([0.0, 0.0, 1.0], (len(points), 1))
    joined = joined_bundles(points, normal, line, np.zeros(3), source, target, 0.05, 0.2)
    assert joined.target.tolist() == [3, 6, 6]
    second = points[joined.row[joined.line == 1]]
    assert np.abs(second[second[:, 0] > 0.65, 1]).max() == 0.0
