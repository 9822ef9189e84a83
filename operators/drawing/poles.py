"""Poles as glyphs that face the viewer: a triangle with a 3, a pentagon with a 5."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .figures import Writing, written
from .shapes import SOFT, Places, Shape, bands, fan, repeated

# Told apart by shape, number and lightness as well as by hue.
COLOURS = {3: (1.0, 0.62, 0.0, 1.0), 5: (0.05, 0.25, 0.85, 1.0)}
_INK = {3: (0.02, 0.01, 0.0), 5: (1.0, 1.0, 1.0)}
_DARK = (0.008, 0.008, 0.01)
# Radius of the glyph and height of its number, in sizes of an umbilic's glyph; the dark rim.
_RADIUS, _NUMBER, _RIM = {3: 1.05, 5: 0.85}, 0.8, 1.28


def reach(size: float) -> float:
    """How far from its place a pole's glyph goes, in pixels, where glyphs are of this size."""
    return _RIM * max(_RADIUS.values()) * size


def usual_gap(places: np.ndarray) -> float:
    """The median distance from one of the places (k, 3) to the nearest other one."""
    if len(places) < 2:
        return float("inf")
    nearest = [
        np.partition(np.linalg.norm(places - place, axis=1), 1)[1] for place in places
    ]
    return float(np.median(nearest))


def pole_glyphs(valence: int, places: Places, size: float, opacity: float) -> list[Shape]:
    """Glyphs of the poles of one valence at places whose U is the viewer's right and V is up."""
    look = Badge(valence, _RADIUS[valence], COLOURS[valence][:3], _INK[valence])
    return badges(look, [valence] * len(places.centre), places, size, opacity)


@dataclass(frozen=True)
class Badge:
    """A polygon of one colour, a corner up, with a number on it."""

    sides: int
    radius: float  # in sizes of an umbilic's glyph
    colour: tuple[float, float, float]
    ink: tuple[float, float, float]


def badges(
    look: Badge, numbers: list[int], places: Places, size: float, opacity: float
) -> list[Shape]:
    """Numbers, each on a polygon with a dark rim, at places as above."""
    shapes, sides = [], look.sides
    corner = np.pi / 2.0 + 2.0 * np.pi * np.arange(sides) / sides
    outline = np.column_stack([np.cos(corner), np.sin(corner)])
    triangles = np.vstack([fan(sides), 1 + bands(2, sides)])
    opacities = np.repeat((1.0, 1.0, 0.0), (1, sides, sides))
    for grown, colour in ((_RIM, _DARK), (1.0, look.colour)):
        radius = grown * look.radius * size
        corners = np.zeros((2 * sides + 1, 4), np.float32)
        corners[1:, 2:] = np.vstack([radius * outline, (radius + 2.0 * SOFT) * outline])
        tint = np.array([*colour, opacity])
        shapes.append(repeated(places, corners, tint, triangles, opacities))
    how = Writing(_NUMBER * size, (*look.ink, opacity), rim=False)
    return shapes + written(places, numbers, how)
