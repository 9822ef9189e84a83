"""What some programs write and Blender's importers misread without a word, mended in a copy.

A mark of the byte order in front of an OBJ costs its first vertex, so that all faces name others;
line ends of old Macs make one line of a text; an STL in capitals, or with bytes behind its
triangles, has none. A PLY that announces more than it holds ends Blender itself.
"""

from __future__ import annotations

import codecs
import contextlib
import re
import struct
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

from ...base.errors import FileError
from .guard import shown

# Bytes that tell how a text is written.
_HEAD = 1 << 16
# A binary STL: a title, the number of triangles, and so many bytes for each.
_STL_TITLE, _STL_TRIANGLE = 80, 50
_WIDE = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)


@contextlib.contextmanager
def readable(path: str) -> Iterator[str]:
    """A path of the same name from which Blender reads what is in the file: mostly the same.

    Raises
    ------
    FileError
        The file is text of two bytes a letter, or announces more than it holds.
    """
    mend = _mends(path)
    if mend is None:
        yield path
        return
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder, Path(path).name)
        copy.write_bytes(mend(Path(path).read_bytes()))
        yield str(copy)


def _mends(path: str) -> Callable[[bytes], bytes] | None:
    """What to do with the bytes of a file, None if they can stay."""
    file = Path(path)
    with open(file, "rb") as data:
        head = data.read(_HEAD)
    if head.startswith(_WIDE):
        raise FileError(f"{shown(path)}: is text in UTF-16; save it in UTF-8 or ASCII.")
    kind = file.suffix.lower()
    if kind == ".ply":
        _check_ply(path, head, file.stat().st_size)
        return None
    if kind == ".stl":
        size = file.stat().st_size
        whole = _size_of_binary_stl(head)
        if whole == size:
            return None
        if whole is not None and b"\0" in head and whole < size:
            return lambda data: data[:whole]
    has_mark = head.startswith(codecs.BOM_UTF8)
    is_mac = b"\r" in head and b"\n" not in head
    in_capitals = kind == ".stl" and b"FACET" in head and b"\0" not in head
    if not (has_mark or is_mac or in_capitals):
        return None

    def mended(data: bytes) -> bytes:
        data = data.removeprefix(codecs.BOM_UTF8)
        if is_mac:
            data = data.replace(b"\r", b"\n")
        return data.lower() if in_capitals else data

    return mended


def _size_of_binary_stl(head: bytes) -> int | None:
    """Bytes that a binary STL has by its number of triangles."""
    if len(head) < _STL_TITLE + 4:
        return None
    (count,) = struct.unpack_from("<I", head, _STL_TITLE)
    return _STL_TITLE + 4 + _STL_TRIANGLE * count


def _check_ply(path: str, head: bytes, size: int) -> None:
    """Raise `FileError` if a PLY has fewer bytes than elements: each takes one at least."""
    end = head.find(b"end_header")
    counts = re.findall(rb"^\s*element\s+\S+\s+(\d+)\s*$", head[: max(end, 0)], re.MULTILINE)
    if sum(map(int, counts)) > size:
        raise FileError(f"{shown(path)}: ends before all the elements that its head announces.")
