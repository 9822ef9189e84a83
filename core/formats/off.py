"""`.off`, the Object File Format of Geomview: vertices, then faces of any number of corners.

The head is OFF, or that with letters before it for normals (N), colours (C) or texture (ST), which
are passed over; then the numbers of vertices, faces and edges. `#` begins a comment.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from ..base.errors import FormatError
from .text import counts_of, numbers_of

_HEAD = re.compile(r"(ST)?(C)?(N)?OFF\b")


def read_off(path: Path | str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vertices (n, 3) float64, corners (c,) int64 of all faces one after the other, and the
    (m,) int64 number of corners of each face. Faces of less than three corners are left out.

    Raises
    ------
    FormatError
        The file cannot be read, is not of this format, is in binary or in four dimensions, has
        less in it than its head says, or has a face of a vertex that is not there.

    Examples
    --------
    >>> from pathlib import Path
    >>> lines = ("OFF", "3 1 0", "0 0 0", "1 0 0", "0 1 0", "3 0 1 2")
    >>> written = Path("triangle.off").write_text(chr(10).join(lines))
    >>> vertices, corners, sizes = core.read_off("triangle.off")
    >>> vertices.shape, corners.tolist(), sizes.tolist()
    ((3, 3), [0, 1, 2], [3])
    """
    try:
        text = Path(path).read_bytes().decode("utf-8", "replace")
    except OSError as error:
        raise FormatError(f"{path}: cannot be read ({error.strerror}).") from error
    if "#" in text:
        text = re.sub(r"#[^\n]*", "", text)
    lines = [line for line in text.splitlines() if line and not line.isspace()]
    if not lines or not (head := _HEAD.match(lines[0].strip())):
        raise FormatError(f"{path}: is not an OFF file; it does not begin with OFF.")
    rest = lines[0].strip()[head.end() :].split()
    if "BINARY" in rest:
        raise FormatError(f"{path}: is a binary OFF file; only those in text can be read.")
    lines = lines[1:] if not rest else [" ".join(rest), *lines[1:]]
    words = lines[0].split() if lines else []
    # The number of edges is often left away.
    count, face_count = counts_of(path, words, 2)
    vertices, faces = lines[1 : 1 + count], lines[1 + count : 1 + count + face_count]
    if len(vertices) < count or len(faces) < face_count:
        raise FormatError(f"{path}: ends before all the vertices and faces that it announces.")
    return _vertices(path, vertices), *_faces(path, faces, count)


def _vertices(path: Path | str, lines: list[str]) -> np.ndarray:
    if not lines:
        return np.empty((0, 3))
    words = " ".join(lines).split()
    width = len(lines[0].split())
    if width < 3 or len(words) != width * len(lines):
        raise FormatError(f"{path}: not all vertices have the same number of coordinates.")
    numbers = numbers_of(path, words).reshape(-1, width)[:, :3].copy()
    if not np.isfinite(numbers).all():
        raise FormatError(f"{path}: a vertex is nowhere (not a number or infinite).")
    return numbers


def _faces(path: Path | str, lines: list[str], count: int) -> tuple[np.ndarray, np.ndarray]:
    # Lines of the same beginning and length are read together: there are few kinds.
    kinds: dict[tuple[int, int], list[int]] = {}
    rows = [line.split() for line in lines]
    for number, row in enumerate(rows):
        (size,) = counts_of(path, row, 1)
        if len(row) <= size:
            raise FormatError(f"{path}: a face has fewer corners than it says.")
        kinds.setdefault((size, len(row)), []).append(number)
    sizes = np.zeros(len(rows), np.int64)
    for (size, _), members in kinds.items():
        sizes[members] = size if size >= 3 else 0
    start = np.cumsum(sizes) - sizes
    corners = np.empty(int(sizes.sum()), np.int64)
    for (size, _), members in kinds.items():
        if size >= 3:
            words = [word for number in members for word in rows[number][1 : 1 + size]]
            place = start[members][:, None] + np.arange(size)
            corners[place] = numbers_of(path, words, np.int64).reshape(-1, size)
    if len(corners) and (corners.min() < 0 or corners.max() >= count):
        raise FormatError(f"{path}: a face names a vertex that is not there.")
    return corners, sizes[sizes > 0]
