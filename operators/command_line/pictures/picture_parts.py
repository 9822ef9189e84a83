"""What a picture is made of: strokes of direction, glyphs of umbilics, a legend."""

from __future__ import annotations

import bpy
import numpy as np

from .... import core
from ...base.words import outcome
from ...data.preferences import KIND_COLOURS
from ...drawing.frames import frames_of
from ...drawing.glyphs import OUTLINES, prisms
from ...jobs.detect import Inputs
from ...mesh.build import from_triangles
from ...mesh.fetch import unit_vectors
from ...mesh.read import MeshArrays
from .stage import Stage, View

# A glyph's size as a fraction of the mesh's, and how many fit before they are drawn smaller.
_GLYPH, _COMFORTABLE = 0.016, 40
# Strokes across the mesh, and below which part of the typical gap a direction means little.
_STROKES, _FAINT = 70, 0.25
# Height of a line of text as a fraction of the picture's width, and how wide a letter is of that.
_LETTER, _PACE = 0.026, 0.53


def glyph_size(points: np.ndarray, count: int) -> float:
    """Size of the glyphs of `count` umbilics on (n, 3) points."""
    diagonal = float(np.linalg.norm(np.ptp(points, axis=0)))
    return _GLYPH * diagonal * min(1.0, max(0.35, (_COMFORTABLE / max(count, 1)) ** 0.5))


def glyph_mesh(kind: str, umbilics: core.Umbilics, size: float) -> bpy.types.Mesh:
    """A glyph at each umbilic, all of one kind."""
    return from_triangles(*prisms(OUTLINES[kind], frames_of(umbilics), size))


def stroke_mesh(arrays: MeshArrays, field: core.CurvatureField) -> bpy.types.Mesh:
    """Thin ribbons along the first principal direction, evenly spread over the surface.

    They shrink where the principal curvatures are nearly equal, where a direction means
    little.
    """
    known = np.flatnonzero(
        np.isfinite(field.d1).all(axis=1) & np.isfinite(field.normal).all(axis=1)
    )
    if not len(known):
        return from_triangles(np.empty((0, 3)), np.empty((0, 3), dtype=np.int32))
    points = arrays.vertices[known]
    step = float(np.linalg.norm(np.ptp(points, axis=0))) / _STROKES
    cell = np.floor(points / max(step, 1e-30)).astype(np.int64)
    _, first = np.unique(cell, axis=0, return_index=True)
    rows = known[first]
    gap = np.nan_to_num(field.gap)
    weight = np.clip(gap[rows] / max(_FAINT * float(np.median(gap[known])), 1e-300), 0.15, 1.0)
    normal, along = field.normal[rows], field.d1[rows]
    across = unit_vectors(np.cross(normal, along)) * (0.035 * step)
    along = along * (0.42 * step * weight)[:, None]
    middle = arrays.vertices[rows] + 0.06 * step * normal
    corners = np.stack(
        [
            middle - along - across,
            middle + along - across,
            middle + along + across,
            middle - along + across,
        ],
        axis=1,
    )
    quads = 4 * np.arange(len(rows))[:, None, None] + np.array([[0, 1, 2], [0, 2, 3]])
    return from_triangles(corners.reshape(-1, 3), quads.reshape(-1, 3))


def legend(
    stage: Stage,
    view: View,
    found: list[tuple[Inputs, core.Detection]],
    colour: tuple[float, ...],
) -> list[bpy.types.Object]:
    """A title above and the meaning of the glyphs below; the objects that were added."""
    lines = [f"{inputs.object_name}: {outcome(detection)}" for inputs, detection in found[:3]]
    counts = {
        kind: sum(detection.umbilics.counts()[kind] for _, detection in found)
        for kind in core.KINDS
    }
    return caption(stage, view, lines, colour) + kinds_below(stage, view, counts, colour)


def caption(
    stage: Stage, view: View, lines: list[str], colour: tuple[float, ...]
) -> list[bpy.types.Object]:
    """Lines of text at the top of the picture, made small enough to fit."""
    letter = _LETTER * view.width
    added, below = [], 0.5 * view.height - 0.4 * letter
    for line in lines:
        size = min(letter, 0.96 * view.width / max(_PACE * len(line), 1.0))
        below -= 1.35 * size
        added.append(_text(stage, view, line, (-0.48 * view.width, below), size, colour))
    return added


def kinds_below(
    stage: Stage, view: View, counts: dict[str, int], colour: tuple[float, ...]
) -> list[bpy.types.Object]:
    """The glyph, name and count of each kind that occurs, in a row at the bottom."""
    letter = _LETTER * view.width
    added = []
    x, y = -0.48 * view.width + 0.5 * letter, -0.5 * view.height + letter
    for kind in core.KINDS:
        if not counts[kind]:
            continue
        place = np.array(view.matrix(x, y + 0.32 * letter, _in_front(view)))[None]
        marks = from_triangles(*prisms(OUTLINES[kind], place, 0.5 * letter))
        added.append(stage.add(marks, KIND_COLOURS[kind]))
        label = f"{kind} ({counts[kind]})"
        added.append(_text(stage, view, label, (x + 0.9 * letter, y), letter, colour))
        x += (2.4 + _PACE * len(label)) * letter
    return added


def _text(
    stage: Stage,
    view: View,
    text: str,
    place: tuple[float, float],
    size: float,
    colour: tuple[float, ...],
) -> bpy.types.Object:
    curve = bpy.data.curves.new("umbilics picture", "FONT")
    curve.body = text
    curve.size = size
    obj = stage.add(curve, colour)
    obj.matrix_world = view.matrix(*place, _in_front(view))
    return obj


def _in_front(view: View) -> float:
    return view.depth + view.width
