"""Curves as polylines of Wavefront OBJ: `v x y z` for every point, `l i j …` for every line.

A group `g first` or `g second` precedes the lines of a family. A closed line names its first
point again at its end.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..base.errors import FormatError
from ..retopology.lines.polylines import FAMILIES, Lines
from .text import numbers_of, read_text, rows_of, write_text


def write_curves(path: Path | str, lines: Lines) -> None:
    """Write all lines, one family after the other.

    Raises
    ------
    FormatError
        The file cannot be written.
    """
    text = ["v " + row + "\n" for row in rows_of(lines.position).splitlines()]
    for number, name in enumerate(FAMILIES):
        text.append(f"g {name}\n")
        for line in np.flatnonzero(lines.family == number):
            points = list(range(lines.start[line] + 1, lines.start[line + 1] + 1))
            if lines.closed[line]:
                points.append(points[0])
            text.append("l " + " ".join(map(str, points)) + "\n")
    write_text(path, "".join(text))


def read_curves(path: Path | str) -> tuple[list[np.ndarray], np.ndarray, np.ndarray]:
    """The points (q, 3) of each line, (l,) its family, 0 or 1, and (l,) bool whether closed.

    Raises
    ------
    FormatError
        The file holds a line of points that are not there.
    """
    points: list[str] = []
    lines: list[np.ndarray] = []
    family: list[int] = []
    current = 0
    for row in read_text(path).splitlines():
        word, _, rest = row.partition(" ")
        if word == "v":
            points += rest.split()[:3]
        elif word == "g":
            current = FAMILIES.index(rest.strip()) if rest.strip() in FAMILIES else 0
        elif word == "l":
            # A texture's point may follow a slash; negative numbers count from the last point.
            words = [one.partition("/")[0] for one in rest.split()]
            named = numbers_of(path, words, np.int64)
            lines.append(np.where(named < 0, named + len(points) // 3, named - 1))
            family.append(current)
    position = numbers_of(path, points).reshape(-1, 3)
    if any(line.min() < 0 or line.max() >= len(position) for line in lines if len(line)):
        raise FormatError(f"{path}: a line names a point that is not there.")
    closed = np.array([len(line) > 2 and line[0] == line[-1] for line in lines], bool)
    found = [
        position[line[:-1] if ring else line] for line, ring in zip(lines, closed, strict=True)
    ]
    return found, np.array(family, np.int64), closed
