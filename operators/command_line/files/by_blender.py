"""Files that Blender writes itself, whole or not at all: it does not say that a disk is full."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable
from pathlib import Path

from .... import core
from ...base.errors import FileError
from .guard import shown
from .quiet import quiet


def write(path: Path, save: Callable[[str], object], end: bytes) -> None:
    """Have `save` write a file that is whole if it ends with the bytes `end`.

    Raises
    ------
    FileError
        It cannot be written there; the text says why.
    """
    try:
        with core.whole_file(path) as partial:
            with quiet():
                save(str(partial.resolve()))
            if not ends_with(partial, end):
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))
    except (OSError, RuntimeError) as error:
        reason = getattr(error, "strerror", None) or str(error).strip()
        raise FileError(f"{shown(path)}: cannot be written ({reason}).") from error


def ends_with(path: Path, end: bytes) -> bool:
    """Whether there is such a file and it ends with these bytes."""
    if not path.exists():
        return False
    with path.open("rb") as file:
        file.seek(-min(len(end), path.stat().st_size), os.SEEK_END)
        return file.read() == end
