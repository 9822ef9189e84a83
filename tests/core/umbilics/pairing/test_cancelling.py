"""Cancelling in rounds and long lists against the same rule, written out edge by edge."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.umbilics.pairing.cancelling import cancel


def _pairs(units, centres, low, high, saddle, firm=None) -> list[tuple[int, int, float]]:
    """What `cancel` finds, sorted: row of the positive one, row of the negative one, level."""
    first, second, level = cancel(units, centres, low, high, saddle, firm)
    positive = np.where(units[first] > 0, first, second)
    negative = np.where(units[first] > 0, second, first)
    return sorted(zip(positive.tolist(), negative.tolist(), level.tolist(), strict=True))


def _edge_by_edge(units, centres, low, high, saddle, firm=None) -> list[tuple[int, int, float]]:
    """The same by the rule itself: where two components of charges of opposite sign meet, the
    closest two cancel until one sign is left; firm ones only where no others are left."""
    units = units.copy()
    firm = np.zeros(len(units)) if firm is None else firm.astype(float)
    group = np.arange(len(units))
    pairs = []
    for one, two, level in zip(low, high, saddle, strict=True):
        mine, yours = group == group[one], group == group[two]
        while True:
            held = [np.flatnonzero(side & (units != 0)) for side in (mine, yours)]
            if not len(held[0]) or not len(held[1]):
                break
            if (units[held[0][0]] > 0) == (units[held[1][0]] > 0):
                break
            away = np.linalg.norm(centres[held[0]][:, None] - centres[held[1]][None], axis=2)
            away = away**2 + 1e3 * (firm[held[0]][:, None] + firm[held[1]][None])
            i, j = np.unravel_index(away.argmin(), away.shape)
            first, second = held[0][i], held[1][j]
            positive, negative = (first, second) if units[first] > 0 else (second, first)
            pairs.append((positive, negative, level))
            spent = min(abs(units[first]), abs(units[second]))
            units[first] -= np.sign(units[first]) * spent
            units[second] -= np.sign(units[second]) * spent
        group[yours] = group[one]
    return sorted(pairs)


def _tree(random: np.random.Generator, count: int, shape: str) -> tuple[np.ndarray, np.ndarray]:
    """Edges of a random forest, in random order."""
    rows = np.arange(1, count)
    if shape == "chain":
        other = rows - 1
    elif shape == "hub":
        other = np.zeros_like(rows)
    else:
        other = random.integers(0, rows)
    some = random.permutation(count - 1)[: max(count - 1 - random.integers(0, 3), 0)]
    name = random.permutation(count)
    return name[rows[some]], name[other[some]]


@pytest.mark.parametrize("seed", range(6))
def test_a_larger_charge_keeps_what_the_other_lacks(seed):
    random = np.random.default_rng(seed)
    units = random.choice((-3, -1, 0, 1, 2), 40)
    centres = random.uniform(-1, 1, (40, 3))
    low, high = _tree(random, 40, "bushy")
    edges = centres, low, high, np.arange(len(low), dtype=float)
    assert _pairs(units, *edges) == _edge_by_edge(units, *edges)


@pytest.mark.slow
@given(
    st.integers(2, 120),
    st.sampled_from(["chain", "hub", "bushy"]),
    st.sampled_from([(-1, 1), (-1, 1, 1, 1), (-3, -1, 0, 1, 2)]),
    st.integers(0, 10_000),
)
@settings(max_examples=300, deadline=None)
def test_rounds_are_the_walk(count, shape, charges, seed):
    random = np.random.default_rng(seed)
    units = random.choice(charges, count)
    centres = random.uniform(-1, 1, (count, 3))
    low, high = _tree(random, count, shape)
    # Few different gaps: edges of one gap still come one after the other.
    saddle = np.sort(random.integers(0, 9, len(low)) / 3.0)
    given_units = units.copy()
    found = _pairs(units, centres, low, high, saddle)
    assert np.array_equal(units, given_units)
    assert found == _edge_by_edge(units, centres, low, high, saddle)


@pytest.mark.parametrize("positive", [30, 300])
def test_long_lists_meet(positive):
    """Two crowds of opposite sign, each gathered before they meet over the highest edge."""
    random = np.random.default_rng(positive)
    units = np.repeat([1, -1], [positive, 40])
    count = len(units)
    centres = random.uniform(-1, 1, (count, 3))
    low = np.append(np.delete(np.arange(count - 1), positive - 1), 0)
    high = np.append(np.delete(np.arange(1, count), positive - 1), count - 1)
    saddle = np.arange(count - 1) / 7.0
    found = _pairs(units, centres, low, high, saddle)
    assert [pair[2] for pair in found] == [saddle[-1]] * min(positive, 40)
    assert found == _edge_by_edge(units, centres, low, high, saddle)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("firm", [False, True])
def test_a_long_list_that_was_met_grows_and_is_met_again(firm, seed):
    """Crowds in a chain, each gathered before it meets what is left of those before it, which are
    always the longer list."""
    random = np.random.default_rng(seed)
    crowds = [(40, 1), (5, -1), (20, 1), (30, -1), (25, 1), (10, -1)]
    units = np.concatenate([np.full(count, sign) for count, sign in crowds])
    centres = random.uniform(-1, 1, (len(units), 3))
    ends = np.cumsum([count for count, _ in crowds])[:-1]
    inside = np.setdiff1d(np.arange(1, len(units)), ends)
    high = np.concatenate([inside, ends])
    saddle = np.arange(len(high)) / 7.0
    chosen = random.random(len(units)) < 0.4 if firm else None
    found = _pairs(units, centres, high - 1, high, saddle, chosen)
    assert found == _edge_by_edge(units, centres, high - 1, high, saddle, chosen)
    assert len(found) == 45


@pytest.mark.parametrize("seed", range(6))
def test_firm_ones_stay_where_others_can_go(seed):
    random = np.random.default_rng(seed)
    units = random.choice([-1, 1], 60)
    centres = random.uniform(-1, 1, (60, 3))
    low, high = _tree(random, 60, "bushy")
    saddle = np.sort(random.integers(0, 9, len(low)) / 3.0)
    firm = random.random(60) < 0.5
    found = _pairs(units, centres, low, high, saddle, firm)
    assert found == _edge_by_edge(units, centres, low, high, saddle, firm)
    assert found != _pairs(units, centres, low, high, saddle)


def test_nothing_meets():
    none = np.zeros(0, dtype=np.int64)
    for units in ([], [1, -1]):
        pairs = cancel(np.array(units, dtype=np.int64), np.zeros((len(units), 3)), none, none, none)
        assert [len(part) for part in pairs] == [0, 0, 0]
