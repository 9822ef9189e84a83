"""The colours of the map and their values, in the lower left corner of the view."""

from __future__ import annotations

from collections.abc import Sequence

import blf
import bpy
import gpu
import numpy as np
from gpu_extras.batch import batch_for_shader

from ...operators.scene import selection
from ...operators.scene.view import maps

_FONT = 0
_WIDTH, _HEIGHT, _MARGIN, _LINE = 14.0, 180.0, 24.0, 1.55
_PANEL = (0.07, 0.07, 0.08, 0.72)
_INK = (0.95, 0.95, 0.95, 1.0)
_TICKS = 5


def draw(context: bpy.types.Context) -> None:
    """Draw the legend of the active object's map, else of any map that is seen: they share it."""
    if context.space_data.shading.color_type != "VERTEX":
        return
    candidates = [selection.shown(context), *context.visible_objects]
    found = next(filter(None, (maps.legend(context.scene, obj) for obj in candidates)), None)
    if found is None:
        return
    scale = context.preferences.system.ui_scale
    points = context.scene.umbilics_display.text_size * scale
    blf.size(_FONT, points)
    blf.color(_FONT, *_INK)
    left, bottom = _corner(context, scale)
    rows = len(found.names)
    height = _LINE * points * rows if rows else _HEIGHT * scale
    labels = found.names or tuple(f"{value:.3g}" for value in _ticks(found))
    text_width = max(blf.dimensions(_FONT, text)[0] for text in (*labels, found.title))
    padding = 0.8 * points
    gpu.state.blend_set("ALPHA")
    _rectangle(
        left - padding,
        bottom - padding,
        max(_WIDTH * scale + text_width + 1.4 * points, text_width) + 2 * padding,
        height + _LINE * points + 2.2 * padding,
        _PANEL,
    )
    width = _WIDTH * scale
    if rows:
        step = height / rows
        for row, colour in enumerate(found.colours[:rows]):
            at = bottom + height - (row + 1) * step
            _rectangle(left, at + 0.15 * step, width, 0.7 * step, (*colour, 1.0))
            _text(found.names[row], left + width + 0.6 * points, at + 0.3 * step)
    else:
        _gradient(left, bottom, width, height, found.colours)
        for place, value in zip(np.linspace(0.0, 1.0, _TICKS), _ticks(found), strict=True):
            at = bottom + place * height
            _rectangle(left + width, at - 0.5, 0.35 * points, 1.0, _INK)
            _text(f"{value:.3g}", left + width + 0.6 * points, at - 0.35 * points)
    _text(found.title, left, bottom + height + 0.9 * points)
    gpu.state.blend_set("NONE")


def _ticks(found: maps.Legend) -> np.ndarray:
    values = np.linspace(found.low, found.high, _TICKS)
    # The middle of a signed range is zero to the eye as well.
    return np.where(np.abs(values) < 1e-6 * max(abs(found.low), abs(found.high)), 0.0, values)


def _corner(context: bpy.types.Context, scale: float) -> tuple[float, float]:
    """Left and bottom of the legend, clear of a toolbar that overlaps the view."""
    left = 0.0
    for region in context.area.regions:
        if region.type == "TOOLS" and region.alignment == "LEFT" and region.width > 1:
            left = max(left, region.width)
    return left + (_MARGIN + 8.0) * scale, (_MARGIN + 8.0) * scale


def _text(text: str, x: float, y: float) -> None:
    blf.position(_FONT, x, y, 0.0)
    blf.draw(_FONT, text)


def _rectangle(x: float, y: float, width: float, height: float, colour: Sequence[float]) -> None:
    program = gpu.shader.from_builtin("UNIFORM_COLOR")
    corners = [(x, y), (x + width, y), (x + width, y + height), (x, y + height)]
    batch = batch_for_shader(program, "TRIS", {"pos": corners}, indices=[(0, 1, 2), (0, 2, 3)])
    program.bind()
    program.uniform_float("color", colour)
    batch.draw(program)


def _gradient(x: float, y: float, width: float, height: float, colours: np.ndarray) -> None:
    program = gpu.shader.from_builtin("SMOOTH_COLOR")
    count = len(colours)
    heights = y + height * np.linspace(0.0, 1.0, count)
    places = np.empty((2 * count, 2), np.float32)
    places[0::2, 0], places[1::2, 0] = x, x + width
    places[:, 1] = np.repeat(heights, 2)
    tints = np.ones((2 * count, 4), np.float32)
    tints[:, :3] = np.repeat(colours, 2, axis=0)
    batch = batch_for_shader(program, "TRI_STRIP", {"pos": places, "color": tints})
    program.bind()
    batch.draw(program)
