"""No input is overwritten, and no result by another: every path is claimed before it is written."""

from __future__ import annotations

import os
import stat
import unicodedata
from collections.abc import Iterable

from ...base.errors import FileError


class OverwriteError(FileError):
    """A result would take the place of an input or of another result."""


def folded(path: str) -> str:
    """The same text for all paths that some file system does not tell apart."""
    return unicodedata.normalize("NFC", unicodedata.normalize("NFC", path).casefold())


class Guard:
    """The paths that a command reads and writes.

    Paths are the same if they lead to the same file through links, or differ only in upper and
    lower case or in how accents are composed: some file systems do not tell these apart.
    """

    def __init__(self) -> None:
        self._read: dict[object, str] = {}
        self._written: dict[object, str] = {}
        self._folders: dict[str, str] = {}

    def reads(self, paths: Iterable[os.PathLike[str] | str]) -> None:
        """Files that are read; results may be claimed already.

        Raises
        ------
        OverwriteError
            A result that was claimed would overwrite one of them.
        """
        for path in paths:
            for key in self._keys(path):
                if key in self._written:
                    raise OverwriteError(
                        f"{self._written[key]} would overwrite {shown(path)}, which is read. "
                        "Choose another name or folder for the results."
                    )
                self._read.setdefault(key, shown(path))

    def writes(self, path: os.PathLike[str] | str) -> None:
        """Claim the path of a result.

        Raises
        ------
        OverwriteError
            It is a file that is read, or another result.
        """
        keys = self.spares_inputs(path)
        for key in keys:
            if key in self._written:
                raise OverwriteError(
                    f"{shown(path)} would be written twice: two results have the same name."
                )
        for key in keys:
            self._written[key] = shown(path)

    def spares_inputs(self, path: os.PathLike[str] | str) -> list[object]:
        """What tells the path of a result from others; claims nothing.

        Raises
        ------
        OverwriteError
            It is a file that is read.
        """
        keys = self._keys(path)
        for key in keys:
            if key in self._read:
                raise OverwriteError(
                    f"{shown(path)} would overwrite {self._read[key]}, which is read. "
                    "Choose another name or folder for the results."
                )
        return keys

    def _keys(self, path: os.PathLike[str] | str) -> list[object]:
        """What tells files apart: the real path, and for a file that exists its place on the disk.

        Nothing for what is no file, such as a pipe: nothing is lost by writing there.
        """
        try:
            found = os.stat(path)
        except (OSError, ValueError):
            found = None
        if found is not None and not (stat.S_ISREG(found.st_mode) or stat.S_ISDIR(found.st_mode)):
            return []
        path = os.path.join(os.getcwd(), path)
        folder, name = os.path.split(path)
        if os.path.islink(path) or name in ("", ".", ".."):
            real = os.path.realpath(path)
        else:
            # Thousands of files share their folder.
            if folder not in self._folders:
                self._folders[folder] = os.path.realpath(folder)
            real = os.path.join(self._folders[folder], name)
        keys: list[object] = [folded(real)]
        if found is not None and stat.S_ISREG(found.st_mode) and found.st_ino:
            keys.append((found.st_dev, found.st_ino))
        return keys


def shown(path: os.PathLike[str] | str) -> str:
    """A path as text that can be encoded and printed on one line, whatever bytes are in it."""
    text = os.fsencode(path).decode("utf-8", "backslashreplace")
    return "".join(
        letter if letter.isprintable() else letter.encode("unicode_escape").decode()
        for letter in text
    )
