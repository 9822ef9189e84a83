"""Lines on a surface as they are handed on: polylines whose points name their triangles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from ...base.subsets import spans
from ...fields.planes import FaceFrames, barycentric_of, second_and_third
from ...mesh.input_map import places_in_input
from ...mesh.surface import Surface
from .tracing import Traces

FAMILIES = ("first", "second")
# Between two points that are handed on the surface bends by no more than this (30 degrees): their
# chord lies within an eighth of its length of the line on the surface.
MOST_BEND = np.pi / 6.0


@dataclass(frozen=True)
class Lines:
    """l polylines with p points in all, in the rows and coordinates of the input mesh.

    Attributes
    ----------
    start:
        (l + 1,) int64: the points of line i are rows start[i]:start[i + 1].
    position, normal:
        (p, 3) float64 points on the mesh and unit normals of their triangles.
    triangle:
        (p,) int64 input triangle of each point; the chord that ends at a point lies in it,
        unless points in between were left out.
    barycentric:
        (p, 3) float64 weights of that triangle's corners.
    family:
        (l,) int8: 0 for lines of the larger principal curvature, 1 for the smaller.
    length:
        (l,) float64 in length.
    closed:
        (l,) bool, True where a line comes back to its first point.
    source, target:
        (l,) int64 umbilics that a separatrix or ridge starts from and ends at, -1 for none.
    """

    start: np.ndarray
    position: np.ndarray
    normal: np.ndarray
    triangle: np.ndarray
    barycentric: np.ndarray
    family: np.ndarray
    length: np.ndarray
    closed: np.ndarray
    source: np.ndarray
    target: np.ndarray

    OF_POINTS: ClassVar[tuple[str, ...]] = ("position", "normal", "triangle", "barycentric")
    OF_LINES: ClassVar[tuple[str, ...]] = ("family", "length", "closed", "source", "target")

    def __len__(self) -> int:
        return len(self.family)

    def points(self, line: int) -> np.ndarray:
        """(q, 3) points of one line."""
        return self.position[self.start[line] : self.start[line + 1]]

    def select(self, rows: np.ndarray) -> Self:
        """The given lines, by a mask or indices."""
        rows = np.arange(len(self))[rows]
        count = np.diff(self.start)[rows]
        points = spans(self.start[:-1][rows], count)
        parts = {name: getattr(self, name)[points] for name in self.OF_POINTS}
        parts |= {name: getattr(self, name)[rows] for name in self.OF_LINES}
        return type(self)(start=np.concatenate([[0], np.cumsum(count)]), **parts)


def points_of(
    surface: Surface, planes: FaceFrames, triangle: np.ndarray, z: np.ndarray
) -> np.ndarray:
    """(r, 3) points in the coordinates of the surface."""
    second, third = second_and_third(planes, triangle, z)
    a, b, c = (surface.vertices.take(surface.triangles[triangle, k], axis=0) for k in range(3))
    return a + second[:, None] * (b - a) + third[:, None] * (c - a)


def sparse_rows(
    traces: Traces, spacing: float, surface: Surface | None = None
) -> np.ndarray:
    """Rows of a trace's points that lie about `spacing` apart, of a `surface` also those between
    which it bends by more than `MOST_BEND` and those beside an edge that does so alone: a chord on
    either side of a fold lies in its triangle. The ends are kept."""
    if not len(traces.triangle):
        return np.zeros(0, np.int64)
    line = np.repeat(np.arange(len(traces.end)), np.diff(traces.start))
    cell = np.floor(traces.travelled / max(spacing, np.finfo(float).tiny))
    new = np.ones(len(line), bool)
    new[1:] = (line[1:] != line[:-1]) | (cell[1:] != cell[:-1])
    if surface is not None:
        normal = surface.face_normal_area[0][traces.triangle]
        cosine = np.einsum("qc,qc->q", normal[1:], normal[:-1])
        bend = np.arccos(cosine.clip(-1.0, 1.0))
        # Each chord lies in the triangle of its second point: it bends at the point before.
        new[:-1] |= np.diff(np.floor(np.cumsum(bend) / MOST_BEND), prepend=0.0) > 0.0
        fold = np.flatnonzero(bend > MOST_BEND)
        new[np.maximum(fold - 1, 0)] = new[fold + 1] = True
    new[traces.start[1:] - 1] = True
    return np.flatnonzero(new)


def lines_from(
    surface: Surface,
    planes: FaceFrames,
    line: np.ndarray,
    triangle: np.ndarray,
    z: np.ndarray,
    family: np.ndarray,
    closed: np.ndarray,
) -> Lines:
    """Lines in input coordinates from points in the planes, ordered by `line` (p,)."""
    count = len(family)
    start = np.concatenate([[0], np.cumsum(np.bincount(line, minlength=count))]).astype(np.int64)
    weights = barycentric_of(planes, triangle, z)
    points = np.einsum("rk,rkc->rc", weights, surface.vertices[surface.triangles[triangle]])
    points = points * surface.unit + surface.origin
    chord = np.zeros(len(points))
    chord[1:] = np.linalg.norm(np.diff(points, axis=0), axis=1)
    chord[start[:-1][np.diff(start) > 0]] = 0.0
    input_triangle, input_weights = places_in_input(surface, triangle, weights)
    length = np.bincount(line, weights=chord, minlength=count)
    for number in np.flatnonzero(closed):
        length[number] += np.linalg.norm(points[start[number]] - points[start[number + 1] - 1])
    return Lines(
        start=start,
        position=points,
        normal=surface.face_normal_area[0][triangle],
        triangle=input_triangle,
        barycentric=input_weights,
        family=family.astype(np.int8),
        length=length,
        closed=closed.astype(bool),
        source=np.full(count, -1),
        target=np.full(count, -1),
    )
