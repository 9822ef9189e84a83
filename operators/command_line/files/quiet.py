"""What Blender itself prints, kept away from the command's own lines."""

from __future__ import annotations

import contextlib
import ctypes
import os
import sys
from collections.abc import Callable, Iterator
from tempfile import TemporaryFile


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """Nobody hears it."""
    with open(os.devnull, "wb") as nowhere, _going_to(nowhere.fileno()):
        yield


@contextlib.contextmanager
def overheard() -> Iterator[Callable[[], bytes]]:
    """Only who asks hears what has been printed so far."""
    with TemporaryFile() as file:

        def said() -> bytes:
            file.seek(0)
            return file.read()

        with _going_to(file.fileno()):
            yield said


@contextlib.contextmanager
def _going_to(target: int) -> Iterator[None]:
    """What is printed goes to another descriptor."""
    _flush()
    kept = os.dup(1), os.dup(2)
    os.dup2(target, 1)
    os.dup2(target, 2)
    try:
        yield
    finally:
        _flush()
        for number, copy in zip((1, 2), kept, strict=True):
            os.dup2(copy, number)
            os.close(copy)


def _flush() -> None:
    """Write out what Python and Blender hold back: it would come when others have the stream."""
    sys.stdout.flush()
    sys.stderr.flush()
    # Windows has the streams of its C library elsewhere.
    with contextlib.suppress(OSError):
        ctypes.CDLL("ucrtbase" if sys.platform == "win32" else None).fflush(None)
