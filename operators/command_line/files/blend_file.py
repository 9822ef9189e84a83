"""The open file with the results as a .blend."""

from __future__ import annotations

from pathlib import Path

import bpy

from . import by_blender

# How a compressed .blend ends: the mark of the table of the parts that can be read by themselves,
# https://github.com/facebook/zstd/blob/dev/contrib/seekable_format
_END = (0x8F92EAB1).to_bytes(4, "little")


def write(path: Path) -> None:
    """Save a copy, whole or not at all.

    Raises
    ------
    FileError
        It cannot be written there; the text says why.
    """

    def save(place: str) -> None:
        bpy.ops.wm.save_as_mainfile(filepath=place, copy=True, compress=True)

    by_blender.write(path, save, _END)
