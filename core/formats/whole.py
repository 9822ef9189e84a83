"""Files that appear whole or not at all."""

from __future__ import annotations

import contextlib
import errno
import os
import secrets
import shutil
import stat
from collections.abc import Iterator
from pathlib import Path

# How the names of unfinished files begin; the number of the process follows.
PARTIAL = ".umbilics-partial-"


@contextlib.contextmanager
def whole_file(path: Path | str) -> Iterator[Path]:
    """A path to write to in place of `path`, which takes its place when the block has ended well.

    The path lies in the same folder, made if it is missing, and has the same ending. Where the
    block fails nothing is left and the file that was there stays as it was. A link is followed.
    What is no ordinary file, such as a pipe or /dev/stdout, is written to as it is.

    Raises
    ------
    OSError
        The folder cannot be made, or the file cannot be put into its place.

    Examples
    --------
    >>> from pathlib import Path
    >>> with core.whole_file("cup.txt") as path:
    ...     _ = path.write_text("whole")
    >>> Path("cup.txt").read_text()
    'whole'
    """
    place = Path(os.path.realpath(path))
    place.parent.mkdir(parents=True, exist_ok=True)
    if place.exists() and not stat.S_ISREG(place.stat().st_mode) and not place.is_dir():
        yield Path(path)
        return
    # Short, as a name may be as long as the file system allows.
    name = f"{PARTIAL}{os.getpid()}-{secrets.token_hex(4)}{place.suffix[:16]}"
    partial = place.with_name(name)
    try:
        yield partial
        if place.is_dir():
            raise IsADirectoryError(errno.EISDIR, "it is a folder", str(path))
        with open(partial, "rb+") as file:
            os.fsync(file.fileno())
        if place.exists():
            shutil.copymode(place, partial)
        os.replace(partial, place)
    except BaseException:
        with contextlib.suppress(OSError):
            partial.unlink()
        raise
