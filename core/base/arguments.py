"""Arrays that a caller hands over, in the right type, or a sentence on what is wrong with them.

NumPy takes a list of rows for a mask, -1 for the last row and a complex number for its real part;
what it refuses it refuses deep inside, in words for whoever wrote that place.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .errors import InvalidMeshError


def numbers(values: Any, sentence: str) -> np.ndarray:
    """Values of any shape as float64.

    Raises
    ------
    InvalidMeshError
        With the sentence: they are no real numbers, or their rows differ in length.
    """
    try:
        found = np.asarray(values)
        if found.dtype.kind in "cmM":
            raise TypeError(found.dtype)
        return np.asarray(found, np.float64)
    except (TypeError, ValueError) as error:
        raise InvalidMeshError(sentence) from error


def whole_numbers(values: Any, sentence: str) -> np.ndarray:
    """Values of any shape as whole numbers; an empty list, of whatever type, is none of them.

    Raises
    ------
    InvalidMeshError
        With the sentence: they are no whole numbers, or their rows differ in length.
    """
    try:
        found = np.asarray(values)
    except ValueError as error:
        raise InvalidMeshError(sentence) from error
    if found.size and found.dtype.kind not in "iu":
        raise InvalidMeshError(sentence)
    return found


def vertex_pairs(pairs: Any, count: int, what: str) -> np.ndarray | None:
    """Edges (s, 2) int64 of a mesh with `count` vertices; None stays None.

    Raises
    ------
    InvalidMeshError
        They are no pairs of its vertices.
    """
    if pairs is None:
        return None
    found = whole_numbers(pairs, f"The {what} must be whole numbers: rows of the vertices.")
    if not found.size:
        return np.zeros((0, 2), np.int64)
    if found.ndim != 2 or found.shape[1] != 2:
        raise InvalidMeshError(f"The {what} must have shape (s, 2), not {found.shape}.")
    in_range(found, count, what)
    return found.astype(np.int64)


def in_range(rows: np.ndarray, count: int, what: str) -> None:
    """Raise `InvalidMeshError` where rows name vertices that there are not."""
    low, high = int(rows.min()), int(rows.max())
    if low < 0 or high >= count:
        raise InvalidMeshError(f"The {what} name vertices {low} to {high}, but there are {count}.")


def flags(values: Any, count: int, what: str) -> np.ndarray | None:
    """(count,) bool, one for each vertex; None stays None.

    Raises
    ------
    InvalidMeshError
        They are of another length or type.
    """
    if values is None:
        return None
    found = np.asarray(values)
    if found.shape != (count,) or found.dtype != bool:
        raise InvalidMeshError(f"The {what} must be true or false for each of {count} vertices.")
    return found
