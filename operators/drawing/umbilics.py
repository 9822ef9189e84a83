"""Glyphs, rays and discs of the umbilics, and the diamonds that stand for a crowd of them."""

from __future__ import annotations

from dataclasses import replace

import bpy
import numpy as np

from ... import core
from .. import live, record, results
from ..glyphs import OUTLINES
from ..preferences import Appearance
from .shapes import SOFT, Places, Shape, bands, fan, repeated, strips

# Rays and rims in sizes of a glyph; the ring around the chosen one.
_RAY, _RIM, _RING = 3.4, 1.28, 2.1
_CIRCLE = 32
# With more umbilics than these their glyphs would hide each other and hold up a drag of the
# slider: they are drawn as small diamonds, without rays and discs.
_CROWD = 1500
_DIAMOND = 0.5
# Opacity of what a filter leaves out.
_FAINT = 0.6
_DARK = (0.008, 0.008, 0.01)


def shapes_of(context: bpy.types.Context, obj: bpy.types.Object, faint: bool) -> list[Shape]:
    """Discs, rays and glyphs of the object's umbilics, in the order they are drawn.

    `faint`: the results are stale, and look it. What is in `crowds` is not among them.
    """
    kept = record.of(obj)
    if kept is None:
        return []
    display, look = context.scene.umbilics_display, Appearance(context)
    opacity = _opacity(faint)
    shapes = _left_out(obj, context.scene, look, opacity) if display.dropped else []
    rows = live.shown_rows(obj, context.scene)
    if not len(rows):
        return shapes
    back = np.linalg.inv(kept.matrix)
    if len(rows) <= _CROWD:
        chosen = kept.detection.candidates.select(rows)
        places = _places(chosen, back)
        if display.discs:
            shapes.append(_discs(places, chosen.uncertainty, opacity))
        if display.rays:
            shapes.append(_rays(chosen, places.centre, back, look, opacity))
        drawn = ~np.isin(rows, shown_by_empties(obj))
        for kind in core.KINDS if display.glyphs else ():
            of_kind = drawn & (chosen.kind == kind)
            if of_kind.any():
                shapes += _glyphs(kind, places.at(of_kind), look, opacity)
    active = rows[rows == obj.umbilics.active_row]
    if len(active):
        shapes.append(_ring(_places(kept.detection.candidates.select(active), back), look))
    return shapes


def crowds(
    context: bpy.types.Context, obj: bpy.types.Object, faint: bool
) -> list[tuple[np.ndarray, float]]:
    """Rows (k,) of the candidates to be drawn by `diamonds`, since they are too many for glyphs,
    with their opacity; in the order they are drawn."""
    display = context.scene.umbilics_display
    found, opacity = [], _opacity(faint)
    if display.dropped:
        found.append((live.left_out_rows(obj, context.scene), _FAINT * opacity))
    if display.glyphs:
        found.append((live.shown_rows(obj, context.scene), opacity))
    return [
        (np.setdiff1d(rows, shown_by_empties(obj), assume_unique=True), opacity)
        for rows, opacity in found
        if len(rows) > _CROWD
    ]


def diamonds(kept: record.Record, look: Appearance) -> Shape:
    """A diamond at each candidate, in the colour of its kind.

    They are made once: `diamonds_of` chooses among them, which keeps up with a slider.
    """
    size = _DIAMOND * look.glyph_size
    corners = np.array([(0, 0, size, 0), (0, 0, 0, size), (0, 0, 0, -size), (0, 0, -size, 0)])
    colours = np.array([(*look.colours[kind][:3], 1.0) for kind in core.KINDS], np.float32)
    places = _places(kept.detection.candidates, np.linalg.inv(kept.matrix))
    return repeated(places, corners, colours[kept.kind_codes], strips(2, 2))


def diamonds_of(rows: np.ndarray) -> np.ndarray:
    """(2 k, 3) int32 triangles of `diamonds` that belong to the candidates `rows` (k,)."""
    first = 4 * rows.astype(np.int32)
    return (first[:, None, None] + strips(2, 2).astype(np.int32)).reshape(-1, 3)


def shown_by_empties(obj: bpy.types.Object) -> np.ndarray:
    """(k,) rows of candidates whose glyph a visible empty shows already."""
    empties = [empty for empty in results.empties_of(obj) if empty.empty_display_type == "IMAGE"]
    rows = [empty.get("umbilics_row", -1) for empty in empties if empty.visible_get()]
    return np.array(sorted(rows), dtype=int)


def _opacity(faint: bool) -> float:
    return 0.35 if faint else 1.0


def _places(chosen: core.Umbilics, back: np.ndarray) -> Places:
    """Where umbilics are in the object's space; `back` (4, 4) leads there from the world."""
    frames = results.frames_of(chosen)
    u, v = (frames[:, :3, axis] @ back[:3, :3].T for axis in (0, 1))
    return Places(chosen.position @ back[:3, :3].T + back[:3, 3], u, v)


def _left_out(
    obj: bpy.types.Object, scene: bpy.types.Scene, look: Appearance, opacity: float
) -> list[Shape]:
    """Hollow, faint glyphs of what the opening leaves out."""
    kept, rows = record.of(obj), live.left_out_rows(obj, scene)
    if len(rows) > _CROWD:
        return []
    candidates = kept.detection.candidates.select(rows)
    back = np.linalg.inv(kept.matrix)
    shapes = []
    for kind in core.KINDS:
        of_kind = candidates.kind == kind
        if of_kind.any():
            places = _places(candidates.select(of_kind), back)
            shapes.append(_hollow(kind, places, look, _FAINT * opacity))
    return shapes


def _hollow(kind: str, places: Places, look: Appearance, opacity: float) -> Shape:
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


def _glyphs(kind: str, places: Places, look: Appearance, opacity: float) -> list[Shape]:
    """A dark rim, then the glyph in its colour: it stands out from any background."""
    shapes = []
    outline = OUTLINES[kind]
    reach = np.linalg.norm(outline, axis=1, keepdims=True)
    size = 0.75 * look.glyph_size
    # A middle, the outline, and the outline once more where its edge has faded out.
    opacities = np.repeat((1.0, 1.0, 0.0), (1, *(len(outline),) * 2))
    triangles = np.vstack([fan(len(outline)), 1 + bands(2, len(outline))])
    for grown, colour in (
        (outline * (1.0 + (_RIM - 1.0) / np.maximum(reach, 0.3)), _DARK),
        (outline, look.colours[kind][:3]),
    ):
        faded = grown * (1.0 + 2.0 * SOFT / (size * np.linalg.norm(grown, axis=1)))[:, None]
        corners = np.zeros((2 * len(outline) + 1, 4), np.float32)
        corners[1:, 2:] = size * np.vstack([grown, faded])
        colour = np.array([*colour, opacity])
        shapes.append(repeated(places, corners, colour, triangles, opacities))
    return shapes


def _rays(
    chosen: core.Umbilics, centre: np.ndarray, back: np.ndarray, look: Appearance, opacity: float
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


def _discs(places: Places, radius: np.ndarray, opacity: float) -> Shape:
    """Translucent discs as wide as the standard error of the place."""
    angle = np.linspace(0.0, 2.0 * np.pi, _CIRCLE, endpoint=False)
    corners = np.zeros((_CIRCLE + 1, 4), np.float32)
    corners[1:, :2] = np.column_stack([np.cos(angle), np.sin(angle)])
    shape = repeated(places, corners, np.array([1.0, 1.0, 1.0, 0.35 * opacity]), fan(_CIRCLE))
    shape.reach[:, :2] *= np.repeat(np.nan_to_num(radius), _CIRCLE + 1)[:, None]
    return shape


def _ring(places: Places, look: Appearance) -> Shape:
    """A white ring around the umbilic that is active in the list, wherever it hides."""
    angle = np.linspace(0.0, 2.0 * np.pi, _CIRCLE, endpoint=False)
    around = np.column_stack([np.cos(angle), np.sin(angle)])
    radii = _RING * look.glyph_size + np.array((-1.0 - SOFT, -0.5, 0.5, 1.0 + SOFT))
    corners = np.zeros((4 * _CIRCLE, 4), np.float32)
    corners[:, 2:] = (radii[:, None, None] * around).reshape(-1, 2)
    opacities = np.repeat((0.0, 1.0, 1.0, 0.0), _CIRCLE)
    ring = repeated(places, corners, np.ones(4), bands(4, _CIRCLE), opacities)
    return replace(ring, on_top=True)
