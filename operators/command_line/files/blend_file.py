"""The open file with the results as a .blend."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import bpy

from .... import core
from ...base.errors import FileError
from .guard import shown
from .quiet import quiet

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
    try:
        with core.whole_file(path) as partial:
            with quiet():
                place = str(partial.resolve())
                bpy.ops.wm.save_as_mainfile(filepath=place, copy=True, compress=True)
            # Blender does not say that a disk is full.
            if not _is_whole(partial):
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))
    except (OSError, RuntimeError) as error:
        reason = getattr(error, "strerror", None) or str(error).strip()
        raise FileError(f"{shown(path)}: cannot be written ({reason}).") from error


def _is_whole(path: Path) -> bool:
    with path.open("rb") as file:
        file.seek(-min(len(_END), path.stat().st_size), os.SEEK_END)
        return file.read() == _END
