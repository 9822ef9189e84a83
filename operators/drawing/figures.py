"""Numbers as thick lines, to be drawn among glyphs: nothing else of a screen writes in depth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .shapes import SOFT, Places, Shape, repeated, strips

# Width of a digit and way from one to the next, in its height; half the width of its line.
_WIDTH, _ADVANCE, _HALF = 0.56, 0.76, 0.075
# How much wider the dark line under it is, in pixels.
_RIM = 1.5
_DARK = (0.008, 0.008, 0.01)


def _arc(
    centre: tuple[float, float], radii: tuple[float, float], begin: float, end: float
) -> np.ndarray:
    """(9, 2) points of an arc of an ellipse between two angles in degrees."""
    angle = np.radians(np.linspace(begin, end, 9))
    return np.array(centre) + np.array(radii) * np.column_stack([np.cos(angle), np.sin(angle)])


# The lines of each digit about the middle of a box one high; the upper and the lower bowl.
_X = 0.5 * _WIDTH
_UP, _LOW, _BOWL = (0.0, 0.26), (0.0, -0.22), (_X, 0.28)
_LINES = {
    "0": [_arc((0.0, 0.0), (_X, 0.5), 90.0, 270.0), _arc((0.0, 0.0), (_X, 0.5), 270.0, 450.0)],
    "1": [np.array([(-0.18, 0.3), (0.04, 0.5), (0.04, -0.5)])],
    "2": [
        _arc((0.0, 0.22), _BOWL, 165.0, -35.0),
        np.array([(0.23, 0.06), (-_X, -0.5), (_X, -0.5)]),
    ],
    "3": [_arc(_UP, (0.24, 0.24), 150.0, -90.0), _arc(_LOW, _BOWL, 90.0, -150.0)],
    "4": [np.array([(0.12, -0.5), (0.12, 0.5), (-_X, -0.2), (_X, -0.2)])],
    "5": [
        np.array([(0.24, 0.5), (-0.2, 0.5), (-0.23, 0.02)]),
        _arc((0.0, -0.2), (_X, 0.3), 140.0, -145.0),
    ],
    "6": [
        _arc((0.0, -0.2), (_X, 0.3), 90.0, 450.0),
        np.array([(-_X, -0.18), (-0.2, 0.2), (0.14, 0.5)]),
    ],
    "7": [np.array([(-_X, 0.5), (_X, 0.5), (-0.08, -0.5)])],
    "8": [_arc(_UP, (0.23, 0.24), 90.0, 450.0), _arc((0.0, -0.24), (_X, 0.26), 90.0, 450.0)],
    "9": [
        _arc((0.0, 0.2), (_X, 0.3), 90.0, 450.0),
        np.array([(_X, 0.18), (0.2, -0.2), (-0.14, -0.5)]),
    ],
}


@dataclass(frozen=True)
class Writing:
    """How numbers are written: their height in pixels, the colour, and where the middle of the
    first digit stands from the place, in pixels."""

    height: float
    colour: tuple[float, ...]
    offset: tuple[float, float] = (0.0, 0.0)
    rim: bool = True


def written(places: Places, numbers: Sequence[int], how: Writing) -> list[Shape]:
    """Each number at its place, along U and upright along V: dark rims, then the digits."""
    found: dict[tuple[int, str], list[int]] = {}
    for row, number in enumerate(numbers):
        for place, digit in enumerate(str(number)):
            found.setdefault((place, digit), []).append(row)
    shapes = []
    for wider, colour in (((_RIM, _DARK),) if how.rim else ()) + ((0.0, how.colour[:3]),):
        for (place, digit), rows in found.items():
            corners, triangles, opacities = _digit(digit, how.height, wider)
            corners[:, 2] += how.offset[0] + place * _ADVANCE * how.height
            corners[:, 3] += how.offset[1]
            tint = np.array([*colour, how.colour[3]])
            shapes.append(repeated(places.at(np.array(rows)), corners, tint, triangles, opacities))
    return shapes


def _digit(digit: str, height: float, wider: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Corners (c, 4) in pixels, triangles (t, 3) and opacities (c,) of one digit."""
    half = _HALF * height + wider
    edges = (-half - SOFT, -half + SOFT, half - SOFT, half + SOFT)
    pieces = []
    for line in _LINES[digit]:
        points = line * height
        along = np.diff(points, axis=0)
        along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-9)
        across = np.column_stack([-along[:, 1], along[:, 0]])
        # Each piece goes on by half its width: so the bends are closed.
        ends = points[:-1] - 0.7 * half * along, points[1:] + 0.7 * half * along
        pieces.append(np.stack([end + far * across for far in edges for end in ends], axis=1))
    flat = np.concatenate(pieces)
    corners = np.zeros((8 * len(flat), 4), np.float32)
    corners[:, 2:] = flat.reshape(-1, 2)
    first = 8 * np.arange(len(flat))[:, None, None]
    triangles = (first + strips(4, 2)).reshape(-1, 3)
    return corners, triangles, np.tile(np.repeat((0.0, 1.0, 1.0, 0.0), 2), len(flat))
