"""`.sharp`: feature edges, as QuadWild reads and writes them.

The number of features, then for each `type,face,edge`: type 0 concave, 1 convex; edge k runs from
corner k of the face to the next. QuadWild's own files list an edge from both of its faces; its
reader marks both sides for either.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..text import check_count, counts_of, numbers_of, read_text, rows_of, write_text


def write_sharp(path: Path | str, convex: np.ndarray, face: np.ndarray, edge: np.ndarray) -> None:
    """Write (e,) bool convex, (e,) faces and (e,) edges 0 to 2.

    Raises
    ------
    FormatError
        The file cannot be written.
    """
    rows = np.stack([np.asarray(one).astype(np.int64) for one in (convex, face, edge)], axis=1)
    write_text(path, f"{len(rows)}\n" + rows_of(rows, ","))


def read_sharp(path: Path | str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(e,) bool convex, (e,) int64 faces, (e,) int64 edges.

    Raises
    ------
    FormatError
        The file is not a list of features.
    """
    words = read_text(path).replace(",", " ").split()
    (count,) = counts_of(path, words, 1)
    check_count(path, len(words) - 1, 3 * count)
    rows = numbers_of(path, words[1:], np.int64).reshape(-1, 3)
    return rows[:, 0] != 0, rows[:, 1], rows[:, 2]
