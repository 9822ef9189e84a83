"""One round of the drawing of evenly spaced lines: whole lines, traced both ways from seeds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from ...base.progress import Progress
from ...base.unit import unit
from .canvas import Canvas
from .polylines import points_of, sparse_rows
from .tracing import CLOSED, MET, Obstacles, Starts, Traces, trace
from .truncation import laid

# Points to a spacing that a line is handed on with.
DETAIL = 10


@dataclass(frozen=True)
class Round:
    """Whole lines: p points in order along each, `arc` measured from the seed.

    Attributes
    ----------
    line, arc, triangle, z:
        (p,) row of the line, length from its seed (negative on one side) and place.
    family, closed:
        (l,) of each line.
    """

    line: np.ndarray
    arc: np.ndarray
    triangle: np.ndarray
    z: np.ndarray
    family: np.ndarray
    closed: np.ndarray


def draw_round(
    canvas: Canvas,
    triangle: np.ndarray,
    z: np.ndarray,
    family: np.ndarray,
    trees: dict[int, cKDTree | None],
    progress: Progress,
) -> Round:
    """The lines through the seeds (l,), as far as the lines of `trees` let them.

    Parameters
    ----------
    trees:
        For each family the `Canvas.embedded` samples of its lines, None where there are none.
    """
    ahead = canvas.direction(triangle, z, family)
    both = np.stack([ahead, -ahead], axis=1).ravel()
    starts = Starts.plain(
        np.repeat(triangle, 2),
        np.repeat(z, 2),
        both,
        np.repeat(family, 2),
        np.full(len(both), 0.5 * canvas.longest),
    )
    meeting = _Meeting(canvas, starts.family, trees)
    obstacles = Obstacles(canvas.obstacle)
    result = trace(canvas.surface, canvas.planes, starts, obstacles, progress, meeting)
    return _closed_cleanly(canvas, _joined(canvas, result, family))


class _Meeting:
    """Ends lines that come near to others of their family, and both halves of a closed one."""

    def __init__(self, canvas: Canvas, family: np.ndarray, trees: dict[int, cKDTree]) -> None:
        self._canvas, self._family, self._trees = canvas, family, trees
        self.every = canvas.every
        count = len(family)
        self._head = np.full((count, 6), 1e9)
        self._far, self._before = np.zeros(count), np.zeros(count)

    def __call__(
        self, ids: np.ndarray, triangle: np.ndarray, z: np.ndarray, length: np.ndarray
    ) -> np.ndarray:
        canvas = self._canvas
        points = canvas.embedded(triangle, z)
        self._head[ids], self._far[ids] = points, length
        code = np.full(len(ids), -1)
        for number, tree in self._trees.items():
            rows = np.flatnonzero(self._family[ids] == number)
            if tree is not None and len(rows):
                distance, _ = tree.query(points[rows], distance_upper_bound=canvas.near)
                code[rows[np.isfinite(distance)]] = MET
        partner = ids ^ 1
        gap = np.linalg.norm(points - self._head[partner], axis=1)
        long = np.minimum(length, self._far[partner]) > 2.0 * canvas.spacing + canvas.apart
        # Ends that have passed beside each other are on their second turn from there.
        passed = (gap < canvas.near) & (gap > self._before[ids])
        code[long & passed] = MET
        code[long & (gap < canvas.apart)] = CLOSED
        self._before[ids] = gap
        return code


def _joined(canvas: Canvas, result: Traces, family: np.ndarray) -> Round:
    """Both halves of every line as one, thinned to what is handed on."""
    rows = sparse_rows(result, canvas.spacing / DETAIL, canvas.surface)
    half = np.repeat(np.arange(len(result.end)), np.diff(result.start))[rows]
    backward = half % 2 == 1
    # The seed itself begins both halves.
    keep = ~(backward & (result.travelled[rows] == 0.0))
    rows, half, backward = rows[keep], half[keep], backward[keep]
    arc = np.where(backward, -1.0, 1.0) * result.travelled[rows]
    triangle, z = result.triangle[rows], result.z[rows]
    # The chord that ends at a point of a half turned round is the one that began there.
    turned = np.flatnonzero(backward & (rows + 1 < result.start[half + 1]))
    point = points_of(canvas.surface, canvas.planes, triangle[turned], z[turned])
    triangle[turned] = result.triangle[rows[turned] + 1]
    z[turned] = laid(canvas.surface, triangle[turned], point)
    order = np.lexsort((arc, half // 2))
    closed = (result.end[::2] == CLOSED) & (result.end[1::2] == CLOSED)
    return Round(half[order] // 2, arc[order], triangle[order], z[order], family, closed)


def _closed_cleanly(canvas: Canvas, drawn: Round) -> Round:
    """Without what the ends of closed lines have passed of each other; a line whose ends pass
    beside each other is not closed."""
    points = points_of(canvas.surface, canvas.planes, drawn.triangle, drawn.z)
    start = np.searchsorted(drawn.line, np.arange(len(drawn.family) + 1))
    keep, closed = np.ones(len(points), bool), drawn.closed.copy()
    for line in np.flatnonzero(closed):
        rows = np.arange(start[line], start[line + 1])
        ahead = unit(points[rows[0]] - points[rows[2]])
        late = rows[drawn.arc[rows] > drawn.arc[rows[-1]] - 2.0 * canvas.apart]
        over = points[late] - points[rows[0]]
        along = over @ ahead
        beside = np.linalg.norm(over - along[:, None] * ahead, axis=1)
        # The chord that closes the line goes ahead rather than aside; what comes before stays.
        fitting = np.flatnonzero(along >= 2.0 * beside)
        keep[late[fitting[-1] + 1 if len(fitting) else 0 :]] = False
        closed[line] = beside[np.abs(along).argmin()] < 0.25 * canvas.near
    return Round(
        drawn.line[keep],
        drawn.arc[keep],
        drawn.triangle[keep],
        drawn.z[keep],
        drawn.family,
        closed,
    )
