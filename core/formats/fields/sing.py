"""`.sing`: the singular vertices of a face field, as Directional reads and writes them.

N and the number of singularities, then for each the vertex and N times its index, a whole
number. The sum of the latter is N times the Euler characteristic on a closed surface.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..text import check_count, counts_of, numbers_of, read_text, rows_of, write_text


def write_sing(
    path: Path | str, vertex: np.ndarray, multiple: np.ndarray, symmetry: int = 4
) -> None:
    """Write (s,) singular vertices and (s,) their indices times `symmetry`.

    Raises
    ------
    FormatError
        The file cannot be written.
    """
    rows = np.stack([np.asarray(vertex, np.int64), np.asarray(multiple, np.int64)], axis=1)
    write_text(path, f"{symmetry} {len(rows)}\n" + rows_of(rows))


def read_sing(path: Path | str) -> tuple[np.ndarray, np.ndarray, int]:
    """(s,) int64 vertices, (s,) int64 indices times N, and N.

    Raises
    ------
    FormatError
        The file is not a list of singularities.
    """
    words = read_text(path).split()
    symmetry, count = counts_of(path, words, 2)
    check_count(path, len(words) - 2, 2 * count)
    rows = numbers_of(path, words[2:], np.int64).reshape(-1, 2)
    return rows[:, 0], rows[:, 1], symmetry
