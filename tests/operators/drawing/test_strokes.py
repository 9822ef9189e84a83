"""Strokes lie along the directions, as long and as wide as they should, and fade where a direction
means little."""

import numpy as np


def arranged(addon, gap):
    """Strokes at places in a row, along x and y."""
    count = len(gap)
    places = np.column_stack([np.arange(count), np.zeros((count, 2))])
    along, across = np.tile(np.eye(3)[:2, None], (1, count, 1))
    return addon.operators.drawing.strokes.arranged(places, along, across, np.array(gap, float))


def test_a_direction_counts_by_its_gap_beside_the_median(addon):
    shares = np.array([0.0, 0.06, 0.18, 0.3, 1.0, 1.0, 1.0, 2.0, 5.0])
    found = arranged(addon, shares)
    weight = found.weight[np.argsort(found.places[:, 0])]
    # Nothing at a fifth of three tenths of the median, half of it half way, all at three tenths.
    assert np.allclose(weight, [0.0, 0.0, 0.5, *[1.0] * 6], atol=1e-6)


def test_a_stroke_has_its_length_width_and_soft_sides(addon):
    found = arranged(addon, [1.0] * 4)
    colour = (0.1, 0.2, 0.3, 0.7)
    for second, wanted in ((False, (0, 1)), (True, (1, 0))):
        shape = addon.operators.drawing.strokes.shape_of(found, 0, second, 2.0, colour)
        assert np.allclose(shape.u, np.eye(3)[wanted[0]])
        assert np.allclose(shape.v, np.eye(3)[wanted[1]])
        assert np.allclose(np.unique(shape.reach[:, 0]), [-0.42, 0.42])
        # In pixels: half of the width, and half a pixel more over which it fades.
        assert np.allclose(np.unique(shape.reach[:, 3]), [-1.5, 0.0, 1.5])
        middle = shape.reach[:, 3] == 0.0
        assert np.allclose(shape.colour[middle], colour)
        assert not shape.colour[~middle, 3].any()
        assert not shape.reach[:, 1:3].any()
