"""Vertices whose place in a file is none: words that are no numbers, and numbers that are not
finite or have no place in single precision.

Blender's importers read what comes before a comma, and 0 for all the rest, without a word: what is
in the scene then tells nothing of it.
"""

from __future__ import annotations

import contextlib
import re
import struct
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from . import gltf, pieces, ply, stl

# A number, and one as most are written: within single precision and without "nan".
_NUMBER = re.compile(
    rb"[+-]?(?:(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|nan(?:\([^)]*\))?|inf(?:inity)?)", re.IGNORECASE
)
_PLAIN = rb"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE]-\d+|[eE]\+?0*[0-2]?\d)?"
# A vertex of a text whose three numbers are not all plain ones, by the word for a vertex, whose
# letters are what is looked for first.
_OBJ_VERTEX, *_STL_VERTICES = (
    re.compile(
        rb"%b[ \t]+(?!%b[ \t]+%b[ \t]+%b(?!\S))(\S+)[ \t]+(\S+)[ \t]+(\S+)"
        % (word, _PLAIN, _PLAIN, _PLAIN)
    )
    for word in (rb"\nv", b"vertex", b"VERTEX")
)
_INDENTED = re.compile(rb"\n[ \t]+")
# What no plain number has.
_ODD = re.compile(rb"[^-+.\deE\s]")
_PLAIN_WORD = re.compile(_PLAIN)
_FARTHEST = float(np.finfo(np.float32).max)
# Places in an FBX, in binary as doubles or singles, how many, whether packed and in how many bytes;
# in text behind their number.
_FBX_PLACES = re.compile(rb"\x08Vertices([df])(.{12})", re.DOTALL)
_FBX_TEXT = re.compile(rb"Vertices:\s*\*\d+\s*\{\s*a:([^}]*)")
_FBX_ARRAY, _FBX_TYPES = struct.Struct("<III"), {b"d": "f8", b"f": "f4"}


def word_in(path: Path) -> bytes | None:
    """The first word of a text that stands for a coordinate of a vertex and is no number, empty
    where a coordinate is missing; None if all are numbers."""
    for place in _odd_places(path):
        for word in place:
            if not _NUMBER.fullmatch(word):
                return word
    return None


def count(path: Path) -> int:
    """How many vertices of a file have no place; what cannot be followed there counts for none."""
    counted = _COUNTS.get(path.suffix.lower())
    found = sum(not all(map(_is_in_reach, place)) for place in _odd_places(path))
    if counted is not None:
        with contextlib.suppress(
            ValueError, KeyError, IndexError, TypeError, AttributeError, struct.error, zlib.error
        ):
            found += counted(path)
    return found


def _odd_places(path: Path) -> Iterator[tuple[bytes, ...]]:
    """Places of vertices in a text whose numbers are not all plain ones."""
    odd = _ODD_PLACES.get(path.suffix.lower())
    return odd(path) if odd else iter(())


def _odd_in_obj(path: Path) -> Iterator[tuple[bytes, ...]]:
    for text in pieces.lines_of(path):
        text = _INDENTED.sub(b"\n", b"\n" + text.replace(b"\r", b"\n"))
        yield from (found.groups() for found in _OBJ_VERTEX.finditer(text))


def _odd_in_stl(path: Path) -> Iterator[tuple[bytes, ...]]:
    if not stl.is_binary(path, pieces.head_of(path)):
        for text in pieces.lines_of(path):
            for vertex in _STL_VERTICES:
                yield from (found.groups() for found in vertex.finditer(text))


def _odd_in_ply(path: Path) -> Iterator[tuple[bytes, ...]]:
    found = _ply_vertices(path)
    if found is None or found[0].order:
        return
    head, before, element = found
    columns = [element.index(axis) for axis in ply.AXES]
    first, end = before, before + element.count
    for text in pieces.lines_of(path, head.end):
        lines = [line for line in text.splitlines() if line.strip()]
        wanted = lines[max(first, 0) : max(end, 0)]
        first, end = first - len(lines), end - len(lines)
        together = b" ".join(wanted)
        numbers = len(wanted) * len(element.properties)
        if not _ODD.search(together) and _is_table(together.split(), numbers):
            continue
        for line in wanted:
            words = line.split()
            place = tuple(words[column] if column < len(words) else b"" for column in columns)
            if not all(map(_PLAIN_WORD.fullmatch, place)):
                yield place


def _is_table(words: list[bytes], size: int) -> bool:
    """Whether so many words are there, all of them numbers in single precision."""
    try:
        return len(words) == size and not _lost(np.array(words, float)[:, None])
    except ValueError:
        return False


def _is_in_reach(word: bytes) -> bool:
    """Whether a number of a text has a place in single precision."""
    try:
        return abs(float(word)) <= _FARTHEST
    except ValueError:
        return False


def _ply_vertices(path: Path) -> tuple[ply.Head, int, ply.Element] | None:
    """The head of a PLY, how many other elements are before its vertices, and these; None where
    they have no places, or where these cannot be found by counting."""
    try:
        head = ply.read_head(pieces.head_of(path))
    except ValueError:
        return None
    before = 0
    for element in head.elements:
        if element.name == b"vertex":
            whole = not element.has_lists and min(map(element.index, ply.AXES)) >= 0
            return (head, before, element) if whole else None
        before += element.count
    return None


def _in_ply(path: Path) -> int:
    found = _ply_vertices(path)
    # Of what is before the vertices the length is not known.
    if found is None or found[1] or not found[0].order:
        return 0
    head, _, element = found
    fields = [(str(i), head.order + one.kind) for i, one in enumerate(element.properties)]
    with open(path, "rb") as file:
        file.seek(head.end)
        vertices = np.fromfile(file, np.dtype(fields), element.count)
    columns = [vertices[str(element.index(axis))] for axis in ply.AXES]
    return _lost(np.stack(columns, axis=-1))


def _in_stl(path: Path) -> int:
    head = pieces.head_of(path)
    if not stl.is_binary(path, head):
        return 0
    with open(path, "rb") as file:
        file.seek(stl.START)
        triangles = np.fromfile(file, stl.TRIANGLE, stl.count_of_binary(head))
    return _lost(triangles["corners"].reshape(-1, 3))


def _in_gltf(path: Path) -> int:
    return sum(map(_lost, gltf.positions(path)))


def _in_fbx(path: Path) -> int:
    data = path.read_bytes()
    found = 0
    for array in _FBX_PLACES.finditer(data):
        kind, numbers = array.groups()
        size, is_packed, length = _FBX_ARRAY.unpack(numbers)
        places = data[array.end() : array.end() + length]
        number = np.dtype(f"<{_FBX_TYPES[kind]}")
        if is_packed:
            places = zlib.decompressobj().decompress(places, size * number.itemsize)
        found += _lost(np.frombuffer(places, number).reshape(-1, 3))
    for text in _FBX_TEXT.findall(data):
        found += _lost(np.array(text.split(b","), float).reshape(-1, 3))
    return found


def _lost(places: np.ndarray) -> int:
    """How many of some places (n, 3) are none in single precision."""
    # Of what is not a number no comparison holds.
    return int(np.count_nonzero(~(np.abs(places) <= _FARTHEST).all(axis=1)))


_ODD_PLACES: dict[str, Callable[[Path], Iterator[tuple[bytes, ...]]]] = {
    ".obj": _odd_in_obj,
    ".stl": _odd_in_stl,
    ".ply": _odd_in_ply,
}
_COUNTS: dict[str, Callable[[Path], int]] = {
    ".ply": _in_ply,
    ".stl": _in_stl,
    ".gltf": _in_gltf,
    ".glb": _in_gltf,
    ".fbx": _in_fbx,
}
