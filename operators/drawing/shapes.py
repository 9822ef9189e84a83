"""Triangles that a shader moves into place, and how they are laid out.

Every vertex is a place in the object's space with two directions, U and V, and how far to go
along them: some of it in lengths of the world, some in pixels of the screen. So one extraction
serves every view and zoom, and a moved object needs no new one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

# Pixels over which edges fade out: nothing else smooths them.
SOFT = 0.5


@dataclass(frozen=True)
class Shape:
    """Triangles whose vertices the shader moves into place.

    Attributes
    ----------
    centre, u, v:
        (p, 3) float32 in the object's space.
    reach:
        (p, 4) float32: along U and V in world lengths, then along U and V in pixels.
    colour:
        (p, 4) float32 linear sRGB and opacity.
    triangles:
        (t, 3) int32.
    on_top:
        Seen through the surface.
    """

    centre: np.ndarray
    u: np.ndarray
    v: np.ndarray
    reach: np.ndarray
    colour: np.ndarray
    triangles: np.ndarray
    on_top: bool = False


class Places(NamedTuple):
    """Where a shape is repeated, and two directions on the surface there; (k, 3) each, in the
    object's space."""

    centre: np.ndarray
    u: np.ndarray
    v: np.ndarray

    def at(self, rows: np.ndarray) -> Places:
        """Some of the places, by a mask (k,) or by rows."""
        return Places(*(values[rows] for values in self))


def repeated(
    places: Places,
    corners: np.ndarray,
    colours: np.ndarray,
    triangles: np.ndarray,
    opacities: float | Sequence[float] | np.ndarray = 1.0,
) -> Shape:
    """The same corners (c, 4) and triangles (t, 3) at each of k places.

    `opacities` (c,) multiply that of the colours, one for each place (k, 4) or for all (4,).
    """
    count, size = len(places.centre), len(corners)
    first = (np.arange(count) * size)[:, None, None]
    centre, u, v = (np.repeat(values, size, axis=0).astype(np.float32) for values in places)
    colours = np.broadcast_to(colours, (count, 4))
    each_colour = np.repeat(colours, size, axis=0).astype(np.float32)
    each_colour[:, 3] *= np.tile(np.broadcast_to(opacities, size), count)
    return Shape(
        centre,
        u,
        v,
        np.tile(corners, (count, 1)).astype(np.float32),
        each_colour,
        (triangles[None] + first).reshape(-1, 3).astype(np.int32),
    )


def strips(rows: int, columns: int) -> np.ndarray:
    """(t, 3) triangles between rows of as many corners each."""
    number = np.arange(rows * columns).reshape(rows, columns)
    return _between(number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:])


def bands(rings: int, corners: int) -> np.ndarray:
    """(t, 3) triangles between closed rings of as many corners each."""
    number = np.arange(rings * corners).reshape(rings, corners)
    after = np.roll(number, -1, axis=1)
    return _between(number[:-1], after[:-1], number[1:], after[1:])


def _between(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray) -> np.ndarray:
    first = np.column_stack([values.ravel() for values in (a, b, c)])
    second = np.column_stack([values.ravel() for values in (b, d, c)])
    return np.vstack([first, second])


def fan(corners: int) -> np.ndarray:
    """(t, 3) triangles around corner 0 to those from 1 on."""
    here = np.arange(corners)
    return 1 + np.column_stack([np.full(corners, -1), here, np.roll(here, -1)])
