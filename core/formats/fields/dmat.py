"""`.dmat`: a matrix as libigl writes it.

The head is the number of columns, then of rows; the numbers follow one column after the other.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..text import check_count, counts_of, numbers_of, read_text, rows_of, write_text


def write_dmat(path: Path | str, matrix: np.ndarray) -> None:
    """Write a (rows, columns) matrix.

    Raises
    ------
    FormatError
        The file cannot be written.
    """
    matrix = np.asarray(matrix)
    rows, columns = matrix.shape
    write_text(path, f"{columns} {rows}\n" + rows_of(matrix.T.reshape(-1, 1)))


def read_dmat(path: Path | str) -> np.ndarray:
    """The (rows, columns) float64 matrix of a text file; the binary variant is not read.

    Raises
    ------
    FormatError
        The file is not such a matrix.
    """
    words = read_text(path).split()
    columns, rows = counts_of(path, words, 2)
    check_count(path, len(words) - 2, rows * columns)
    return numbers_of(path, words[2:]).reshape(columns, rows).T.copy()
