"""Guide strokes and wanted poles from files: what a user or a program drew and moved for a plan.

`.json` is an object with "strokes", "poles" or both (docs/schemas/steering.schema.json):

    {"strokes": [{"points": [[x, y, z], …], "closed": false, "influence": 0.2}],
     "poles": [{"position": [x, y, z], "valence": 3}]}

A pole's place may stand as "x", "y" and "z", as in the tables that a guidance is written to. `.obj`
holds strokes as polylines; such that meet end to end are one.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..base.errors import FormatError
from ..retopology.by_hand import Strokes, StrokeSettings, WantedPoles
from ..retopology.ridges.paths import ordered_paths
from .curves import read_curves
from .text import read_text

VALENCES = (3, 5)


@dataclass(frozen=True)
class Steering:
    """What a plan is to be steered by, in the coordinates of its file.

    Attributes
    ----------
    lines:
        (q, 3) float64 points of each stroke; a closed one has its first point again at its end.
    influence:
        (l,) float64 length to both sides over which each counts, NaN where the file does not say.
    wanted:
        All the poles that there are to be, or None where they are to be planned.
    """

    lines: tuple[np.ndarray, ...]
    influence: np.ndarray
    wanted: WantedPoles | None

    def turned(self, matrix: np.ndarray) -> Steering:
        """The same in coordinates that `matrix` (3, 3) turns these into."""
        wanted = self.wanted
        if wanted is not None:
            wanted = replace(wanted, position=wanted.position @ matrix.T)
        return replace(self, lines=tuple(line @ matrix.T for line in self.lines), wanted=wanted)

    def strokes(self, size: float, settings: StrokeSettings | None = None) -> Strokes | None:
        """The strokes for a mesh whose longest side is `size`; None without any."""
        if not self.lines:
            return None
        share = (settings or StrokeSettings()).influence
        return Strokes(
            start=np.concatenate([[0], np.cumsum([len(line) for line in self.lines])]),
            position=np.concatenate(self.lines),
            influence=np.where(np.isnan(self.influence), share * size, self.influence),
        )


def read_steering(path: Path | str) -> Steering:
    """The strokes and poles of a file.

    Raises
    ------
    FormatError
        The file cannot be read, is of another kind, or holds neither; the text says what of it is
        wrong.

    Examples
    --------
    >>> from pathlib import Path
    >>> text = '{"strokes": [{"points": [[0, 0, 1], [1, 0, 1]]}], "poles": []}'
    >>> written = Path("hand.json").write_text(text)
    >>> steering = core.read_steering("hand.json")
    >>> len(steering.lines), len(steering.wanted.valence)
    (1, 0)
    """
    ending = Path(path).suffix.lower()
    if ending == ".obj":
        points, _, closed = read_curves(path)
        rings = [
            np.concatenate([line, line[:1]]) if ring else line
            for line, ring in zip(points, closed, strict=True)
        ]
        lines = _joined([line for line in rings if len(line) > 1])
        if not lines:
            raise FormatError(f"{path}: holds no line; strokes are its elements l.")
        return Steering(tuple(lines), np.full(len(lines), np.nan), None)
    if ending == ".json":
        return _from_json(path)
    raise FormatError(f"{path}: strokes are read from .json and .obj files.")


def _joined(lines: list[np.ndarray]) -> list[np.ndarray]:
    """Lines that meet at their ends, two at a point, as one."""
    if not lines:
        return []
    ends = np.array([line[[0, -1]] for line in lines])
    _, node, count = np.unique(
        ends.reshape(-1, 3), axis=0, return_inverse=True, return_counts=True
    )
    node = node.ravel()
    # Where more meet, each ends.
    apart = count[node] > 2
    node[apart] = len(count) + np.flatnonzero(apart)
    paths = ordered_paths(node.reshape(-1, 2))
    found = []
    for begin, end in zip(paths.start[:-1], paths.start[1:], strict=True):
        parts = [
            lines[paths.segment[row]][:: 1 if paths.forward[row] else -1]
            for row in range(begin, end)
        ]
        found.append(np.concatenate([parts[0], *(part[1:] for part in parts[1:])]))
    return found


def _from_json(path: Path | str) -> Steering:
    try:
        content = json.loads(read_text(path))
    except (ValueError, RecursionError) as error:
        raise FormatError(f"{path}: is not JSON ({error}).") from error
    if not isinstance(content, dict) or not {"strokes", "poles"} & content.keys():
        raise FormatError(f'{path}: must be an object with "strokes" or "poles".')
    strokes, poles = (_list(path, name, content.get(name, [])) for name in ("strokes", "poles"))
    lines, influence = [], []
    for number, stroke in enumerate(strokes, 1):
        what = f"stroke {number}"
        if not isinstance(stroke, dict) or not isinstance(stroke.get("points"), list):
            raise FormatError(f'{path}: {what} must be an object with a list "points".')
        points = [_place(path, what, point) for point in stroke["points"]]
        if len(points) < 2:
            raise FormatError(f"{path}: {what} needs two points or more.")
        closed = stroke.get("closed", False)
        if not isinstance(closed, bool):
            raise FormatError(f'{path}: "closed" of {what} must be true or false.')
        lines.append(np.array([*points, points[0]] if closed else points))
        reach = stroke.get("influence")
        if reach is not None and not (_is_number(reach) and reach >= 0):
            raise FormatError(f'{path}: "influence" of {what} must be a length, 0 or more.')
        influence.append(math.nan if reach is None else float(reach))
    wanted = _poles(path, poles) if "poles" in content else None
    return Steering(tuple(lines), np.array(influence, float), wanted)


def _poles(path: Path | str, poles: list[Any]) -> WantedPoles:
    position, valence = [], []
    for number, pole in enumerate(poles, 1):
        what = f"pole {number}"
        if not isinstance(pole, dict):
            raise FormatError(f"{path}: {what} must be an object.")
        place = pole.get("position", [pole.get(axis) for axis in "xyz"])
        position.append(_place(path, what, place))
        if isinstance(pole.get("valence"), bool) or pole.get("valence") not in VALENCES:
            raise FormatError(
                f'{path}: "valence" of {what} is {json.dumps(pole.get("valence"))}: a pole has '
                "3 or 5."
            )
        valence.append(int(pole["valence"]))
    return WantedPoles(np.array(position, float).reshape(-1, 3), np.array(valence, np.int64))


def _list(path: Path | str, name: str, value: Any) -> list[Any]:
    if not isinstance(value, list):
        raise FormatError(f'{path}: "{name}" must be a list.')
    return value


def _place(path: Path | str, what: str, value: Any) -> list[float]:
    if not isinstance(value, list) or len(value) != 3 or not all(map(_is_number, value)):
        raise FormatError(f"{path}: a place of {what} must be three numbers [x, y, z].")
    return [float(number) for number in value]


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
