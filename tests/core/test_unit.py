"""Vectors and complex numbers made one long, and turns between tangent planes."""

import numpy as np

from core.base.unit import phase, unit
from core.fields.frames import frame
from core.fields.transport import carried, rotation


def test_length_becomes_one_and_nothing_stays_nothing_or_no_turn():
    np.testing.assert_array_equal(phase(np.array([0.0, 0.25j, -3.0, 2.0])), [1.0, 1j, -1.0, 1.0])
    found = unit(np.array([[0.0, 0.0, 0.0], [0.0, 0.5, 0.0], [3.0, 0.0, 4.0]]))
    np.testing.assert_allclose(found, [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.6, 0.0, 0.8]])


def test_a_frame_is_turned_as_the_smallest_rotation_carries_it():
    """Also between planes that are more than a right angle apart."""
    random = np.random.default_rng(0)
    source, target = unit(random.standard_normal((2, 50, 3)))
    e1, e2 = frame(source.T)
    f1, f2 = frame(target.T)
    turn = rotation(e1 + 1j * e2, f1 + 1j * f2)
    np.testing.assert_allclose(np.abs(turn), 1.0)
    moved = carried(e1.T, source, target)
    # e1 is 1 in its own frame, and the turn in the other one.
    expected = turn.real * f1 + turn.imag * f2
    np.testing.assert_allclose(moved, expected.T, atol=1e-9)
