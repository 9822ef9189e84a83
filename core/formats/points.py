"""Poles, umbilics and points of ridges as tables: CSV for spreadsheets, JSON for programs.

A table is a dict of columns, one value a row: numbers, words or, as `x`, `y`, `z`, places.
"""

from __future__ import annotations

import csv
import io
import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from ..base.errors import FormatError
from ..retopology.poles import Poles
from ..retopology.ridges.ridge_lines import RidgeLines
from ..umbilics.result import Umbilics
from .text import read_text, write_text

Table = dict[str, list[Any]]


def poles_table(poles: Poles) -> Table:
    """The columns of a pole plan."""
    return _places(poles.position, poles.normal) | {
        "valence": poles.valence.tolist(),
        "triangle": poles.triangle.tolist(),
        "umbilic": poles.umbilic.tolist(),
        "region": poles.region.tolist(),
        "confidence": poles.confidence.tolist(),
        "moved": poles.moved.astype(int).tolist(),
    }


def umbilics_table(umbilics: Umbilics) -> Table:
    """The columns of a set of umbilics; a persistence that nothing cancels is empty."""
    return _places(umbilics.position, umbilics.normal) | {
        "kind": umbilics.kind.tolist(),
        "index": umbilics.index.tolist(),
        "curvature": umbilics.curvature.tolist(),
        "triangle": umbilics.triangle.tolist(),
        "persistence": umbilics.persistence.tolist(),
        "uncertainty": umbilics.uncertainty.tolist(),
    }


def ridges_table(ridges: RidgeLines) -> Table:
    """The columns of the points of ridges, line after line; `line` counts from 0."""
    count = np.diff(ridges.start)
    return _places(ridges.position, ridges.normal) | {
        "line": np.repeat(np.arange(len(ridges)), count).tolist(),
        "kind": np.repeat(ridges.kind, count).tolist(),
        "family": np.repeat(ridges.family, count).tolist(),
        "closed": np.repeat(ridges.closed, count).astype(int).tolist(),
        "strength": ridges.strength.tolist(),
        "sharpness": ridges.sharpness.tolist(),
        "bend": ridges.bend.tolist(),
        "certainty": ridges.certainty.tolist(),
        "triangle": ridges.triangle.tolist(),
    }


def _places(position: np.ndarray, normal: np.ndarray) -> Table:
    names = ("x", "y", "z", "normal_x", "normal_y", "normal_z")
    return dict(zip(names, np.hstack([position, normal]).T.tolist(), strict=True))


def write_points_csv(path: Path | str, table: Table) -> None:
    """Write a table with a line of names; numbers that are not finite are left empty.

    Raises
    ------
    FormatError
        The file cannot be written.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(table)
    for row in zip(*table.values(), strict=True):
        writer.writerow(["" if _plain(value) is None else _word(value) for value in row])
    write_text(path, text.getvalue())


def read_points_csv(path: Path | str) -> Table:
    """The columns of such a file: whole numbers, numbers, words; None where empty.

    Raises
    ------
    FormatError
        A line has too many or too few values.
    """
    rows = list(csv.reader(io.StringIO(read_text(path))))
    if not rows:
        raise FormatError(f"{path}: is empty; a line of names is missing.")
    if any(len(row) != len(rows[0]) for row in rows):
        raise FormatError(f"{path}: not all lines have as many values as there are names.")
    return {name: [_value(row[column]) for row in rows[1:]] for column, name in enumerate(rows[0])}


def write_points_json(path: Path | str, tables: dict[str, Table]) -> None:
    """Write named tables as lists of objects; what is not finite becomes null.

    Raises
    ------
    FormatError
        The file cannot be written.
    """
    content = {
        name: [
            dict(zip(table, map(_plain, row), strict=True))
            for row in zip(*table.values(), strict=True)
        ]
        for name, table in tables.items()
    }
    write_text(path, json.dumps(content, indent=1, allow_nan=False) + "\n")


def read_points_json(path: Path | str) -> dict[str, Table]:
    """The named tables of such a file; an empty one has no columns.

    Raises
    ------
    FormatError
        The file is not such an object.
    """
    try:
        content = json.loads(read_text(path))
        return {
            name: {key: [row[key] for row in rows] for key in (rows[0] if rows else ())}
            for name, rows in content.items()
        }
    except (ValueError, AttributeError, TypeError, KeyError, IndexError) as error:
        raise FormatError(f"{path}: is not a JSON object of lists of objects.") from error


def _plain(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _word(value: Any) -> str:
    return repr(value) if isinstance(value, float) else str(value)


def _value(word: str) -> Any:
    if word == "":
        return None
    for kind in (int, float):
        try:
            return kind(word)
        except ValueError:
            continue
    return word
