"""Glyphs, rays and discs of umbilics, and the diamonds that stand for a crowd of them."""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol

import numpy as np

from ... import core
from .frames import frames_of
from .glyphs import OUTLINES
from .shapes import SOFT, Places, Shape, bands, fan, repeated, strips

# Rays and rims in sizes of a glyph; the ring around the chosen one.
_RAY, _RIM, _RING = 3.4, 1.28, 2.1
_CIRCLE = 32
_DIAMOND = 0.5
_DARK = (0.008, 0.008, 0.01)


class Look(Protocol):
    """What the user chose for how umbilics look; sizes in pixels."""

    glyph_size: float
    stroke_width: float
    colours: dict[str, tuple[float, ...]]


def diamonds(
    candidates: core.Umbilics, kind_codes: np.ndarray, back: np.ndarray, look: Look
) -> Shape:
    """A diamond at each candidate, in the colour of its kind.

    They are made once: `diamonds_of` chooses among them, which keeps up with a slider.
    """
    size = _DIAMOND * look.glyph_size
    corners = np.array([(0, 0, size, 0), (0, 0, 0, size), (0, 0, 0, -size), (0, 0, -size, 0)])
    colours = np.array([(*look.colours[kind][:3], 1.0) for kind in core.KINDS], np.float32)
    places = places_of(candidates, back)
    return repeated(places, corners, colours[kind_codes], strips(2, 2))


def diamonds_of(rows: np.ndarray) -> np.ndarray:
    """(2 k, 3) int32 triangles of `diamonds` that belong to the candidates `rows` (k,)."""
    first = 4 * rows.astype(np.int32)
    return (first[:, None, None] + strips(2, 2).astype(np.int32)).reshape(-1, 3)


def places_of(chosen: core.Umbilics, back: np.ndarray) -> Places:
    """Where umbilics are in the object's space; `back` (4, 4) leads there from the world."""
    frames = frames_of(chosen)
    u, v = (frames[:, :3, axis] @ back[:3, :3].T for axis in (0, 1))
    return Places(chosen.position @ back[:3, :3].T + back[:3, 3], u, v)


def hollow_glyphs(kind: str, places: Places, look: Look, opacity: float) -> Shape:
    """Only the line around a glyph."""
    outline = OUTLINES[kind]
    count = len(outline)
    size = 0.75 * look.glyph_size
    # As wide as a stroke, however large glyphs are.
    half = (0.5 * look.stroke_width + SOFT) / (0.62 * size)
    corners = np.zeros((3 * count, 4), np.float32)
    corners[:, 2:] = size * np.vstack([outline * grown for grown in (1.0 - half, 1.0, 1.0 + half)])
    opacities = np.repeat((0.0, 1.0, 0.0), count)
    colour = np.array([*look.colours[kind][:3], opacity])
    return repeated(places, corners, colour, bands(3, count), opacities)


def glyphs(kind: str, places: Places, look: Look, opacity: float) -> list[Shape]:
    """A dark rim, then the glyph in its colour: it stands out from any background."""
    shapes = []
    outline = OUTLINES[kind]
    reach = np.linalg.norm(outline, axis=1, keepdims=True)
    size = 0.75 * look.glyph_size
    # A middle, the outline, and the outline once more where its edge has faded out.
    opacities = np.repeat((1.0, 1.0, 0.0), (1, *(len(outline),) * 2))
    triangles = np.vstack([fan(len(outline)), 1 + bands(2, len(outline))])
    for grown, shade in (
        (outline * (1.0 + (_RIM - 1.0) / np.maximum(reach, 0.3)), _DARK),
        (outline, look.colours[kind][:3]),
    ):
        faded = grown * (1.0 + 2.0 * SOFT / (size * np.linalg.norm(grown, axis=1)))[:, None]
        corners = np.zeros((2 * len(outline) + 1, 4), np.float32)
        corners[1:, 2:] = size * np.vstack([grown, faded])
        colour = np.array([*shade, opacity])
        shapes.append(repeated(places, corners, colour, triangles, opacities))
    return shapes


def rays(
    chosen: core.Umbilics, centre: np.ndarray, back: np.ndarray, look: Look, opacity: float
) -> Shape:
    """From the umbilic outwards, thinning out."""
    known = np.isfinite(chosen.separatrix).all(axis=2)
    which, ray = np.nonzero(known)
    # The line runs into the point along the separatrix: it is seen on the side it comes from.
    along = chosen.separatrix[which, ray]
    across = np.cross(chosen.normal[which], along)
    u, v = along @ back[:3, :3].T, across @ back[:3, :3].T
    length, half = _RAY * look.glyph_size, 0.75 * look.stroke_width + SOFT
    corners = np.array([(0, 0, x, y) for y in (-half, 0, half) for x in (0, length)])
    corners[[1, 5], 3] = -SOFT, SOFT
    colours = np.zeros((len(which), 4), np.float32)
    for kind in core.KINDS:
        of_kind = chosen.kind[which] == kind
        colours[of_kind] = (*look.colours[kind][:3], opacity)
    places = Places(centre[which], u, v)
    return repeated(places, corners, colours, strips(3, 2), (0.0, 0.0, 1.0, 0.4, 0.0, 0.0))


def discs(places: Places, radius: np.ndarray, opacity: float) -> Shape:
    """Translucent discs as wide as the standard error of the place."""
    angle = np.linspace(0.0, 2.0 * np.pi, _CIRCLE, endpoint=False)
    corners = np.zeros((_CIRCLE + 1, 4), np.float32)
    corners[1:, :2] = np.column_stack([np.cos(angle), np.sin(angle)])
    shape = repeated(places, corners, np.array([1.0, 1.0, 1.0, 0.35 * opacity]), fan(_CIRCLE))
    shape.reach[:, :2] *= np.repeat(np.nan_to_num(radius), _CIRCLE + 1)[:, None]
    return shape


def ring(places: Places, look: Look) -> Shape:
    """A white ring around the umbilic that is active in the list, wherever it hides."""
    angle = np.linspace(0.0, 2.0 * np.pi, _CIRCLE, endpoint=False)
    around = np.column_stack([np.cos(angle), np.sin(angle)])
    radii = _RING * look.glyph_size + np.array((-1.0 - SOFT, -0.5, 0.5, 1.0 + SOFT))
    corners = np.zeros((4 * _CIRCLE, 4), np.float32)
    corners[:, 2:] = (radii[:, None, None] * around).reshape(-1, 2)
    opacities = np.repeat((0.0, 1.0, 1.0, 0.0), _CIRCLE)
    around_it = repeated(places, corners, np.ones(4), bands(4, _CIRCLE), opacities)
    return replace(around_it, on_top=True)
