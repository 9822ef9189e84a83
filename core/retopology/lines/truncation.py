"""Separatrices without end: cut where they begin to wind, or at the last feature before that.

A line of curvature that comes to no umbilic tends to a closed one (Gutierrez & Sotomayor 1982) and
winds beside itself for ever. It adds nothing to a layout from there; one that crosses a crease or
a crest before ends on it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from ...base.subsets import spans
from ...fields.frames import side_axes
from ...fields.planes import FaceFrames, barycentric_of
from ...fields.transport import as_complex
from ...mesh.surface import Surface
from .polylines import points_of, sparse_rows
from .tracing import FEATURE, LIMIT, MET, Traces

# A point of a line lies on the side of a triangle across from a corner that weighs so little.
ON_SIDE = 1e-5


@dataclass(frozen=True)
class Barriers:
    """Features that a line may end on.

    Attributes
    ----------
    half_edge:
        (e,) int64 one half-edge of each edge of a feature.
    triangle:
        (c,) int64 triangles that pieces of crests lie in.
    tail, head:
        (c, 3) float64 their ends, in the coordinates of the surface.
    """

    half_edge: np.ndarray
    triangle: np.ndarray
    tail: np.ndarray
    head: np.ndarray


def truncated(surface: Surface, planes: FaceFrames, traces: Traces, apart: float) -> Traces:
    """Those lines that come to their limit only as far as they do not come nearer to themselves
    than `apart`; the others as they are."""
    count = len(traces.end)
    rows = sparse_rows(traces, 0.5 * apart)
    line = np.repeat(np.arange(count), np.diff(traces.start))
    points = points_of(surface, planes, traces.triangle[rows], traces.z[rows])
    normal = surface.face_normal_area[0][traces.triangle[rows]]
    arc = traces.travelled[rows]
    first = np.searchsorted(line[rows], np.arange(count + 1))
    cut = np.full(count, np.inf)
    for number in np.flatnonzero(traces.end == LIMIT):
        own = slice(first[number], first[number + 1])
        pairs = cKDTree(points[own]).query_pairs(apart, output_type="ndarray") + first[number]
        one, two = pairs.T
        # Neither neighbours along the line nor the two sides of a thin sheet.
        beside = np.abs(arc[one] - arc[two]) > 4.0 * apart
        beside &= np.einsum("pc,pc->p", normal[one], normal[two]) > 0.0
        cut[number] = np.maximum(arc[one], arc[two])[beside].min(initial=np.inf)
    keep = traces.travelled <= cut[line]
    wound = np.isfinite(cut)
    return replace(
        _kept(traces, keep),
        end=np.where(wound, MET, traces.end).astype(np.int8),
        obstacle=np.where(wound, -1, traces.obstacle),
    )


def ended_on_features(
    surface: Surface, planes: FaceFrames, traces: Traces, barriers: Barriers
) -> Traces:
    """Lines that were cut where they wind, each only to the last feature that it crosses before.

    The piece from its first point on is kept also where that is all; a line that crosses none
    stays as it is.
    """
    line = np.repeat(np.arange(len(traces.end)), np.diff(traces.start))
    row, share = _crossings(surface, planes, traces, barriers, traces.end == MET)
    last = np.full(len(traces.end), -1)
    np.maximum.at(last, line[row], np.arange(len(row)))
    ended = np.flatnonzero(last >= 0)
    at, along = row[last[ended]], share[last[ended]]
    # The chord lies in the triangle of its second point; the first one is carried there.
    here = _carried(surface, planes, traces, at)
    z, travelled = traces.z.copy(), traces.travelled.copy()
    z[at] = here + along * (traces.z[at] - here)
    before = traces.travelled[at - 1]
    travelled[at] = before + along * (traces.travelled[at] - before)
    stop = np.full(len(traces.end), len(line))
    stop[ended] = at
    end = traces.end.copy()
    end[ended] = FEATURE
    kept = _kept(replace(traces, z=z, travelled=travelled), np.arange(len(line)) <= stop[line])
    return replace(kept, end=end)


def _kept(traces: Traces, keep: np.ndarray) -> Traces:
    """Traces with the points `keep` (p,) alone."""
    count = len(traces.end)
    line = np.repeat(np.arange(count), np.diff(traces.start))
    return replace(
        traces,
        start=np.concatenate([[0], np.cumsum(np.bincount(line[keep], minlength=count))]),
        triangle=traces.triangle[keep],
        z=traces.z[keep],
        travelled=traces.travelled[keep],
    )


def _carried(surface: Surface, planes: FaceFrames, traces: Traces, rows: np.ndarray) -> np.ndarray:
    """(r,) places, in the planes of the points `rows`, of the points before them."""
    triangle = traces.triangle[rows]
    point = points_of(surface, planes, traces.triangle[rows - 1], traces.z[rows - 1])
    return laid(surface, triangle, point)


def laid(surface: Surface, triangle: np.ndarray, point: np.ndarray) -> np.ndarray:
    """(r,) complex places of points (r, 3) of triangles (r,) in their planes."""
    x, y = side_axes(surface, triangle)
    away = point - surface.vertices[surface.triangles[triangle, 0]]
    return as_complex(away, x, y)


def _crossings(
    surface: Surface,
    planes: FaceFrames,
    traces: Traces,
    barriers: Barriers,
    wanted: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Rows (q,) of points whose chords cross a feature, ascending, and how far along (q,).

    Parameters
    ----------
    wanted:
        (l,) bool lines to look at.
    """
    line = np.repeat(np.arange(len(traces.end)), np.diff(traces.start))
    first = np.zeros(len(line), bool)
    first[traces.start[:-1][np.diff(traces.start) > 0]] = True
    rows = np.flatnonzero(wanted[line] & ~first)
    triangle = traces.triangle[rows]
    hard = np.zeros(len(surface.twin), bool)
    hard[barriers.half_edge] = True
    twin = surface.twin[barriers.half_edge]
    hard[twin[twin >= 0]] = True
    weight = barycentric_of(planes, triangle, traces.z[rows])
    corner = weight.argmin(axis=1)
    on = weight[np.arange(len(rows)), corner] < ON_SIDE
    on &= hard[3 * triangle + (corner + 1) % 3]
    # Pieces of crests in the same triangles.
    order = np.argsort(barriers.triangle, kind="stable")
    begin, stop = (
        np.searchsorted(barriers.triangle[order], triangle, side) for side in ("left", "right")
    )
    count = stop - begin
    chord = np.repeat(np.arange(len(rows)), count)
    piece = order[spans(begin, count)]
    at = rows[chord]
    here, there = _carried(surface, planes, traces, at), traces.z[at]
    tail = laid(surface, barriers.triangle[piece], barriers.tail[piece])
    head = laid(surface, barriers.triangle[piece], barriers.head[piece])
    turn = ((there - here).conj() * (head - tail)).imag
    with np.errstate(divide="ignore", invalid="ignore"):
        share = ((tail - here).conj() * (head - tail)).imag / turn
        along = ((tail - here).conj() * (there - here)).imag / turn
        met = (share >= 0.0) & (share <= 1.0) & (along >= 0.0) & (along <= 1.0)
    row = np.concatenate([rows[on], at[met]])
    share = np.concatenate([np.ones(np.count_nonzero(on)), share[met]])
    order = np.lexsort((share, row))
    return row[order], share[order]
