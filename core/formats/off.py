"""`.off`, the Object File Format of Geomview: vertices, then faces of any number of corners.

The head is OFF, or that with letters before it for normals (N), colours (C) or texture (ST), which
are passed over; then the numbers of vertices, faces and edges. `#` begins a comment. Mostly each
vertex and each face has a line, but only the numbers count: where the lines do not fit, those are
read one after the other. http://www.geomview.org/docs/html/OFF.html
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from ..base.errors import FormatError
from .text import counts_of, numbers_of

# The numbers follow at once in some collections (ModelNet): OFF490 518 0.
_HEAD = re.compile(r"(ST)?(C)?(N)?(4?n?)(?:OFF|off)(?![^\W\d])")
# Numbers of a vertex besides its place, by the letters before OFF.
_BESIDE = (2, 4, 3)


def read_off(path: Path | str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vertices (n, 3) float64, corners (c,) int64 of all faces one after the other, and the
    (m,) int64 number of corners of each face. Faces of less than three corners are left out.

    Raises
    ------
    FormatError
        The file cannot be read, is not of this format, is in binary or in more dimensions, has
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
        text = Path(path).read_bytes().decode("utf-8-sig", "replace")
    except OSError as error:
        raise FormatError(f"{path}: cannot be read ({error.strerror}).") from error
    # Of other line ends some stand in names and comments.
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    if "#" in text:
        text = re.sub(r"#[^\n]*", "", text)
    lines = [line for line in text.split("\n") if line and not line.isspace()]
    if not lines or not (head := _HEAD.match(lines[0].strip())):
        raise FormatError(f"{path}: is not an OFF file; it does not begin with OFF.")
    rest = lines[0].strip()[head.end() :].split()
    if "BINARY" in rest:
        raise FormatError(f"{path}: is a binary OFF file; only those in text can be read.")
    if head[4]:
        raise FormatError(f"{path}: is in more dimensions than three ({head[0]}).")
    lines = lines[1:] if not rest else [" ".join(rest), *lines[1:]]
    try:
        return _by_lines(path, lines)
    except FormatError:
        letters = head.groups()[: len(_BESIDE)]
        width = 3 + sum(
            count for count, letter in zip(_BESIDE, letters, strict=True) if letter
        )
        found = _by_numbers(path, lines, width)
        if found is None:
            raise
        return found


def _by_lines(path: Path | str, lines: list[str]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """What lines hold of which the first has the counts, then each a vertex or a face."""
    words = lines[0].split() if lines else []
    # The number of edges is often left away.
    count, face_count = counts_of(path, words, 2)
    vertices, faces = lines[1 : 1 + count], lines[1 + count : 1 + count + face_count]
    if len(vertices) < count or len(faces) < face_count:
        raise FormatError(f"{path}: ends before all the vertices and faces that it announces.")
    return _vertices(path, vertices), *_faces(path, faces, count)


def _by_numbers(
    path: Path | str, lines: list[str], width: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """What the numbers are, whatever lines they stand in, with `width` of them a vertex; None if
    they do not go up evenly."""
    words = [word for line in lines for word in line.split()]
    try:
        count, face_count, _ = counts_of(path, words, 3)
    except FormatError:
        return None
    at = 3 + width * count
    if at > len(words):
        return None
    vertices = [" ".join(words[first : first + width]) for first in range(3, at, width)]
    faces: list[str] = []
    while len(faces) < face_count and at < len(words):
        if not words[at].isdecimal():
            return None
        after = at + 1 + int(words[at])
        faces.append(" ".join(words[at:after]))
        at = after
    if at != len(words) or len(faces) < face_count:
        return None
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
