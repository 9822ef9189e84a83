"""Separatrices that run beside each other made to run as one, like tracks that meet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree


@dataclass(frozen=True)
class Bundled:
    """Which points the lines go through, after joining.

    Attributes
    ----------
    row, line:
        (q,) int64 rows of the points that came in, line by line, and the line of each.
    target:
        (l,) int64 the umbilic that each line ends at now, negative for none.
    """

    row: np.ndarray
    line: np.ndarray
    target: np.ndarray


def joined_bundles(
    points: np.ndarray,
    normal: np.ndarray,
    line: np.ndarray,
    family: np.ndarray,
    source: np.ndarray,
    target: np.ndarray,
    apart: float,
    least: float,
) -> Bundled:
    """Join lines of a family where they run nearer than `apart` to each other, over the length
    `least` or more: those that only come together at the same umbilic do so for less.

    Lines that arrive, shorter ones first, stay; the others go on along them, forwards or
    backwards, to where they come from or end.

    Parameters
    ----------
    points, normal, line:
        (p, 3) points and unit normals in order along the lines, and (p,) the line of each.
    family, source, target:
        (l,) of each line, with the umbilics at its ends, negative for none: such a number is
        handed on to lines that go on along the line.
    """
    count = len(family)
    start = np.searchsorted(line, np.arange(count + 1))
    step = np.zeros(len(points))
    step[1:] = np.linalg.norm(np.diff(points, axis=0), axis=1)
    step[start[:-1][np.diff(start) > 0]] = 0.0
    arc = np.cumsum(step)
    length = np.zeros(count)
    some = np.flatnonzero(np.diff(start) > 0)
    length[some] = arc[start[1:][some] - 1] - arc[start[:-1][some]]
    # Neither the other family nor the other side of a thin sheet is near.
    place = np.hstack([points, 2.0 * apart * normal, 10.0 * apart * family[line][:, None]])
    pairs = cKDTree(place).query_pairs(apart, output_type="ndarray")
    pairs = pairs[line[pairs[:, 0]] != line[pairs[:, 1]]]
    pairs = np.concatenate([pairs, pairs[:, ::-1]])
    pairs = pairs[np.argsort(pairs[:, 0], kind="stable")]
    first = np.searchsorted(pairs[:, 0], np.arange(len(points) + 1))
    taken = np.zeros(len(points), bool)
    way = [np.arange(start[number], start[number + 1]) for number in range(count)]
    target = target.copy()
    for number in np.lexsort((length, target < 0)):
        rows = way[number]
        if len(rows):
            links = pairs[first[rows[0]] : first[rows[-1] + 1]]
            links = links[taken[links[:, 1]]]
            while (cut := _run(rows, arc, links[:, 0], least)) is not None:
                beside = links[links[:, 0] == cut, 1]
                other = beside[np.linalg.norm(points[beside] - points[cut], axis=1).argmin()]
                tail, end = _onward(
                    points, cut, other, way[line[other]], source[line[other]], target[line[other]]
                )
                # None is led back to where it comes from, but those that come back of themselves.
                if end != source[number] or target[number] == source[number]:
                    rows = np.arange(rows[0], cut + 1)
                    way[number], target[number] = np.concatenate([rows, tail]), end
                    break
                # Another one may lead further.
                links = links[line[links[:, 1]] != line[other]]
            taken[rows] = True
    label = np.repeat(np.arange(count), [len(rows) for rows in way])
    return Bundled(np.concatenate(way) if way else line, label, target)


def _run(rows: np.ndarray, arc: np.ndarray, near: np.ndarray, least: float) -> int | None:
    """The first of the rows of a line from which on all are among `near` over the length
    `least`; None without one."""
    beside = np.isin(rows, near)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], beside, [False]]).astype(np.int8)))
    for begin, end in zip(edges[::2], edges[1::2], strict=True):
        if arc[rows[end - 1]] - arc[rows[begin]] >= least:
            return int(rows[begin])
    return None


def _onward(
    points: np.ndarray, row: int, other: int, way: np.ndarray, source: int, target: int
) -> tuple[np.ndarray, int]:
    """The points of another line from its point `other` on, in the way that the line at `row`
    is going, and the umbilic that leads to."""
    at = int(other - way[0])
    ahead = points[row + 1] - points[row]
    along = points[way[min(at + 1, len(way) - 1)]] - points[way[max(at - 1, 0)]]
    if float(ahead @ along) >= 0.0:
        return way[at + 1 :], target
    return way[:at][::-1], source
