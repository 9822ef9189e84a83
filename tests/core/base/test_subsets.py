"""Rows of arrays: their places, and those that follow one another."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from core.base.subsets import places_in, spans

sizes = st.lists(st.integers(0, 5), max_size=8)


@given(sizes, st.integers(0, 3))
def test_spans_are_ranges_one_after_the_other(count: list[int], seed: int) -> None:
    first = np.random.default_rng(seed).integers(-9, 9, len(count))
    ranges = [range(one, one + size) for one, size in zip(first.tolist(), count, strict=True)]
    assert spans(first, np.array(count, int)).tolist() == [row for some in ranges for row in some]


@given(sizes)
def test_spans_may_all_begin_at_one_place(count: list[int]) -> None:
    wanted = [2 + step for size in count for step in range(size)]
    assert spans(2, np.array(count, int)).tolist() == wanted


def test_places_are_those_among_the_rows() -> None:
    assert places_in(np.array([4, 1]), 6).tolist() == [-1, 1, -1, -1, 0, -1]
