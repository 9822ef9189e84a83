"""Pairs that a finer fit does not show are noise: which of them it shows."""

import numpy as np
import pytest

from core.umbilics.judged import PAIR_REACH, _unseen_pairs


@pytest.mark.parametrize(
    "apart, shown, unseen",
    [
        # In radii of the fit; whether each of the two is shown; whether the pair is unseen.
        (0.5, (True, True), False),
        (0.5, (True, False), True),
        (0.5, (False, True), True),
        (0.5, (False, False), True),
        # A fit at one of the two does not reach the other.
        (4.0, (True, False), False),
        (4.0, (False, True), False),
        (4.0, (False, False), True),
    ],
)
def test_of_a_close_pair_both_have_to_be_seen_of_others_one(apart, shown, unseen):
    assert 0.5 < PAIR_REACH < 4.0
    radius = np.full((3, 3), 0.2)
    position = np.array([[0.0, 0.0, 0.0], [0.2 * apart, 0.0, 0.0], [0.01, 0.0, 0.0]])
    # The third cancels with nothing.
    partner, located = np.array([1, 0, -1]), np.array([*shown, False])
    found = _unseen_pairs(position, partner, located, radius)
    assert found.tolist() == [unseen, unseen, False]
