"""Points of a surface in layers, from few and far between to all: each layer fills the gaps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

# Cells along the longest side in the first layer, and how many layers at most.
COARSEST = 8
MOST_LAYERS = 12
# Points looked at for each cell that is likely to be hit: with fewer some cells stay empty.
_TRIES = 10


@dataclass(frozen=True)
class Layers:
    """Rows of points, layer by layer.

    Attributes
    ----------
    rows:
        One array for each layer; together they hold every point once.
    cell:
        Distance between the points of the first layer; it halves from layer to layer.
    """

    rows: list[np.ndarray]
    cell: float


def layers(points: np.ndarray) -> Layers:
    """Divide (n, 3) points such that each layer with those before it is evenly spread.

    A layer takes one point of every cell of its grid that holds none yet. The order within a
    layer goes through space in blocks, so that neighbours in a layer are near each other.
    """
    count = len(points)
    low = points.min(axis=0) if count else np.zeros(3)
    extent = float(np.ptp(points, axis=0).max()) if count else 0.0
    if extent <= 0.0 or not np.isfinite(extent):
        return Layers([np.arange(count)], 1.0)
    cell = extent / COARSEST
    left = np.random.default_rng(0).permutation(count)
    scaled = (points - low) / cell
    taken = np.empty(0, dtype=np.int64)
    found = []
    for layer in range(MOST_LAYERS):
        # A surface meets some 3 * side ** 2 cells of a cube of side ** 3.
        likely = _TRIES * 3 * (COARSEST << layer) ** 2
        if layer == MOST_LAYERS - 1 or 2 * likely > 3 * _TRIES * count:
            break
        tried, rest = left[:likely], left[likely:]
        keys = _keys(scaled, np.concatenate([taken, tried]), layer)
        _, first = np.unique(keys, return_index=True)
        # Those already taken come first in the row: a cell of theirs is taken by them.
        fresh = np.sort(first[first >= len(taken)]) - len(taken)
        chosen = np.zeros(len(tried), dtype=bool)
        chosen[fresh] = True
        found.append(tried[chosen])
        taken = np.concatenate([taken, tried[chosen]])
        left = np.concatenate([tried[~chosen], rest])
    found.append(left)
    return Layers([_in_blocks(scaled, rows, layer) for layer, rows in enumerate(found)], cell)


def _keys(scaled: np.ndarray, rows: np.ndarray, layer: int) -> np.ndarray:
    """(r,) one number for the cell that each point lies in."""
    cells = (scaled[rows] * 2**layer).astype(np.int64)
    return cells[:, 0] << 42 | cells[:, 1] << 21 | cells[:, 2]


def _in_blocks(scaled: np.ndarray, rows: np.ndarray, layer: int) -> np.ndarray:
    """The rows in the order of blocks, each of some thousand cells of the surface."""
    return rows[np.argsort(_keys(scaled, rows, max(layer - 4, 0)), kind="stable")]
