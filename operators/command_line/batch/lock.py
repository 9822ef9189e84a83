"""One batch at a time in a folder of results."""

from __future__ import annotations

import contextlib
import os
import platform
import sys
from collections.abc import Iterator
from pathlib import Path


class BusyError(Exception):
    """Another batch is at work; the text says which."""


@contextlib.contextmanager
def held(folder: Path, name: str) -> Iterator[None]:
    """Hold the lock of that name in a folder; the system lets go of it when the process ends.

    Raises
    ------
    BusyError
        Another process holds it, on this machine or another one.
    OSError
        The lock file cannot be made.
    """
    path = folder / f".umbilics-{name}.lock"
    while True:
        file = open(path, "a+", encoding="utf-8")  # noqa: SIM115 (closed below)
        try:
            if not _lock(file.fileno()):
                file.seek(0)
                raise BusyError(
                    f"{folder}: another batch is at work there ({file.read().strip() or 'unknown'})"
                    ". Wait for its end, or choose another folder for --out."
                )
            # Whoever held it has removed the file since it was opened here: lock the new one.
            if path.exists() and os.path.samestat(os.fstat(file.fileno()), path.stat()):
                break
            file.close()
        except BaseException:
            file.close()
            raise
    try:
        # On a full disk it holds as well without its words.
        with contextlib.suppress(OSError):
            os.ftruncate(file.fileno(), 0)
            os.write(file.fileno(), f"process {os.getpid()} on {platform.node()}\n".encode())
        yield
    finally:
        if os.name == "posix":
            # While it is still held, so that nobody's lock is removed.
            path.unlink(missing_ok=True)
        file.close()


def _lock(descriptor: int) -> bool:
    """Take the lock if it is free; a file system without locks has none that is taken."""
    if sys.platform == "win32":
        import msvcrt

        try:
            # Past the text, which others may want to read.
            os.lseek(descriptor, 1 << 20, os.SEEK_SET)
            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        except OSError:
            return False
        return True

    import fcntl

    try:
        # Unlike flock, this holds between machines that share the folder by NFS.
        fcntl.lockf(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except (BlockingIOError, PermissionError):
        return False
    except OSError:
        return True
    return True
