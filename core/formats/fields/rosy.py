"""`.rosy`: one direction of a rotationally symmetric field for each face (QuadWild, VCGlib).

The number of faces, the number of directions in a full turn, then x y z for each face, in the
order of the mesh's faces. Some programs write a direction for each vertex under the same name;
QuadWild's reader takes the first number for the number of faces.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..text import check_count, counts_of, numbers_of, read_text, rows_of, write_text


def write_rosy(path: Path | str, direction: np.ndarray, symmetry: int = 4) -> None:
    """Write (m, 3) directions, one for each face.

    Raises
    ------
    FormatError
        The file cannot be written.
    """
    direction = np.asarray(direction, np.float64)
    write_text(path, f"{len(direction)}\n{symmetry}\n" + rows_of(direction))


def read_rosy(path: Path | str) -> tuple[np.ndarray, int]:
    """(m, 3) float64 directions and how many there are to a full turn.

    Raises
    ------
    FormatError
        The file is not such a field.
    """
    words = read_text(path).split()
    count, symmetry = counts_of(path, words, 2)
    check_count(path, len(words) - 2, 3 * count)
    return numbers_of(path, words[2:]).reshape(-1, 3), symmetry
