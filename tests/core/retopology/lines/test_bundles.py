"""Lines that come together go on as one."""

import numpy as np

from core.retopology.lines.bundles import joined_bundles


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
