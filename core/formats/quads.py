"""A mesh of quads with its figures, as binary PLY.

At its vertices stands `valence`, of the poles, else 0, and at its faces `patch`, the rectangle of
the layout that each belongs to, and `angle`, degrees to the curvature (nan where there is none).
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..base.errors import FormatError
from ..retopology.quads.result import QuadMesh
from .whole import whole_file

_VERTEX = [*((name, "<f8") for name in ("x", "y", "z")), ("valence", "<i4")]
_FACE = [("count", "u1"), ("vertex_indices", "<i4", 4), ("patch", "<i4"), ("angle", "<f4")]
_HEADER = """ply
format binary_little_endian 1.0
element vertex {vertices}
property double x
property double y
property double z
property int valence
element face {faces}
property list uchar int vertex_indices
property int patch
property float angle
end_header
"""


def write_quads(path: Path | str, mesh: QuadMesh) -> None:
    """Write vertices and quads with their figures.

    Raises
    ------
    FormatError
        The file cannot be written.
    """
    vertices = np.zeros(len(mesh.vertices), _VERTEX)
    for axis, name in enumerate("xyz"):
        vertices[name] = mesh.vertices[:, axis]
    vertices["valence"] = mesh.valence
    faces = np.zeros(len(mesh.quads), _FACE)
    faces["count"], faces["vertex_indices"] = 4, mesh.quads
    faces["patch"], faces["angle"] = mesh.patch, mesh.angle
    header = _HEADER.format(vertices=len(vertices), faces=len(faces))
    try:
        with whole_file(path) as place, open(place, "wb") as file:
            file.write(header.encode())
            file.write(vertices.tobytes())
            file.write(faces.tobytes())
    except OSError as error:
        raise FormatError(f"{path}: cannot be written ({error.strerror}).") from error
