"""Quads where there is little room for them: thin rods, torn sheets, slivers. None is folded."""

import numpy as np
import pytest
from surfaces import plane, torus

import core
from core.base.progress import Progress
from core.mesh.mending.repair import clean
from core.retopology.quads import preparation
from core.retopology.quads.conformity import conformity, scaled_jacobian
from core.retopology.quads.finishing import finished, unlaid
from core.retopology.quads.finishing.faults.unfolding import laid_on, own_quality
from core.retopology.quads.finishing.guides import Guides
from core.retopology.quads.finishing.parting import without_folds
from core.retopology.quads.finishing.projection import ClosestPoints
from core.retopology.quads.layout.effort import Effort
from core.retopology.quads.surface.decimation import coarsened
from core.retopology.quads.surface.subdivision import Triangles, refined


def unfolded(made):
    """Conforming, and no quad folded or turned against those around."""
    found = conformity(made.quads, len(made.vertices))
    assert found.manifold
    assert scaled_jacobian(made.vertices, made.quads).min() > 0.0
    assert own_quality(made.vertices, made.quads).min() > 0.0
    return found


def torn(seed, share):
    """A sheet of which triangles are missing here and there."""
    mesh = plane(24)
    kept = np.random.default_rng(seed).uniform(size=len(mesh.triangles)) > share
    return mesh.vertices, mesh.triangles[kept]


def as_triangles(vertices, triangles):
    count = len(triangles)
    return Triangles(
        np.asarray(vertices, float),
        np.asarray(triangles, np.int64),
        np.zeros((len(vertices), 0)),
        np.arange(count),
        np.zeros(3 * count, np.int8),
    )


@pytest.mark.slow
@pytest.mark.parametrize("minor", [0.1])
def test_rods_thinner_than_a_quad(minor):
    """Where there is room for three quads around none is folded, and the rod stays a rod."""
    mesh = torus(2.0, minor, columns=160, rows=8)
    made = core.remesh(mesh.vertices, mesh.triangles, core.RemeshSettings(quads=160))
    assert unfolded(made).characteristic == 0
    ring = np.hypot(*made.vertices[:, :2].T) - 2.0
    side = np.linalg.norm(made.vertices[made.quads[:, 1]] - made.vertices[made.quads[:, 0]], axis=1)
    assert np.abs(np.hypot(ring, made.vertices[:, 2]) - minor).max() < 1.5 * side.mean()


def bent_rod(radius=0.02, around=16, along=120):
    """A closed tube of length 2 and more that winds to and fro."""
    share = np.linspace(0.0, 1.0, along)
    turn = 6.0 * np.pi * share
    line = np.stack([2.0 * share, 0.15 * np.sin(turn), 0.1 * np.cos(turn)], axis=1)
    ahead = np.gradient(line, axis=0)
    x = np.cross(ahead, [0.0, 1.0, 0.3])
    x /= np.linalg.norm(x, axis=1)[:, None]
    y = np.cross(ahead, x)
    y /= np.linalg.norm(y, axis=1)[:, None]
    angle = 2.0 * np.pi * np.arange(around)[:, None] / around
    ring = np.cos(angle) * x[:, None] + np.sin(angle) * y[:, None]
    points = np.concatenate([(line[:, None] + radius * ring).reshape(-1, 3), line[[0, -1]]])
    row = np.arange(along * around).reshape(along, around)
    beside = np.roll(row, -1, axis=1)
    first, last = np.full(around, row.size), np.full(around, row.size + 1)
    triangles = [
        np.stack([row[:-1], beside[:-1], beside[1:]], axis=-1).reshape(-1, 3),
        np.stack([row[:-1], beside[1:], row[1:]], axis=-1).reshape(-1, 3),
        np.stack([first, beside[0], row[0]], axis=-1),
        np.stack([last, row[-1], beside[-1]], axis=-1),
    ]
    return points, np.concatenate(triangles)


@pytest.mark.slow
def test_rods_keep_a_layout_that_needs_fewer_quads_than_their_triangles():
    """Twelve are far too few for eight poles that far apart; cut in three it had 972."""
    made = core.remesh(*bent_rod(), core.RemeshSettings(quads=12))
    assert unfolded(made).characteristic == 2
    assert len(made.pole_valence) == 8
    assert len(made.quads) < 200


@pytest.mark.once
@pytest.mark.parametrize("seed", [1])
def test_torn_sheets_that_are_cut(monkeypatch, seed):
    """Their borders become coarser too: there are about as many quads as were asked for."""
    monkeypatch.setattr(preparation, "laid_out", lambda *_: None)
    vertices, triangles = torn(seed, 0.005)
    made = core.remesh(vertices, triangles, core.RemeshSettings(quads=500))
    unfolded(made)
    assert 0.9 * 500 < len(made.quads) < 1.35 * 500


def test_borders_coarsened_keep_the_topology():
    vertices, triangles = torn(2, 0.01)
    mesh = as_triangles(vertices, triangles)
    made = coarsened(mesh, len(triangles) // 8, Progress(), borders=True)
    before, after = (clean(one.vertices, one.triangles)[0] for one in (mesh, made))
    assert len(made.triangles) < len(triangles) // 4
    assert after.euler_characteristic.sum() == before.euler_characteristic.sum()
    held = coarsened(mesh, len(triangles) // 8, Progress())
    assert len(held.triangles) > len(made.triangles)


def test_triangles_without_area_do_not_stop_the_coarsening():
    mesh = plane(24)
    vertices = np.array(mesh.vertices, float)
    left = vertices[:, 0] < np.median(vertices[:, 0])
    vertices[left, 1] = 0.0
    made = coarsened(as_triangles(vertices, mesh.triangles), 60, Progress(), borders=True)
    assert len(made.triangles) < 150


def test_refining_ends_at_a_number_of_triangles():
    needle = as_triangles([[0, 0, 0], [1, 0, 0], [0.5, 1e-9, 0]], [[0, 1, 2]])
    assert len(refined(needle, 1e-6, 40, 500).triangles) <= 2000


def test_effort_ends():
    effort = Effort(100)
    assert effort.left
    while effort.left:
        effort.spend(1000)
    assert not effort.left


def test_parting_does_not_fold():
    """What would fold by being moved stays, with what hangs on it; the rest goes."""
    at = np.arange(9.0)
    position = np.stack([*(x.ravel() for x in np.meshgrid(at, at)), np.zeros(81)], axis=1)
    row = np.arange(81).reshape(9, 9)
    corners = row[:-1, :-1], row[:-1, 1:], row[1:, 1:], row[1:, :-1]
    quads = np.stack(corners, axis=-1).reshape(-1, 4)
    moved = position.copy()
    moved[20] += [0.0, 0.0, 0.2]
    moved[60] += [2.5, 0.0, 0.2]
    found = without_folds(moved, position, quads)
    assert own_quality(moved, quads).min() <= 0.0 < own_quality(found, quads).min()
    assert np.array_equal(found[20], moved[20]) and np.array_equal(found[60], position[60])


def test_a_quad_is_not_left_folded_by_those_beside_it():
    """Both beside it turn over, and it alone faces the other way although it has not moved."""
    across, up = np.meshgrid(np.arange(4.0), np.arange(2.0))
    position = np.stack([across.ravel(), up.ravel(), np.zeros(8)], axis=1)
    quads = np.array([[k, k + 1, k + 5, k + 4] for k in range(3)])
    moved = position.copy()
    moved[[0, 4], 0], moved[[3, 7], 0] = 4.0, -2.0
    assert (own_quality(moved, quads) > 0.0).tolist() == [True, False, True]
    assert own_quality(without_folds(moved, position, quads), quads).min() > 0.0
    mesh = plane(2)
    surface, _ = clean(mesh.vertices, mesh.triangles)
    none = np.full(8, -1)
    guides = Guides(
        surface=ClosestPoints(surface.vertices, surface.triangles, surface.twin),
        direction=np.tile([1.0, 0.0, 0.0], (len(surface.triangles), 1)),
        size=np.ones(len(surface.triangles)),
        fixed=none >= 0,
        curve=none,
        beside=np.stack([none, none], axis=1),
        curves={},
    )
    going = (moved != position).any(axis=1)
    laid = laid_on(position, going, quads, guides, np.where(going[:, None], moved, np.nan))
    assert own_quality(laid, quads).min() > 0.0


@pytest.mark.once
def test_the_last_bad_quads_are_opened_on_the_surface(monkeypatch):
    relaxed = finished.relaxed

    def with_a_skewed_quad(start, quads, guides, steps, progress):
        position, triangle = relaxed(start, quads, guides, steps, progress)
        one, across = quads[7, 0], quads[7, 2]
        position[one] = guides.surface(position[[one]] * 0.55 + position[[across]] * 0.45)[1][0]
        assert scaled_jacobian(position, quads).min() < 0.3
        return position, triangle

    mesh = torus(24, 12)
    monkeypatch.setattr(finished, "relaxed", with_a_skewed_quad)
    made = core.remesh(mesh.vertices, mesh.triangles, core.RemeshSettings(quads=150))
    assert scaled_jacobian(made.vertices, made.quads).min() > 0.5


@pytest.mark.once
def test_a_fold_of_cut_pieces_takes_back_only_what_is_around_it(monkeypatch):
    mend, means = unlaid.mend, []

    def nothing(position, quads, guides, progress):
        pass

    def with_a_fold(position, quads, guides, progress):
        mend(position, quads, guides, progress)
        inner = int(np.flatnonzero(~guides.fixed)[0])
        position[inner] = 2.0 * position.mean(axis=0) - position[inner]
        assert (own_quality(position, quads) <= 0.0).any()

    monkeypatch.setattr(preparation, "laid_out", lambda *_: None)
    for mending in (nothing, with_a_fold):
        monkeypatch.setattr(unlaid, "mend", mending)
        made = core.remesh(*torn(1, 0.1), core.RemeshSettings(quads=150))
        unfolded(made)
        means.append(scaled_jacobian(made.vertices, made.quads).mean())
    assert means[1] > means[0] + 0.05
