"""Binary STL: a title, the number of triangles, and so many bytes for each."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np

_TITLE = 80
TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
START = _TITLE + 4


def count_of_binary(head: bytes) -> int:
    """The number of triangles."""
    return struct.unpack_from("<I", head, _TITLE)[0]


def size_of_binary(head: bytes) -> int | None:
    """Bytes that it has by its number of triangles, None if it ends before that."""
    if len(head) < START:
        return None
    return START + TRIANGLE.itemsize * count_of_binary(head)


def is_binary(path: Path, head: bytes) -> bool:
    """Whether an STL is none in text, by its length or what no text holds."""
    return size_of_binary(head) == path.stat().st_size or b"\0" in head
