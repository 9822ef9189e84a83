"""Files that appear whole or not at all."""

from __future__ import annotations

import contextlib
import errno
import os
import re
import secrets
import shutil
import stat
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import BinaryIO

# How the names of unfinished files begin; the number of the process follows.
PARTIAL = ".umbilics-partial-"


@contextlib.contextmanager
def whole_file(path: Path | str) -> Iterator[Path]:
    """A path to write to in place of `path`, which takes its place when the block has ended well.

    The path lies in the same folder, made if it is missing, and has the same ending. Where the
    block fails nothing is left and the file that was there stays as it was. A link is followed. A
    file that may not be written is not replaced, although its folder may let it be.
    What is no ordinary file, such as a pipe, and what the process has open, as /dev/stdout and
    /dev/fd/3 name it, be it a file or not, gets the whole at its end: what writes it may read it
    again, or put another file into its place.

    Raises
    ------
    OSError
        The folder cannot be made, the file cannot be put into its place, or the block could not
        write it; `path` is its filename then.

    Examples
    --------
    >>> from pathlib import Path
    >>> with core.whole_file("cup.txt") as path:
    ...     _ = path.write_text("whole")
    >>> Path("cup.txt").read_text()
    'whole'
    """
    place = Path(os.path.realpath(path))
    stream = _stream(path)
    if stream is not None:
        with tempfile.TemporaryDirectory() as folder:
            partial = Path(folder, f"{PARTIAL}{os.getpid()}{Path(path).suffix}")
            with _named(path, partial):
                yield partial
                with open(partial, "rb") as whole, stream() as out:
                    shutil.copyfileobj(whole, out)
        return
    with _named(path, place):
        _refuse_protected(place)
    place.parent.mkdir(parents=True, exist_ok=True)
    # Short, as a name may be as long as the file system allows.
    name = f"{PARTIAL}{os.getpid()}-{secrets.token_hex(4)}{place.suffix[:16]}"
    partial = place.with_name(name)
    try:
        with _named(path, partial):
            yield partial
            if place.is_dir():
                raise IsADirectoryError(errno.EISDIR, "it is a folder", str(path))
            with open(partial, "rb+") as file:
                os.fsync(file.fileno())
            if place.exists():
                shutil.copymode(place, partial)
            replace(partial, place)
    except BaseException:
        with contextlib.suppress(OSError):
            partial.unlink()
        raise


def replace(made: Path, place: Path) -> None:
    """Put a file into the place of another on the same file system, unless that may not be written.

    Raises
    ------
    OSError
        It may not, or the system does not let it be.
    """
    _refuse_protected(place)
    os.replace(made, place)


def _refuse_protected(place: Path) -> None:
    """Unix asks for the folder alone where a file takes the place of another, and a file that the
    user has protected would be gone; Windows asks for the file."""
    if place.exists() and not os.access(place, os.W_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(place))


def _stream(path: Path | str) -> Callable[[], BinaryIO] | None:
    """Opens what the path names, if that is something that is written to from begin to end and
    cannot be put into a place; None if it is a file, or will be."""
    descriptor = _open_already(path)
    if descriptor is not None:
        return lambda: open(os.dup(descriptor), "wb")
    try:
        mode = os.stat(path).st_mode
    except (OSError, ValueError):
        return None
    if stat.S_ISREG(mode) or stat.S_ISDIR(mode):
        return None
    return lambda: open(path, "wb")


def _open_already(path: Path | str) -> int | None:
    """The number under which this process has open what the path names; None if it names a file."""
    names = [os.fspath(path)]
    if os.path.islink(path):
        # What lies behind such a name is the file again, so no further.
        names.append(os.path.join(os.path.dirname(path), os.readlink(path)))
    for name in names:
        found = re.fullmatch(r"/(?:dev|proc/(?:self|thread-self))/fd/(\d+)", name)
        if found:
            return int(found[1])
    return None


@contextlib.contextmanager
def _named(path: Path | str, partial: Path) -> Iterator[None]:
    """Errors of the system in it name the file, not the unfinished one that nobody knows."""
    try:
        yield
    except OSError as error:
        if error.filename in (None, str(partial)):
            raise OSError(error.errno, error.strerror, str(path)) from error
        raise
