"""Corners of quads opened by moving vertices: what is minimized, and what comes of it."""

import numpy as np
import pytest

from core.retopology.quads.finishing.opening import (
    FARTHEST,
    LEAST_SIDE,
    NEARLY,
    NOTHING,
    SOFT,
    Opening,
    Squaring,
    least_in_box,
)

UP = np.array([[0.0, 0.0, 1.0]])
IN_PLANE = np.eye(3)[None, :2]
SQUARE = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])


def patch(moved):
    """Four quads around a vertex, the only one that moves, in the plane: the opening of their
    corners up to right ones, without a cost of moves."""
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(3.0), np.arange(3.0)))
    points = np.stack([x, y, np.zeros(9)], axis=1)
    points[4] += moved
    quads = np.array([[0, 1, 4, 3], [1, 2, 5, 4], [3, 4, 7, 6], [4, 5, 8, 7]])
    local = np.where(quads == 4, 0, -1)
    return Opening(points[quads], np.repeat(UP, 4, axis=0), local, IN_PLANE, 0.0, 1.0)


def squaring(base, up, local, axes, stay, wanted):
    """That of pulls to directions somehow in the planes that the quads are seen in."""
    x = np.cross(up, [0.3, 0.5, 0.8])
    x /= np.linalg.norm(x, axis=1)[:, None]
    pull = np.linspace(0.2, 1.0, len(base))
    return Squaring(base, x, np.cross(up, x), pull, local, axes, stay, wanted)


@pytest.mark.parametrize("kind", [Opening, squaring])
def test_slopes_are_those_of_the_sum(kind):
    """Also of a folded quad, of short sides and of a vertex that moves along one axis alone."""
    random = np.random.default_rng(0)
    points = random.normal(size=(7, 3))
    points[3] = points[2] + 0.05
    quads = np.array([[0, 1, 2, 3], [3, 2, 4, 5], [0, 5, 6, 1]])
    local = np.where(quads < 5, quads, -1)
    axes = random.normal(size=(5, 2, 3))
    axes[1, 1] = 0.0
    up = random.normal(size=(3, 3))
    up /= np.linalg.norm(up, axis=1)[:, None]
    problem = kind(points[quads], up, local, axes, 0.3, 0.9)
    unknown = 0.1 * random.normal(size=10)
    _, slope = problem._value(unknown)
    step = 1e-6 * np.eye(10)
    ahead = np.array([problem._value(unknown + by)[0] for by in step])
    behind = np.array([problem._value(unknown - by)[0] for by in step])
    np.testing.assert_allclose((ahead - behind) / 2e-6, slope, atol=1e-6 * np.abs(slope).max())
    # Along an axis that is none only the move itself costs.
    assert slope[3] == pytest.approx(2.0 * 0.3 * unknown[3])


@pytest.mark.parametrize("moved", [(0.3, 0.2, 0.0), (-0.4, 0.1, 0.0), (0.0, -0.45, 0.0)])
def test_a_vertex_goes_back_to_where_all_corners_are_right(moved):
    step = patch(moved).step()
    np.testing.assert_allclose(step, [[-part for part in moved]], atol=5e-3)


def test_a_vertex_moves_by_no_more_than_its_box():
    """From two sides away, over a fold: in each axis by the most there is, or not at all."""
    problem = patch((2.5, 0.0, 0.0))
    step = problem.step() / problem._side
    assert np.abs(step).max() <= FARTHEST * (1.0 + 1e-12)
    assert step[0, 0] == pytest.approx(-FARTHEST)


def test_right_corners_stay_and_what_moves_costs():
    local = np.array([[0, -1, -1, -1]])
    square = Opening(SQUARE[None], UP, local, IN_PLANE, 0.02, 0.95)
    assert square._value(np.zeros(2))[0] == 0.0
    np.testing.assert_array_equal(square.step(), np.zeros((1, 3)))
    value, slope = square._value(np.array([0.01, 0.0]))
    assert value == pytest.approx(0.02 * 0.01**2)
    np.testing.assert_allclose(slope, [2.0 * 0.02 * 0.01, 0.0], atol=1e-12)


def test_what_corners_lack_is_summed_with_what_sides_are_too_short():
    """A rhombus whose corners have the sine of 30 degrees, and a strip with two sides a tenth of
    the others."""
    lean = SQUARE @ np.array([[1.0, 0.0, 0.0], [np.sqrt(0.75), 0.5, 0.0], [0.0, 0.0, 1.0]])
    none = np.full((1, 4), -1)
    found = Opening(lean[None], UP, none, IN_PLANE[:0], 0.0, 0.9)._value(np.zeros(0))[0]
    # Sines are a little less, by what softens them.
    assert found == pytest.approx(4.0 * (0.9 - 0.5) ** 2, rel=0.01)
    strip = SQUARE * (1.0, 0.1, 1.0)
    found = Opening(strip[None], UP, none, IN_PLANE[:0], 0.0, 0.0)._value(np.zeros(0))[0]
    short = LEAST_SIDE - np.hypot(0.1, 0.05 * 0.55) / 0.55
    assert found == pytest.approx(2.0 * 4.0 * short**2)


@pytest.mark.parametrize("degrees", [0.0, 10.0, 45.0, 80.0])
def test_a_square_turned_from_its_directions_is_pulled_by_both_middle_lines(degrees):
    """By half the sine of twice the angle, and not at all by its corners, which are right."""
    turn = np.radians(degrees)
    x = np.array([[np.cos(turn), np.sin(turn), 0.0]])
    none = np.full((1, 4), -1)
    problem = Squaring(
        SQUARE[None], x, np.cross(UP, x), np.array([0.7]), none, IN_PLANE[:0], 0.0, 0.5
    )
    found, _ = problem._value(np.zeros(0))
    off = 0.5 * np.sin(2.0 * turn) / (1.0 + SOFT**2)
    pulled = 2.0 * 0.7 * (np.hypot(off, NEARLY) - NEARLY)
    lacking = 4.0 * (1.0 - 1.0 / (1.0 + SOFT**2) + NOTHING)
    assert found == pytest.approx(pulled + lacking)


def test_least_in_a_box():
    """Rosenbrock's valley, whose lowest place lies on the wall of the box."""

    def valley(x):
        a, b = 1.0 - x[0], x[1] - x[0] ** 2
        return a**2 + 5.0 * b**2, np.array([-2.0 * a - 20.0 * x[0] * b, 10.0 * b])

    found = least_in_box(valley, 2, FARTHEST)
    np.testing.assert_allclose(found, [FARTHEST, FARTHEST**2], atol=1e-3)
