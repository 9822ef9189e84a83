"""A layout as lines in space, to be looked at before any quad is made."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..mapping.walking import barycentric
from .laying_out import LaidOut

TRACK, FEATURE, BORDER = 0, 1, 2
# What a line of a layout is, by number.
LINE_KINDS = ("track", "feature", "border")


@dataclass(frozen=True)
class QuadLayout:
    """The division of a surface into rectangles that quads fill, as l polylines of p points.

    Attributes
    ----------
    position:
        (p, 3) float64 points, in the coordinates of the input.
    start:
        (l + 1,) int64: the points of line i are rows start[i]:start[i + 1].
    kind:
        (l,) int64 number in `LINE_KINDS`.
    pole_position, pole_valence:
        (k, 3) float64 and (k,) int64 the irregular vertices that quads will have.
    rectangles:
        How many there are.
    warnings:
        Sentences about what was mended, dropped or smoothed.
    """

    position: np.ndarray
    start: np.ndarray
    kind: np.ndarray
    pole_position: np.ndarray
    pole_valence: np.ndarray
    rectangles: int
    warnings: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.kind)


def layout_lines(parts: list[LaidOut], warnings: list[str]) -> QuadLayout:
    """The lines of the layouts of all pieces."""
    points, counts, kinds = [np.zeros((0, 3))], [0], []
    poles, valences = [np.zeros((0, 3))], [np.zeros(0, np.int64)]
    for laid in parts:
        surface, crosses = laid.working.surface, laid.map_.crosses
        for track in laid.layout.tracks:
            ends = [track.segments[0].start, *(segment.end for segment in track.segments)]
            where = [track.segments[0], *track.segments]
            triangle = np.array([segment.triangle for segment in where])
            place = np.array([complex(*end) for end in ends])
            weight = barycentric(laid.map_, triangle, place)
            corner = crosses.vertices[crosses.triangles[triangle]]
            at = np.einsum("pk,pkc->pc", weight, corner)
            points.append(at * surface.unit + surface.origin)
            counts.append(len(at))
            kinds.append(BORDER if track.border else FEATURE if track.feature else TRACK)
        vertex = np.flatnonzero(crosses.singular)
        poles.append(crosses.vertices[vertex] * surface.unit + surface.origin)
        valences.append(crosses.quarter_turns[vertex])
    return QuadLayout(
        np.concatenate(points),
        np.cumsum(counts),
        np.array(kinds, np.int64),
        np.concatenate(poles),
        np.concatenate(valences).astype(np.int64),
        sum(len(laid.layout.rectangles) for laid in parts),
        tuple(warnings),
    )
