"""Which umbilics of an object are drawn, and as what."""

from __future__ import annotations

import bpy
import numpy as np

from .... import core
from ...data import record
from ...data.preferences import Appearance
from ...drawing import umbilics
from ...drawing.shapes import Shape
from .. import empties, filters

# With more umbilics than these their glyphs would hide each other and hold up a drag of the
# slider: they are drawn as small diamonds, without rays and discs.
CROWD = 1500
# Opacity of what a filter leaves out.
_FAINT = 0.6


def shapes_of(context: bpy.types.Context, obj: bpy.types.Object, faint: bool) -> list[Shape]:
    """Discs, rays and glyphs of the object's umbilics, in the order they are drawn.

    `faint`: the results are stale, and look it. What is in `crowds` is not among them.
    """
    kept = record.of(obj)
    if kept is None:
        return []
    display, look = context.scene.umbilics_display, Appearance(context)
    opacity = opacity_of(faint)
    shapes = _left_out(obj, context.scene, look, opacity) if display.dropped else []
    rows = filters.shown_rows(obj, context.scene)
    if not len(rows):
        return shapes
    back = np.linalg.inv(kept.matrix)
    if len(rows) <= CROWD:
        chosen = kept.detection.candidates.select(rows)
        places = umbilics.places_of(chosen, back)
        if display.discs:
            shapes.append(umbilics.discs(places, chosen.uncertainty, opacity))
        if display.rays:
            shapes.append(umbilics.rays(chosen, places.centre, back, look, opacity))
        drawn = ~np.isin(rows, shown_by_empties(obj))
        for kind in core.KINDS if display.glyphs else ():
            of_kind = drawn & (chosen.kind == kind)
            if of_kind.any():
                shapes += umbilics.glyphs(kind, places.at(of_kind), look, opacity)
    active = rows[rows == obj.umbilics.active_row]
    if len(active):
        shapes.append(
            umbilics.ring(umbilics.places_of(kept.detection.candidates.select(active), back), look)
        )
    return shapes


def crowds(
    context: bpy.types.Context, obj: bpy.types.Object, faint: bool
) -> list[tuple[np.ndarray, float]]:
    """Rows (k,) of the candidates to be drawn by `diamonds`, since they are too many for glyphs,
    with their opacity; in the order they are drawn."""
    display = context.scene.umbilics_display
    found, opacity = [], opacity_of(faint)
    if display.dropped:
        found.append((filters.left_out_rows(obj, context.scene), _FAINT * opacity))
    if display.glyphs:
        found.append((filters.shown_rows(obj, context.scene), opacity))
    return [
        (np.setdiff1d(rows, shown_by_empties(obj), assume_unique=True), opacity)
        for rows, opacity in found
        if len(rows) > CROWD
    ]


def shown_by_empties(obj: bpy.types.Object) -> np.ndarray:
    """(k,) rows of candidates whose glyph a visible empty shows already."""
    images = [empty for empty in empties.empties_of(obj) if empty.empty_display_type == "IMAGE"]
    rows = [empty.get("umbilics_row", -1) for empty in images if empty.visible_get()]
    return np.array(sorted(rows), dtype=int)


def opacity_of(faint: bool) -> float:
    """How opaque results are drawn; `faint`: they are stale, and look it."""
    return 0.35 if faint else 1.0


def _left_out(
    obj: bpy.types.Object, scene: bpy.types.Scene, look: Appearance, opacity: float
) -> list[Shape]:
    """Hollow, faint glyphs of what the opening leaves out."""
    kept, rows = record.of(obj), filters.left_out_rows(obj, scene)
    if kept is None or len(rows) > CROWD:
        return []
    candidates = kept.detection.candidates.select(rows)
    back = np.linalg.inv(kept.matrix)
    shapes = []
    for kind in core.KINDS:
        of_kind = candidates.kind == kind
        if of_kind.any():
            places = umbilics.places_of(candidates.select(of_kind), back)
            shapes.append(umbilics.hollow_glyphs(kind, places, look, _FAINT * opacity))
    return shapes
