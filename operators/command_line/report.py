"""The JSON report, schema 1; docs/json.md says what each field means."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ... import core
from ..base.errors import FileError
from ..jobs.detect import Inputs
from . import version
from .files.guard import shown

SCHEMA = 1
# Bytes that are read at a time for the digest.
_PIECE = 1 << 20


def source_of(file: str | None, others: Sequence[str]) -> dict[str, Any] | None:
    """What tells a file, with those that are read beside it, from every other; None for what
    Blender has open without a file.

    Raises
    ------
    FileError
        The file cannot be read.
    """
    path = file or bpy.data.filepath
    if not path:
        return None
    try:
        source = _told(path)
    except OSError as error:
        raise FileError(f"{shown(path)}: cannot be read ({error.strerror}).") from error
    beside = []
    for other in others:
        try:
            beside.append(_told(other))
        except (OSError, ValueError):
            # What is named and missing is another file when it comes.
            beside.append({"file": shown(other), "bytes": None, "sha256": None})
    return source | ({"beside": beside} if beside else {})


def _told(path: str) -> dict[str, Any]:
    digest = hashlib.sha256()
    with open(path, "rb") as data:
        while piece := data.read(_PIECE):
            digest.update(piece)
        return {"file": shown(path), "bytes": data.tell(), "sha256": digest.hexdigest()}


def success(
    about: dict[str, Any],
    inputs: Inputs,
    detection: core.Detection,
    to_file: np.ndarray,
    per_vertex: bool,
) -> dict[str, Any]:
    """What the report says of one object besides the names in `about`; `to_file` (3, 3) turns
    world into file coordinates."""
    entry = {
        **about,
        "analysed": inputs.analysed,
        "vertices": len(inputs.arrays.vertices),
        "faces": inputs.arrays.polygon_count,
        "triangles": len(inputs.arrays.triangles),
        "counts": detection.umbilics.counts(),
        "index_sum": detection.index_sum,
        "expected_index_sum": detection.expected_index_sum,
        "euler_characteristic": detection.euler_characteristic,
        "persistence_level": detection.persistence_level,
        "trust_ratio": detection.trust_ratio,
        "noise": detection.noise,
        "scale": detection.scale,
        "warnings": list(detection.warnings),
        "timings": detection.timings,
        "umbilics": _umbilics(inputs, detection.umbilics, to_file),
        "regions": [
            {
                "kind": region.kind,
                "index": region.index,
                "area": region.area,
                "curvature": region.curvature,
                "triangles": inputs.arrays.loop_triangle[region.triangles],
            }
            for region in detection.regions
        ],
    }
    if per_vertex:
        field = detection.curvature
        entry["curvature"] = {
            "k1": field.k1,
            "k2": field.k2,
            "d1": field.d1 @ to_file.T,
            "d2": field.d2 @ to_file.T,
            "normal": field.normal @ to_file.T,
            "noise": field.noise,
        }
    return entry


def comparison(results: tuple[core.MethodResult, ...], to_file: np.ndarray) -> list[dict[str, Any]]:
    """What the report says of the methods side by side; `to_file` as in `success`."""
    return [
        {
            "method": result.method,
            "refusal": result.refusal or None,
            "counts": result.detection.umbilics.counts() if result.detection else None,
            "index_sum": result.detection.index_sum if result.detection else None,
            "positions": result.detection.umbilics.position @ to_file.T
            if result.detection
            else None,
            "confirmed": result.confirmed,
            "missed": result.missed,
            "unmatched": result.unmatched,
            "error": result.error,
            "seconds": result.seconds,
        }
        for result in results
    ]


def write(
    path: Path,
    settings: dict[str, Any],
    source: dict[str, Any] | None,
    entries: list[dict[str, Any]],
) -> None:
    """Write the report, whole or not at all.

    Raises
    ------
    FileError
        The file cannot be written.
    """
    content = {
        "schema": SCHEMA,
        "version": version.OURS,
        "blender": bpy.app.version_string,
        "source": source,
        "settings": settings,
        "objects": entries,
    }
    try:
        with core.whole_file(path) as partial, open(partial, "w", encoding="utf-8") as file:
            # In ASCII: names may hold what some readers take for ends of lines.
            json.dump(_plain(content), file, allow_nan=False, indent=1)
            file.write("\n")
    except OSError as error:
        raise FileError(f"{shown(path)}: cannot be written ({error.strerror}).") from error


def _umbilics(inputs: Inputs, umbilics: core.Umbilics, to_file: np.ndarray) -> list[dict[str, Any]]:
    arrays = inputs.arrays
    columns = {
        "kind": umbilics.kind,
        "index": umbilics.index,
        "position": umbilics.position @ to_file.T,
        "normal": umbilics.normal @ to_file.T,
        "curvature": umbilics.curvature,
        "persistence": umbilics.persistence,
        "permanent": np.isposinf(umbilics.persistence),
        "importance": umbilics.importance,
        "uncertainty": umbilics.uncertainty,
        "certain": umbilics.certain,
        "elliptic": umbilics.elliptic,
        "face": arrays.polygon[umbilics.triangle],
        "triangle": arrays.loop_triangle[umbilics.triangle],
        "triangle_vertices": arrays.triangles[umbilics.triangle],
        "barycentric": umbilics.barycentric,
        "vertex": umbilics.vertex,
        "separatrices": umbilics.separatrix @ to_file.T,
    }
    rows = []
    for values in zip(*(column.tolist() for column in columns.values()), strict=True):
        row = dict(zip(columns, values, strict=True))
        row["separatrices"] = [line for line in row["separatrices"] if math.isfinite(line[0])]
        row["vertex"] = None if row["vertex"] < 0 else row["vertex"]
        rows.append(row)
    return rows


def _plain(value: Any) -> Any:
    """The value in JSON's own types; what is not finite becomes null."""
    if isinstance(value, np.ndarray | np.generic):
        return _plain(value.tolist())
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
