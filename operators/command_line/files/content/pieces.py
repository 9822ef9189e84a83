"""A file read piece by piece: its beginning, its end, its lines."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

# Bytes that tell how a file is written, and that hold its last triangle.
_SOME = 1 << 16
# Bytes that are searched at a time.
SIZE = 1 << 22


def head_of(path: Path) -> bytes:
    with open(path, "rb") as file:
        return file.read(_SOME)


def tail_of(path: Path) -> bytes:
    """The last bytes of a text, in small letters with one kind of line ends."""
    with open(path, "rb") as file:
        file.seek(-min(_SOME, path.stat().st_size), os.SEEK_END)
        return file.read().lower().replace(b"\r", b"\n")


def lines_of(path: Path, start: int = 0) -> Iterator[bytes]:
    """A text from a byte on, in pieces of whole lines, each with the line end before it; where
    there are none, no more than a beginning. Mapped into memory instead, a file that somebody cuts
    short meanwhile would end Blender."""
    rest = b""
    with open(path, "rb") as file:
        file.seek(start)
        while piece := file.read(SIZE):
            cut = max(piece.rfind(b"\n"), piece.rfind(b"\r"))
            if cut >= 0:
                yield rest + piece[:cut]
                rest = piece[cut:]
            elif len(rest) < SIZE:
                rest += piece
    yield rest
