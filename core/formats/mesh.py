"""The triangles that a field belongs to, as Wavefront OBJ: fields go by the order of its faces."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..base.errors import FormatError
from .text import numbers_of, read_text, rows_of, write_text


def write_mesh(path: Path | str, vertices: np.ndarray, faces: np.ndarray) -> None:
    """Write (n, 3) vertices and (m, k) faces, triangles or quads, in their order.

    Raises
    ------
    FormatError
        The file cannot be written.
    """
    points = rows_of(np.asarray(vertices, np.float64)).splitlines()
    corners = rows_of(np.asarray(faces, np.int64) + 1).splitlines()
    text = "".join(f"v {row}\n" for row in points) + "".join(f"f {row}\n" for row in corners)
    write_text(path, text)


def read_mesh(path: Path | str) -> tuple[np.ndarray, np.ndarray]:
    """(n, 3) float64 vertices and (m, 3) int64 triangles of such a file.

    Raises
    ------
    FormatError
        A face is not a triangle of vertices that are there.
    """
    points, faces = [], []
    for row in read_text(path).splitlines():
        word, *rest = row.split()
        if word == "v":
            points += rest[:3]
        elif word == "f":
            if len(rest) != 3:
                raise FormatError(f"{path}: a face is not a triangle.")
            faces += [corner.split("/")[0] for corner in rest]
    vertices = numbers_of(path, points).reshape(-1, 3)
    triangles = numbers_of(path, faces, np.int64).reshape(-1, 3) - 1
    if len(triangles) and (triangles.min() < 0 or triangles.max() >= len(vertices)):
        raise FormatError(f"{path}: a face names a vertex that is not there.")
    return vertices, triangles
