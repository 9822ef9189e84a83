"""Files that go with those that are analysed: one for all, or a folder with one of each name."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

from ...base.errors import FileError
from .guard import shown


def files_of(path: Path, suffixes: Collection[str]) -> list[Path]:
    """The files that may be read: the file itself, or those of a folder with one of the endings."""
    if path.is_dir():
        return sorted(one for one in path.iterdir() if one.suffix.lower() in suffixes)
    return [path]


def identity_of(path: str | None, suffixes: Collection[str]) -> tuple[tuple[str, int, int], ...]:
    """What tells the files from another state of them."""
    if path is None:
        return ()
    known = [(one, one.stat()) for one in files_of(Path(path), suffixes) if one.is_file()]
    return tuple((str(one), status.st_size, status.st_mtime_ns) for one, status in known)


def companion_of(
    file: str, path: str, suffixes: Collection[str], option: str, words: tuple[str, str]
) -> Path:
    """The file that goes with `file`: `path`, or the one in that folder that is called like it.
    `words` are what is there: one, and several.

    Raises
    ------
    FileError
        None in the folder is, or several are.
    """
    chosen = Path(path)
    if not chosen.is_dir():
        return chosen
    alike = [one for one in files_of(chosen, suffixes) if one.stem == Path(file).stem]
    if len(alike) != 1:
        what = f"several {words[1]} are" if alike else f"no {words[0]} is"
        raise FileError(f"{shown(chosen)}: {what} called {Path(file).stem} there, for {option}.")
    return alike[0]
