"""Persistence against its definition, written out slowly, and against drawn examples."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import sparse
from scipy.sparse import csgraph
from surfaces import icosphere, random_points

from core.curvature.tolerances import PAIR_NOISE
from core.mesh.mending.repair import clean
from core.mesh.surface import Surface
from core.umbilics.pairing.persistence import (
    made_by_noise,
    measure_persistence,
    noise_multiple,
    survivors,
    trust_ratio,
)


def _surface(vertices: np.ndarray, triangles: np.ndarray) -> Surface:
    """The surface of a mesh that needs no cleaning."""
    return clean(vertices, triangles)[0]


def _patch(count: int, seed: int) -> Surface:
    points, triangles = random_points(count, (0, 0), (1, 1), seed)
    return _surface(np.column_stack([points, np.zeros(count)]), triangles)


def _strip(length: int) -> Surface:
    """Two rows of vertices, 0 1 2 ... below and above; triangles 2i and 2i + 1 in cell i."""
    x = np.arange(length, dtype=float)
    low = np.column_stack([x, np.zeros(length), np.zeros(length)])
    i = np.arange(length - 1)
    lower = np.stack([i, i + 1, i + 1 + length], axis=1)
    upper = np.stack([i, i + 1 + length, i + length], axis=1)
    triangles = np.stack([lower, upper], axis=1).reshape(-1, 3)
    return _surface(np.concatenate([low, low + np.array([0, 1, 0])]), triangles)


def _along(values: list[float]) -> np.ndarray:
    return np.array(values * 2, dtype=float)


def _sublevel(surface: Surface, gap, triangle, regions, level, strictly) -> np.ndarray:
    """Component of each umbilic in the sublevel set {gap <= level}, or {gap < level}."""
    n, k = len(gap), len(triangle)
    inside = gap < level if strictly else gap <= level
    rows = np.repeat(np.arange(n), np.diff(surface.neighbour_start))
    pairs = [np.stack([rows, surface.neighbours], axis=1)]
    for number, held in enumerate([*([row] for row in triangle), *regions]):
        for corner in np.unique(surface.triangles[held]):
            pairs.append(np.array([[n + number, corner]]))
    pairs = np.concatenate(pairs)
    open_ = np.concatenate([inside, np.ones(k + len(regions), dtype=bool)])
    pairs = pairs[open_[pairs].all(axis=1)]
    size = n + k + len(regions)
    graph = sparse.coo_matrix((np.ones(len(pairs)), pairs.T), shape=(size, size))
    return csgraph.connected_components(graph, directed=False)[1][n : n + k]


def _check(surface: Surface, gap, triangle, index, regions=()) -> None:
    """Everything that the definition fixes, whichever opposite pair is chosen to cancel."""
    persistence, partner = measure_persistence(surface, gap, triangle, index, regions)
    if len(index) == 0:
        assert persistence.shape == partner.shape == (0,)
        return
    finite = np.isfinite(persistence)
    assert ((partner >= 0) == finite).all()
    assert np.isin(persistence[finite], gap).all()
    if (np.abs(index) == 0.5).all():
        assert (partner[partner[finite]] == np.flatnonzero(finite)).all()
        assert (index[partner[finite]] == -index[finite]).all()
        assert (persistence[partner[finite]] == persistence[finite]).all()
    for level in np.unique(gap):
        before = _sublevel(surface, gap, triangle, regions, level, strictly=True)
        within = _sublevel(surface, gap, triangle, regions, level, strictly=False)
        left = survivors(persistence, np.nextafter(level, np.inf))
        total = np.bincount(within, index)
        # Cancelling stops at one sign, in every component of every sublevel set.
        assert np.array_equal(np.bincount(within, index * left), total[: within.max() + 1])
        if (np.abs(index) == 0.5).all():
            assert np.array_equal(np.bincount(within, 0.5 * left), np.abs(total))
            now = persistence == level
            assert (before[now] != before[partner[now]]).all()
            assert (within[now] == within[partner[now]]).all()


@st.composite
def _problems(draw, charges=(-0.5, 0.5)):
    count = draw(st.integers(4, 40))
    seed = draw(st.integers(0, 10_000))
    pieces = [_patch(count, seed)]
    if draw(st.booleans()):
        pieces.append(_patch(draw(st.integers(4, 12)), seed + 1))
    shift = np.cumsum([0] + [len(piece.vertices) for piece in pieces])
    surface = _surface(
        np.concatenate([piece.vertices + 3 * i for i, piece in enumerate(pieces)]),
        np.concatenate([piece.triangles + shift[i] for i, piece in enumerate(pieces)]),
    )
    random = np.random.default_rng(seed)
    # Few different values make many ties.
    gap = random.integers(0, draw(st.sampled_from([3, 1_000_000])), len(surface.vertices)) / 7.0
    m = len(surface.triangles)
    k = draw(st.integers(0, min(m, 14)))
    triangle = random.permutation(m)[:k]
    index = random.choice(charges, k)
    regions = []
    if draw(st.booleans()):
        regions.append(np.setdiff1d(random.integers(0, m, 3), triangle))
    return surface, gap, triangle, index, [rows for rows in regions if len(rows)]


@pytest.mark.once
@given(_problems())
@settings(max_examples=150, deadline=None)
def test_follows_its_definition(problem):
    _check(*problem)


@pytest.mark.once
@given(_problems(charges=(-1.5, -1.0, -0.5, 0.0, 0.5, 1.0)))
@settings(max_examples=100, deadline=None)
def test_larger_indices_keep_the_sum(problem):
    _check(*problem)


def test_a_pair_cancels_at_its_pass():
    surface = _strip(7)
    gap = _along([1, 0.5, 2, 3, 2, 0.25, 1])
    persistence, partner = measure_persistence(
        surface, gap, np.array([2, 9]), np.array([0.5, -0.5])
    )
    assert persistence.tolist() == [3.0, 3.0]
    assert partner.tolist() == [1, 0]


def test_the_closest_opposite_cancels():
    surface = _strip(13)
    # Two lemons meet first; the star then takes the one at its side.
    gap = _along([9, 1, 1, 1, 1, 1, 1, 5, 5, 0.5, 0.5, 0.5, 9])
    for star in (20, 21):
        persistence, partner = measure_persistence(
            surface, gap, np.array([2, 11, star]), np.array([0.5, 0.5, -0.5])
        )
        assert persistence.tolist() == [np.inf, 5.0, 5.0]
        assert partner.tolist() == [-1, 2, 1]


def test_umbilics_meet_through_a_region():
    surface = _strip(7)
    gap = _along([0.1, 0.1, 2, 3, 2, 0.2, 0.2])
    triangle, index = np.array([0, 11]), np.array([0.5, -0.5])
    region = np.arange(2, 10)
    persistence, _ = measure_persistence(surface, gap, triangle, index, [region])
    assert persistence.tolist() == [0.2, 0.2]


def test_components_never_meet():
    one, two = _strip(4), _strip(5)
    surface = _surface(
        np.concatenate([one.vertices, two.vertices + np.array([0.0, 0.0, 5.0])]),
        np.concatenate([one.triangles, two.triangles + 8]),
    )
    gap = np.ones(18)
    persistence, partner = measure_persistence(
        surface, gap, np.array([0, 7]), np.array([0.5, -0.5])
    )
    assert np.isinf(persistence).all() and (partner == -1).all()


def test_nothing_to_cancel():
    surface = _strip(4)
    for index in ([], [0.5, 0.5], [0.0, -0.5]):
        triangle = np.arange(len(index))
        persistence, partner = measure_persistence(surface, np.ones(8), triangle, np.array(index))
        assert np.isinf(persistence).all() and (partner == -1).all()


def test_gaps_that_are_not_finite_count_as_the_largest():
    surface = _strip(7)
    gap = _along([1, 0.5, 2, np.nan, 2, 0.25, np.inf])
    persistence, _ = measure_persistence(surface, gap, np.array([2, 9]), np.array([0.5, -0.5]))
    assert persistence.tolist() == [2.0, 2.0]
    persistence, _ = measure_persistence(
        surface, np.full(14, np.nan), np.array([2, 9]), np.array([0.5, -0.5])
    )
    assert persistence.tolist() == [0.0, 0.0]


def test_trust_ratio():
    gap = np.array([0.5, 1.0, np.nan, 2.0])
    assert trust_ratio(np.full(4, 0.2), gap) == pytest.approx(0.6)
    assert trust_ratio(np.full(4, 0.2), 2.0 * gap) == pytest.approx(0.3)
    assert trust_ratio(np.array([0.2, 90.0, 0.1, 0.2]), gap) == pytest.approx(0.6)
    assert trust_ratio(np.full(4, np.nan), gap) == 0.0
    # A sphere or a plane: nothing but regions, no survivor to be trusted.
    assert trust_ratio(np.full(4, 0.2), 0.0 * gap) == 0.0


def test_survivors_of_a_level():
    persistence = np.array([0.1, 0.1, 0.4, 0.4, np.inf])
    assert survivors(persistence, 0.2).tolist() == [False, False, True, True, True]
    assert survivors(persistence, 0.0).all()
    assert survivors(persistence, 0.4).tolist() == [False, False, True, True, True]


def test_noise_makes_pairs():
    persistence = np.array([0.1, 0.1, 0.3, 0.3, 2.0, 2.0, np.inf])
    partner = np.array([1, 0, 3, 2, 5, 4, -1])
    noise = np.full(7, 0.2)
    dropped = made_by_noise(persistence, partner, noise)
    assert dropped.tolist() == [True] * 4 + [False] * 3
    # The clear one of a pair speaks for both.
    noise = np.array([0.2, 0.001, 0.2, 0.2, 50.0, 0.2, 50.0])
    dropped = made_by_noise(persistence, partner, noise)
    assert dropped.tolist() == [False] * 2 + [True] * 2 + [False] * 3
    noise[0] = np.nan
    assert not made_by_noise(persistence, partner, noise)[:2].any()
    noise[1] = 0.2
    assert made_by_noise(persistence, partner, noise)[:2].all()


def test_pairs_at_one_pass_are_judged_apart():
    persistence = np.full(4, 0.3)
    noise = np.array([0.2, 0.2, 0.001, 0.001])
    dropped = made_by_noise(persistence, np.array([1, 0, 3, 2]), noise)
    assert dropped.tolist() == [True, True, False, False]


def test_larger_indices_that_cancel_together_are_judged_together():
    gap = _along([6, 6, 2, 7, 5, 2, 6, 5, 8])
    index = np.array([-1.0, -1.0, 1.5, 0.5])
    persistence, partner = measure_persistence(_strip(9), gap, np.array([0, 2, 4, 6]), index)
    dropped = made_by_noise(persistence, partner, np.array([9.0, 0.1, 0.1, 9.0]))
    assert index[dropped].sum() == 0.0


def test_a_crowd_must_rise_higher():
    def dropped(crowd: int) -> list[bool]:
        count = 2 + 2 * crowd
        persistence = np.append([0.7, 0.7], np.full(2 * crowd, 0.1))
        partner = np.arange(count) ^ 1
        return made_by_noise(persistence, partner, np.full(count, 0.2))[:2].tolist()

    assert dropped(4) == [False, False]
    assert dropped(500) == [True, True]
    assert noise_multiple(1) == noise_multiple(25) == PAIR_NOISE
    assert noise_multiple(25**4) == pytest.approx(2 * PAIR_NOISE)


def test_clean_or_unknown_operators_keep_all():
    persistence = np.array([0.3, 0.3, np.inf, np.nan])
    partner = np.array([1, 0, -1, -1])
    for noise in (1e-4, np.nan, 0.0):
        assert not made_by_noise(persistence, partner, np.full(4, noise)).any()
    none = np.zeros(0, dtype=np.int64)
    assert made_by_noise(np.zeros(0), none, np.zeros(0)).shape == (0,)


@pytest.mark.once
@given(_problems(charges=(-1.5, -1.0, -0.5, 0.5, 1.0, 1.5)), st.integers(0, 1000))
@settings(max_examples=100, deadline=None)
def test_dropping_noise_keeps_the_sum(problem, seed):
    surface, gap, triangle, index, regions = problem
    persistence, partner = measure_persistence(surface, gap, triangle, index, regions)
    noise = np.random.default_rng(seed).uniform(0.0, 0.2, len(index)) * (1.0 + gap.max())
    assert index[made_by_noise(persistence, partner, noise)].sum() == 0.0


def _calls(level: int, umbilics: int) -> int:
    """How many Python and C calls the pairing of random charges on a sphere takes: unlike seconds
    they are the same on every machine."""
    vertices, triangles = icosphere(level)
    surface = _surface(vertices, triangles)
    random = np.random.default_rng(0)
    smooth = 0.5 + np.abs(np.sin(3 * vertices[:, 0]) * np.cos(4 * vertices[:, 1]))
    gap = smooth * random.uniform(0.2, 1.0, len(vertices))
    triangle = random.permutation(len(triangles))[:umbilics]
    index = random.choice([-0.5, 0.5], umbilics)
    count = 0

    def counted(frame, event, argument):
        nonlocal count
        count += event in ("call", "c_call")

    sys.setprofile(counted)
    try:
        persistence, _ = measure_persistence(surface, gap, triangle, index)
    finally:
        sys.setprofile(None)
    assert index[np.isinf(persistence)].sum() == index.sum()
    return count


@pytest.mark.once
def test_work_grows_with_the_umbilics_and_not_with_the_mesh():
    few = _calls(6, 2_000)
    assert _calls(6, 8_000) < 5 * few
    assert _calls(7, 2_000) < 1.5 * few
