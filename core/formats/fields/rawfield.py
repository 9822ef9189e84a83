"""`.rawfield`: all N vectors of each face's cross, as Directional reads and writes them.

N and the number of faces, then for each face x y z of its N vectors in anticlockwise order.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ...base.errors import FormatError
from ..text import check_count, counts_of, numbers_of, read_text, rows_of, write_text


def write_rawfield(path: Path | str, vectors: np.ndarray) -> None:
    """Write (m, N, 3) vectors.

    Raises
    ------
    FormatError
        The file cannot be written.
    """
    vectors = np.asarray(vectors, np.float64)
    count, symmetry = vectors.shape[:2]
    write_text(path, f"{symmetry} {count}\n" + rows_of(vectors.reshape(count, -1)))


def read_rawfield(path: Path | str) -> np.ndarray:
    """(m, N, 3) float64 vectors.

    Raises
    ------
    FormatError
        The file is not such a field.
    """
    words = read_text(path).split()
    symmetry, count = counts_of(path, words, 2)
    if symmetry == 0:
        raise FormatError(f"{path}: is a field of no vectors.")
    check_count(path, len(words) - 2, 3 * count * symmetry)
    return numbers_of(path, words[2:]).reshape(count, symmetry, 3)
