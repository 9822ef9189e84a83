"""Numbers as text, and back, for all the formats."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from ..base.errors import FormatError
from .whole import whole_file

# Seventeen digits bring every double back unchanged.
NUMBER = "%.17g"
# Rows that are put into words at a time.
ROWS = 5000


def write_text(path: Path | str, text: str | Iterable[str], encoding: str = "ascii") -> None:
    """Write text, or the pieces of one, with Unix line ends on every system; the file appears whole
    or not at all.

    Raises
    ------
    FormatError
        The file cannot be written.
    """
    try:
        with whole_file(path) as place, open(place, "w", encoding=encoding, newline="\n") as file:
            file.writelines([text] if isinstance(text, str) else text)
    except OSError as error:
        raise FormatError(f"{path}: cannot be written ({error.strerror}).") from error


def read_text(path: Path | str) -> str:
    """The text of a file.

    Raises
    ------
    FormatError
        The file cannot be read or is not text.
    """
    try:
        with open(path, encoding="utf-8-sig") as file:
            return file.read()
    except OSError as error:
        raise FormatError(f"{path}: cannot be read ({error.strerror}).") from error
    except UnicodeDecodeError as error:
        raise FormatError(f"{path}: is not a text file.") from error


def rows_of(values: np.ndarray, separator: str = " ") -> str:
    """A line for each row of (r, c) numbers; whole numbers stay whole."""
    values = np.asarray(values)
    if not values.size:
        return ""
    number = "%d" if values.dtype.kind in "iub" else NUMBER
    line = separator.join([number] * values.shape[1]) + "\n"
    # In one piece a window beside it would stand still: Python's lock is not let go in between.
    pieces = (values[first : first + ROWS] for first in range(0, len(values), ROWS))
    return "".join((line * len(piece)) % tuple(piece.ravel().tolist()) for piece in pieces)


def numbers_of(path: Path | str, words: list[str], dtype: type = float) -> np.ndarray:
    """(w,) words as numbers.

    Raises
    ------
    FormatError
        One of them is not a number.
    """
    try:
        return np.array(words, dtype=dtype)
    except (ValueError, OverflowError) as error:
        raise FormatError(f"{path}: holds something that is not a number.") from error


def counts_of(path: Path | str, words: list[str], expected: int) -> list[int]:
    """The whole numbers, none negative, that head a file.

    Raises
    ------
    FormatError
        There are too few, or they are not whole.
    """
    try:
        counts = [int(word) for word in words[:expected]]
    except ValueError as error:
        raise FormatError(f"{path}: does not begin with {expected} whole numbers.") from error
    if len(counts) < expected or min(counts, default=0) < 0:
        raise FormatError(f"{path}: does not begin with {expected} whole numbers.")
    return counts


def check_count(path: Path | str, found: int, expected: int) -> None:
    """Raise `FormatError` if a file holds more or fewer numbers than it says."""
    if found != expected:
        raise FormatError(f"{path}: holds {found} numbers where its head says {expected}.")
