"""What some programs write and Blender's importers misread without a word, mended in a copy.

A mark of the byte order in front of an OBJ costs its first vertex, so that all faces name others;
line ends of old Macs make one line of a text; an STL in capitals, or with bytes behind its
triangles, has none.
"""

from __future__ import annotations

import codecs
import contextlib
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

from .content import stl

# Bytes that tell how a text is written.
_HEAD = 1 << 16


@contextlib.contextmanager
def readable(path: str) -> Iterator[str]:
    """A path of the same name from which Blender reads what is in the file: mostly the same."""
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
    kind = file.suffix.lower()
    if kind == ".ply" and not head.startswith(b"ply\rformat ascii"):
        return None
    if kind == ".stl":
        size = file.stat().st_size
        whole = stl.size_of_binary(head)
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
