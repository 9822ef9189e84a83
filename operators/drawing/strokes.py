"""Fields of directions as strokes: read from the mesh, arranged in layers, drawn in blocks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .layers import layers
from .shapes import SOFT, Places, Shape, repeated, strips

# A direction counts fully where the gap is this part of its median, and nothing at a fifth of it.
_CLEAR_GAP = 0.3
# Strokes drawn or left out together; smaller blocks of a layer fit a close view better.
_BLOCK = 2048
# Half the length of a stroke, in distances between strokes.
_STROKE = 0.42


@dataclass(frozen=True)
class Strokes:
    """Directions at the vertices, in layers from few to all.

    Attributes
    ----------
    places, d1, d2:
        (n, 3) float32 in the object's space, in the order of the layers.
    weight:
        (n,) float32 from 0, where a direction means nothing, to 1.
    blocks:
        Rows (first, end, layer) of points that lie near each other.
    sphere:
        (blocks, 4) float32 centre and radius of each.
    cell:
        Distance between the points of the first layer; it halves from layer to layer.
    """

    places: np.ndarray
    d1: np.ndarray
    d2: np.ndarray
    weight: np.ndarray
    blocks: np.ndarray
    sphere: np.ndarray
    cell: float


def arranged(places: np.ndarray, d1: np.ndarray, d2: np.ndarray, gap: np.ndarray) -> Strokes:
    """Arrange what was read; touches arrays only, so that any thread may do it."""
    known = np.flatnonzero(d1.any(axis=1))
    layered = layers(places[known])
    order = known[np.concatenate(layered.rows)]
    # A gap of exactly 0 says that there is no direction.
    told = gap[known][gap[known] > 0.0]
    typical = float(np.median(told)) if len(told) else 0.0
    ratio = gap[order] / (_CLEAR_GAP * typical) if typical > 0.0 else np.zeros(len(order))
    weight = np.clip((ratio - 0.2) / 0.8, 0.0, 1.0)
    blocks, first = [], 0
    for layer, rows in enumerate(layered.rows):
        for start in range(0, len(rows), _BLOCK):
            end = min(start + _BLOCK, len(rows))
            blocks.append((first + start, first + end, layer))
        first += len(rows)
    places = places[order].astype(np.float32)
    spheres = np.zeros((len(blocks), 4), np.float32)
    for row, (start, end, _) in enumerate(blocks):
        low, high = places[start:end].min(axis=0), places[start:end].max(axis=0)
        spheres[row, :3] = 0.5 * (low + high)
        spheres[row, 3] = 0.5 * np.linalg.norm(high - low)
    return Strokes(
        places,
        d1[order],
        d2[order],
        (weight * weight * (3.0 - 2.0 * weight)).astype(np.float32),
        np.array(blocks, dtype=np.int64).reshape(-1, 3),
        spheres,
        layered.cell,
    )


def shape_of(
    found: Strokes, block: int, second: bool, width: float, colour: tuple[float, ...]
) -> Shape:
    """The strokes of one block, one unit long; the shader is told how long that is."""
    first, end, _ = found.blocks[block]
    rows = slice(int(first), int(end))
    along, across = found.d1[rows], found.d2[rows]
    if second:
        along, across = across, along
    half = 0.5 * width + SOFT
    corners = np.array([(x, 0, 0, y) for y in (-half, 0, half) for x in (-_STROKE, _STROKE)])
    colours = np.tile(np.array(colour, np.float32), (end - first, 1))
    colours[:, 3] *= found.weight[rows]
    places = Places(found.places[rows], along, across)
    return repeated(places, corners, colours, strips(3, 2), (0, 0, 1, 1, 0, 0))
