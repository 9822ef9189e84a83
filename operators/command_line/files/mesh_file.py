"""The analysed mesh with its curvatures as a binary PLY file, for programs other than Blender.

Vertices carry k1, k2 and the directions d1, d2; faces, which are triangles, carry the index of
the direction field in them and the number of their region (0 outside all). Docs: docs/batch.md.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from .... import core
from ...base.errors import FileError
from ...jobs.detect import Inputs
from .guard import shown

_VERTEX = [
    *((name, "<f8") for name in ("x", "y", "z")),
    *((name, "<f4") for name in ("k1", "k2", "d1x", "d1y", "d1z", "d2x", "d2y", "d2z")),
    ("surface_type", "<i4"),
]
_FACE_VALUES = [("index", "<f4"), ("region", "<i4")]
_FACE = [("count", "u1"), ("vertex_indices", "<i4", 3), *_FACE_VALUES]
_NAMES = {"<f8": "double", "<f4": "float", "<i4": "int"}


def write(path: Path, found: list[tuple[Inputs, core.Detection]], to_file: np.ndarray) -> None:
    """Write all objects as one mesh; `to_file` (3, 3) turns world into file coordinates.

    Raises
    ------
    FileError
        The file cannot be written.
    """
    vertices = np.concatenate([_vertices(*pair, to_file) for pair in found])
    counts = [len(inputs.arrays.vertices) for inputs, _ in found]
    first = np.cumsum([0, *counts[:-1]])
    faces = np.concatenate(
        [_faces(*pair, offset) for pair, offset in zip(found, first, strict=True)]
    )
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(vertices)}"]
    header += [f"property {_NAMES[kind]} {name}" for name, kind in _VERTEX]
    header += [f"element face {len(faces)}", "property list uchar int vertex_indices"]
    header += [f"property {_NAMES[kind]} {name}" for name, kind in _FACE_VALUES]
    try:
        with core.whole_file(path) as partial, open(partial, "wb") as file:
            file.write("\n".join([*header, "end_header\n"]).encode())
            file.write(vertices.tobytes())
            file.write(faces.tobytes())
    except OSError as error:
        raise FileError(f"{shown(path)}: cannot be written ({error.strerror}).") from error


def _vertices(inputs: Inputs, detection: core.Detection, to_file: np.ndarray) -> np.ndarray:
    field = detection.curvature
    rows = np.empty(len(inputs.arrays.vertices), dtype=_VERTEX)
    position, d1, d2 = (array @ to_file.T for array in (inputs.arrays.vertices, field.d1, field.d2))
    for axis, name in enumerate("xyz"):
        rows[name] = position[:, axis]
        rows[f"d1{name}"] = d1[:, axis]
        rows[f"d2{name}"] = d2[:, axis]
    rows["k1"], rows["k2"] = field.k1, field.k2
    rows["surface_type"] = detection.surface_type
    return rows


def _faces(inputs: Inputs, detection: core.Detection, first: int) -> np.ndarray:
    rows = np.zeros(len(inputs.arrays.triangles), dtype=_FACE)
    rows["count"] = 3
    rows["vertex_indices"] = inputs.arrays.triangles + first
    rows["index"] = detection.triangle_index
    for number, region in enumerate(detection.regions, start=1):
        rows["region"][region.triangles] = number
    return rows
