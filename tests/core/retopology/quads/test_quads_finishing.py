"""Steps of the finishing: what counts as folded, mending place by place, corners made square."""

from dataclasses import replace

import numpy as np
import pytest
from quad_guarantees import broken_guarantees
from quad_surfaces import bumpy
from scipy.spatial import cKDTree
from surfaces import ellipsoid, sphere, torus

import core
from core.base.progress import Progress
from core.mesh.mending.repair import clean
from core.mesh.rings import with_rings
from core.retopology.quads.conformity import scaled_jacobian, signed
from core.retopology.quads.field.directions import direction_weights
from core.retopology.quads.finishing import finished
from core.retopology.quads.finishing.faults import last_check, mending, worst
from core.retopology.quads.finishing.faults.mending import (
    against,
    oriented_quality,
    quality_to_mend,
)
from core.retopology.quads.finishing.faults.unfolding import unfolded
from core.retopology.quads.finishing.faults.worst import worst_opened
from core.retopology.quads.finishing.guides import Guides, moved_along
from core.retopology.quads.finishing.opening import Squaring
from core.retopology.quads.finishing.placement import Placement
from core.retopology.quads.finishing.projection import ClosestPoints
from core.retopology.quads.finishing.relaxation import squared
from core.retopology.quads.finishing.reporting import words_of_folds, words_of_shape
from core.retopology.quads.preparation import Given, prepare


def grid(sides, size=1.0):
    """A flat square of sides² quads."""
    at = size * np.arange(sides + 1.0)
    position = np.stack([*(x.ravel() for x in np.meshgrid(at, at)), 0.0 * at.repeat(sides + 1)], 1)
    row = np.arange((sides + 1) ** 2).reshape(sides + 1, -1)
    corners = row[:-1, :-1], row[:-1, 1:], row[1:, 1:], row[1:, :-1]
    return position, np.stack(corners, axis=-1).reshape(-1, 4)


def guided(vertices, triangles, count, fixed=None, thin=False):
    surface, _ = clean(vertices, triangles)
    place = surface.vertices * surface.unit + surface.origin
    none = np.full(count, -1)
    return Guides(
        surface=ClosestPoints(place, surface.triangles, surface.twin),
        direction=np.tile([1.0, 0.0, 0.0], (len(surface.triangles), 1)),
        size=np.ones(len(surface.triangles)),
        fixed=none >= 0 if fixed is None else fixed,
        curve=none,
        beside=np.stack([none, none], axis=1),
        curves={},
        thin=thin,
    )


def sheet(sides, thick):
    """A closed plate: the top at height 0, the other side `thick` below."""
    position, quads = grid(sides)
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    low = position - [0.0, 0.0, thick]
    n = len(position)
    row = np.arange(n).reshape(sides + 1, -1)
    ring = np.concatenate([row[0, :-1], row[:-1, -1], row[-1, :0:-1], row[:0:-1, 0]])
    ahead = np.roll(ring, -1)
    wall = np.concatenate(
        [np.stack([ring + n, ahead + n, ahead], 1), np.stack([ring + n, ahead, ring], 1)]
    )
    triangles = np.concatenate([triangles, triangles[:, ::-1] + n, wall])
    return np.concatenate([position, low]), triangles


def folded_strip():
    """Five quads in a row, the third of which runs back and outweighs both beside it."""
    x = np.array([0.0, 1.0, 3.9, -0.1, 3.0, 4.0]) + 0.5
    position = np.stack([np.tile(x, 2), np.repeat([1.0, 2.0], 6), np.zeros(12)], axis=1)
    return position, np.array([[k, k + 1, k + 7, k + 6] for k in range(5)])


@pytest.mark.parametrize("thick", [0.05, 0.4])
def test_a_large_turned_quad_is_folded_whatever_sheet_lies_below(thick):
    """The other side of a thin plate faces as it does; the quads across its sides do not."""
    position, quads = folded_strip()
    guides = guided(*sheet(5, thick), len(position), thin=True)
    assert np.flatnonzero(against(position, quads, guides.surface)).tolist() == [2]
    assert np.flatnonzero(oriented_quality(position, quads, guides) < 0.0).tolist() == [2]


def test_a_quad_against_the_surface_is_unfolded():
    position, quads = folded_strip()
    position[:, :2] += np.random.default_rng(0).uniform(-0.15, 0.15, (12, 2))
    ends = np.isin(np.arange(12) % 6, [0, 5])
    guides = guided(*sheet(5, 0.3), len(position), ends, thin=True)
    found = unfolded(position, quads, guides, Progress())
    assert not against(found, quads, guides.surface).any()
    assert scaled_jacobian(found, quads).min() > 0.0


@pytest.mark.once
def test_what_stays_against_the_surface_is_said(monkeypatch):
    """A quad that no step could turn is never left in silence, and nothing is moved for it."""
    plain = core.remesh(*bumpy(0, 3), core.RemeshSettings(quads=200))

    def first(position, quads, surface):
        return np.arange(len(quads)) == 0

    monkeypatch.setattr(last_check, "against", first)
    made = core.remesh(*bumpy(0, 3), core.RemeshSettings(quads=200))
    assert any("1 quad folded" in said for said in made.warnings)
    np.testing.assert_array_equal(made.vertices, plain.vertices)


def turned_over(made, quad):
    """Quads of which one is laid over onto that beside it."""
    vertices = made.vertices.copy()
    corner = made.quads[quad]
    vertices[corner[:2]] += 1.6 * (vertices[corner[[3, 2]]] - vertices[corner[:2]])
    return replace(made, vertices=vertices)


@pytest.mark.once
def test_the_last_check_turns_what_faces_against_the_input():
    """On the surface again, and what is not around it stays; held vertices stay, too, where that
    is enough, and where all are held nothing is moved."""
    mesh = ellipsoid(subdivisions=4)
    made = core.remesh(mesh.vertices, mesh.triangles, core.RemeshSettings(quads=300))
    whole, _ = clean(mesh.vertices, mesh.triangles)
    quad = int(np.flatnonzero((made.pole[made.quads] < 0).all(axis=1))[20])
    folded = turned_over(made, quad)
    found, wrong = last_check.checked(folded, whole, Progress())
    assert wrong == 0
    assert broken_guarantees(mesh.vertices, mesh.triangles, folded) != []
    assert broken_guarantees(mesh.vertices, mesh.triangles, found) == []
    far = with_rings(made.quads, np.isin(np.arange(len(made.vertices)), made.quads[quad]), 5)
    np.testing.assert_array_equal(found.vertices[~far], made.vertices[~far])
    held = np.zeros(len(made.vertices), bool)
    held[made.quads[quad, 3]] = True
    found, wrong = last_check.checked(replace(folded, feature=held), whole, Progress())
    assert wrong == 0
    np.testing.assert_array_equal(found.vertices[held], folded.vertices[held])
    _, wrong = last_check.checked(replace(folded, feature=~held), whole, Progress())
    assert wrong == 0
    stuck = replace(folded, border=np.ones(len(made.vertices), bool))
    same, wrong = last_check.checked(stuck, whole, Progress())
    assert wrong > 0
    np.testing.assert_array_equal(same.vertices, folded.vertices)


@pytest.mark.once
def test_quads_are_held_against_their_own_piece_alone():
    """The lowest of six quads on a ball that is sunk into a plate: nearest to it is the plate,
    which faces the other way, and the quads beside it lean away."""
    ball = sphere(subdivisions=3)
    made = core.remesh(ball.vertices, ball.triangles, core.RemeshSettings(quads=8))
    assert len(made.vertices) == 8
    turn = np.radians(45.0 + 90.0 * np.arange(4))
    ring = np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1)
    places = [np.cos(rise) * ring + [0.0, 0.0, np.sin(rise)] for rise in np.radians([-20.0, 55.0])]
    low, beside = np.arange(4), np.roll(np.arange(4), -1)
    sides = np.stack([low, beside, beside + 4, low + 4], axis=1)
    quads = np.concatenate([sides, [[3, 2, 1, 0], [4, 5, 6, 7]]])
    made = replace(made, vertices=np.concatenate(places), quads=quads)
    plate = np.array([[-3.0, -3.0, -0.3], [3.0, -3.0, -0.3], [3.0, 3.0, -0.3], [-3.0, 3.0, -0.3]])
    corners = len(ball.vertices) + np.array([[0, 1, 2], [0, 2, 3]])
    triangles = np.concatenate([ball.triangles, corners])
    whole, _ = clean(np.concatenate([ball.vertices, plate]), triangles, kept_from=0.0)
    together = ClosestPoints(whole.vertices, whole.triangles, whole.twin)
    place = (made.vertices - whole.origin) / whole.unit
    assert against(place, quads, together).sum() == 1
    same, wrong = last_check.checked(made, whole, Progress())
    assert wrong == 0
    np.testing.assert_array_equal(same.vertices, made.vertices)


def test_what_is_turned_counts_as_folded_even_without_area():
    quality = signed(np.array([0.9, 0.0, -0.4, 0.9]), np.array([True, True, True, False]))
    assert (quality[:3] < 0.0).all() and quality[3] == 0.9


def test_folds_are_told_in_the_number_that_there_are():
    assert words_of_folds(0, 0.0, 0) == []
    for number, folds in ((1, "1 quad folded"), (3, "3 quads folded")):
        off, folded = words_of_folds(number, 0.125, number)
        assert off.startswith("1 vertex moved" if number == 1 else "3 vertices moved")
        assert "by 0.125 at most" in off and folded.startswith(folds)


def test_skewed_quads_are_told_and_why():
    """A sharp corner of the border allows no better quad; others could be."""
    position, quads = grid(3)
    n = len(position)
    along = np.full((n, 2), -1)
    ring = [0, 1, 2, 3, 7, 11, 15, 14, 13, 12, 8, 4]
    along[ring] = np.stack([np.roll(ring, 1), np.roll(ring, -1)], axis=1)
    none = np.full(n, -1)
    placed = Placement(quads, position, none, none, none, along)
    assert words_of_shape([(placed, position)]) == []
    sharp = position.copy()
    sharp[0] = [-6.0, -6.0, 0.0]
    (said,) = words_of_shape([(placed, sharp)])
    assert said.startswith("1 quad as sharp as the corners of creases")
    skewed = position.copy()
    skewed[5, :2] += 0.45
    said = words_of_shape([(placed, skewed)])
    assert len(said) == 1 and "skewed" in said[0]


@pytest.mark.parametrize("held", [True, False])
def test_quads_in_held_corners_are_not_tried_to_be_opened(held):
    """As sharp as the border there they stay, unless the corner itself may slide."""
    position, quads = grid(3)
    n = len(position)
    ring = np.array([0, 1, 2, 3, 7, 11, 15, 14, 13, 12, 8, 4])
    border = np.isin(np.arange(n), ring)
    position[0] = [-6.0, -6.0, 0.0]
    guides = guided(*sheet(16, 3.0), n, border & held)
    guides.beside[ring] = np.stack([np.roll(ring, 1), np.roll(ring, -1)], axis=1)
    sharp = oriented_quality(position, quads, guides)
    assert np.flatnonzero(sharp < 0.5).tolist() == [0]
    found = quality_to_mend(position, quads, guides)
    assert found[0] == (1.0 if held else sharp[0])
    np.testing.assert_array_equal(found[1:], sharp[1:])
    moved = worst_opened(position.copy(), quads, guides, Progress())
    assert len(moved) == 0 if held else len(moved) > 0


@pytest.mark.once
def test_a_sharp_border_is_evened_out_once(monkeypatch):
    """What only fills its corners is no reason for another way."""
    evened, ways = finished._evened, []

    def watched(laid, grid, placed, steps, thin, progress):
        ways.append(thin)
        return evened(laid, grid, placed, steps, thin, progress)

    monkeypatch.setattr(finished, "_evened", watched)
    position, quads = grid(20)
    position[:, 0] += 3.0 * position[:, 1]
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    made = core.remesh(position, triangles, core.RemeshSettings(quads=200))
    assert 0.0 < scaled_jacobian(made.vertices, made.quads).min() < 0.5
    assert ways == [True]


@pytest.mark.once
@pytest.mark.parametrize(
    ("tries", "kept"),
    [
        # Folded and bad quads, the least Jacobian, and vertices that leave the surface to unfold.
        ([(0, 1, 0.1, 0), (0, 0, 0.6, 0)], 1),
        ([(0, 1, 0.2, 0), (0, 2, 0.1, 0), (0, 1, 0.15, 0)], 0),
        ([(0, 1, 0.1, 0), (1, 1, -0.1, 3)], 0),
        ([(1, 1, -0.1, 3), (2, 2, -0.2, 0)], 1),
    ],
)
def test_the_better_layout_is_kept(monkeypatch, tries, kept):
    """Where quads are bad another layout is tried, and never makes worse what all quads hold."""
    evened, end, results = finished._evened, finished.finished, []
    given = iter(tries)

    def told(*arguments):
        one, quality, _ = evened(*arguments)
        folded, bad, least, _ = next(given)
        quality[:bad] = least
        return replace(one, folded=folded, bad=bad, least=least), quality, quality

    def unfolded(one, _):
        left = next(left for folded, _, least, left in tries if least == one.least)
        return replace(one, folded=0, left=left, farthest=0.1 * left)

    def watched(*arguments):
        results.append(end(*arguments))
        return results[-1]

    monkeypatch.setattr(finished, "_evened", told)
    monkeypatch.setattr(finished, "_unfolded", unfolded)
    monkeypatch.setattr(finished, "finished", watched)
    monkeypatch.setattr(finished, "ATTEMPTS", len(tries))
    monkeypatch.setattr(finished, "POOR", -1.0)
    mesh = torus(columns=48, rows=24)
    core.remesh(mesh.vertices, mesh.triangles, core.RemeshSettings(quads=200))
    assert next(given, None) is None
    assert [one.least for one in results] == [tries[kept][2]]


def test_a_place_that_cannot_be_mended_does_not_hold_up_the_others(monkeypatch):
    position, quads = grid(16)
    row = np.arange(289).reshape(17, 17)
    good, hopeless = row[3, 3], row[13, 13]
    position[good] += [0.6, 0.6, 0.0]
    position[hopeless] += [0.45, 0.45, 0.0]
    start = position.copy()
    guides = guided(*sheet(16, 3.0), len(position))
    quality = mending.oriented_quality

    def stubborn(place, some, held):
        found = quality(place, some, held)
        at = (some == hopeless).any(axis=1)
        moved = (place[hopeless] != start[hopeless]).any()
        return np.where(at, -1.0 if moved else 0.5, found)

    monkeypatch.setattr(mending, "oriented_quality", stubborn)
    mending.mend(position, quads, guides, Progress())
    assert np.array_equal(position[hopeless], start[hopeless])
    others = ~(quads == hopeless).any(axis=1)
    assert quality(position, quads, guides)[others].min() > 0.69


def test_the_best_of_the_rounds_on_the_last_bad_quads_is_kept(monkeypatch):
    position, quads = grid(8)
    row = int(np.arange(81).reshape(9, 9)[4, 4])
    regular, way = position[row].copy(), np.array([1.0, 1.0, 0.0])
    position[row] += [0.8, 0.8, 0.0]
    guides = guided(*sheet(8, 3.0), len(position))
    offs = iter([0.8, 0.8, 0.7, 0.6, *[1.5] * 100])

    def wandering(place, *_):
        off = next(offs)
        place[row] = regular + off * way

    monkeypatch.setattr(worst, "_tried", wandering)
    assert worst_opened(position, quads, guides, Progress()).tolist() == [row]
    np.testing.assert_allclose(position[row], regular + 0.6 * way)


def test_slopes_of_squaring_are_those_of_its_sum():
    random = np.random.default_rng(1)
    position, quads = grid(4)
    position += 0.25 * random.normal(size=position.shape) * [1.0, 1.0, 0.1]
    q = len(quads)
    turn = random.uniform(0.0, np.pi, q)
    x = np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1)
    y = np.cross([0.0, 0.0, 1.0], x)
    axes = np.broadcast_to(np.eye(3)[:2], (len(position), 2, 3))
    pull = random.uniform(0.0, 1.0, q)
    problem = Squaring(position[quads], x, y, pull, quads, axes, 0.1, 0.7)
    unknown = 0.1 * random.normal(size=2 * len(position))
    _, slope = problem._value(unknown)
    step = 1e-6 * np.eye(len(unknown))
    ahead = np.array([problem._value(unknown + by)[0] for by in step])
    behind = np.array([problem._value(unknown - by)[0] for by in step])
    assert np.abs((ahead - behind) / 2e-6 - slope).max() < 1e-6 * np.abs(slope).max()


def test_squaring_counts_the_worst_corner():
    """Of quads whose corners lack as much together, that with one bad corner lacks more."""
    position, quads = grid(1)
    x, y, axes = np.eye(3)[:1], np.eye(3)[1:2], np.zeros((4, 1, 3))
    problem = Squaring(position[quads], x, y, np.zeros(1), quads, axes, 0.0, 0.0)
    even, steep = problem._lack(np.full((1, 4), 0.9))
    one, steeper = problem._lack(np.array([[0.6, 1.0, 1.0, 1.0]]))
    assert even == pytest.approx(0.4, abs=0.01)
    assert one > 2.5 * even
    assert steeper[0, 0] > 2.5 * steep[0, 0] and steeper[0, 1] < 1e-3


def test_a_step_that_is_too_long_is_shortened(monkeypatch):
    """Where quads bend far it makes the mean worse, and no quad bad."""
    step = Squaring.step
    monkeypatch.setattr(Squaring, "step", lambda problem: 3.0 * step(problem))
    position, quads = grid(9)
    edge = (position[:, :2] == 0.0).any(axis=1) | (position[:, :2] == 9.0).any(axis=1)
    shaken = np.random.default_rng(2).uniform(-0.05, 0.05, (100, 2))
    position[~edge, :2] += shaken[~edge]
    guides = guided(*sheet(9, 3.0), len(position), edge)
    before = scaled_jacobian(position, quads).mean()
    squared(position, quads, guides, guides, Progress())
    assert scaled_jacobian(position, quads).mean() > before


@pytest.mark.parametrize("turn", [0.0, 20.0])
def test_squared_corners_and_directions(turn):
    """On a plane nothing is in the way: quads become rectangles along the directions; at the
    border, which stays, they are bent as little as before."""
    position, quads = grid(9)
    edge = (position[:, :2] == 0.0).any(axis=1) | (position[:, :2] == 9.0).any(axis=1)
    inside = np.flatnonzero(~edge)
    shaken = np.random.default_rng(2).uniform(-0.3, 0.3, (len(inside), 2))
    position[inside, :2] += shaken
    guides = guided(*sheet(9, 3.0), len(position), edge)
    angle = np.radians(turn)
    guides.direction[:] = [np.cos(angle), np.sin(angle), 0.0]
    before = scaled_jacobian(position, quads)
    squared(position, quads, guides, guides, Progress())
    after = scaled_jacobian(position, quads)
    assert after.mean() > before.mean() + (0.05 if turn == 0.0 else 0.02)
    assert (after >= np.minimum(before, 0.6) - 1e-9).all()
    if turn == 0.0:
        assert after.min() > 0.95


def test_directions_count_where_the_curvatures_differ():
    """At umbilics they do not; the mean over the area is 1 where they are sure."""
    mesh = ellipsoid(subdivisions=4)
    detection = core.detect(mesh.vertices, mesh.triangles)
    given = Given(mesh.triangles, detection, None, None, None, None)
    guide = core.Guide(mesh.vertices, mesh.triangles, detection)
    laid = prepare(guide, given, core.RemeshSettings(quads=300), core.Progress()).parts[0]
    weight = direction_weights(laid.working, laid.wishes, laid.planned, laid.map_.crosses)
    surface = laid.working.surface
    _, area = surface.face_normal_area
    assert (weight >= 0.0).all()
    assert (weight * area).sum() / area.sum() == pytest.approx(1.0, abs=0.1)
    middle = surface.vertices[surface.triangles].mean(axis=1) * surface.unit + surface.origin
    _, at = cKDTree(middle).query(detection.umbilics.position)
    assert weight[at].max() < 0.2


@pytest.mark.slow
def test_squaring_makes_the_mean_better_and_costs_no_angle(monkeypatch):
    made = []
    for square in (lambda *_: np.zeros(0, np.int64), squared):
        monkeypatch.setattr(finished, "squared", square)
        made.append(core.remesh(*bumpy(3), core.RemeshSettings(quads=800)))
    means = [scaled_jacobian(one.vertices, one.quads).mean() for one in made]
    assert means[1] > means[0] + 0.001
    guide = core.Guide(*bumpy(3), core.detect(*bumpy(3)))
    poles = guide.guidance().poles
    angles = []
    for one in made:
        starts = np.arange(0, one.quads.size + 1, 4)
        checked = core.check_topology(one.vertices, one.quads.ravel(), starts, guide, poles)
        angles.append(checked.mean_angle)
    assert angles[1] < angles[0] + 0.1


@pytest.mark.parametrize("across", [0.01, 0.02, 0.05])
def test_vertices_on_a_line_that_turns_back_keep_their_order(across):
    """Beside each other on a narrow tooth, each is nearest to where others are."""
    up = np.linspace(0.0, 1.0, 11)
    side = np.stack([0.0 * up, up, 0.0 * up], axis=1)
    line = np.concatenate([side, side[::-1] + np.array([across, 0.0, 0.0])])
    position, quads = grid(4, 0.25)
    row = np.arange(5)
    position[row] = line[[0, 3, 6, 9, 12]]
    guides = guided(position, quads[:, :3], len(position))
    curve, beside = guides.curve.copy(), guides.beside.copy()
    rows = row[1:-1]
    curve[rows], beside[rows] = 0, np.stack([rows - 1, rows + 1], axis=1)
    guides = replace(guides, curve=curve, beside=beside, curves={0: (line[:-1], line[1:])})
    step = np.tile([across, 0.0, 0.0], (3, 1))
    moved = moved_along(position[rows], step, rows, position, quads, guides)
    assert (np.abs(moved[:, 0]) <= 1e-12).all()
    assert (np.diff(moved[:, 1]) > 0.1).all()


def test_vertices_on_a_ring_go_over_its_beginning():
    angle = np.linspace(0.0, 2.0 * np.pi, 65)
    ring = np.column_stack([np.cos(angle), np.sin(angle), 0.0 * angle])
    ring[-1] = ring[0]
    way = moved_on(ring, ring[[60, 4, 16]], ring[56] - ring[4])
    turned = np.arctan2(way[1], way[0])
    assert -angle[2] < turned < angle[2]
    way = moved_on(ring, ring[[48, 60, 4]], ring[8] - ring[60])
    assert -angle[2] < np.arctan2(way[1], way[0]) < angle[2]


def test_an_end_that_left_the_line_is_not_passed():
    """Past the line's own end or beside it, its place along the line says little."""
    line = np.column_stack([np.linspace(0.0, 1.0, 11), np.zeros(11), np.zeros(11)])
    way = moved_on(line, np.array([[0.2, 0.0, 0.0], [0.6, 0.0, 0.0], [1.4, 0.2, 0.0]]), [0.9, 0, 0])
    assert np.isclose(way[0], 0.6 + 0.4 * np.hypot(0.8, 0.2), atol=1e-9)
    way = moved_on(line, np.array([[0.2, 0.0, 0.0], [0.6, 0.0, 0.0], [0.5, 0.2, 0.0]]), [0.9, 0, 0])
    assert np.isclose(way[0], 0.6 + 0.4 * np.hypot(0.1, 0.2), atol=1e-9)


def moved_on(line: np.ndarray, at: np.ndarray, step) -> np.ndarray:
    """Where the second of three vertices `at` (3, 3) on a line comes by a step (3,)."""
    position, quads = grid(4, 0.25)
    position[:3] = at
    guides = guided(position, quads[:, :3], len(position))
    curve, beside = guides.curve.copy(), guides.beside.copy()
    curve[1], beside[1] = 0, [0, 2]
    guides = replace(guides, curve=curve, beside=beside, curves={0: (line[:-1], line[1:])})
    row = np.array([1])
    return moved_along(position[row], np.asarray(step)[None], row, position, quads, guides)[0]
