"""Noise of shape operators that come without an error estimate, from how neighbours differ."""

from __future__ import annotations

import numpy as np

from ..base.parallel import run
from ..base.progress import Progress
from ..fields.transport import rotation
from ..mesh.surface import Surface
from .tolerances import DISCRETIZATION, FIELD_REACH, NEIGHBOUR_SHARE, SINGLE_PRECISION

# Directed edges per block: some ten arrays of this length at a time.
_BLOCK = 1 << 16


def field_noise(
    surface: Surface, k1: np.ndarray, k2: np.ndarray, d1: np.ndarray, normal: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Estimated standard error of the gap at each vertex, and the radius it was averaged over.

    The deviator at a vertex is compared with the mean of its neighbours', carried to it by the
    smallest rotations: what is smooth changes little, what is noise does not. Added to it is
    the error that a mesh of this fineness leaves in any curvature.

    Parameters
    ----------
    surface:
        The surface, n vertices.
    k1, k2:
        (n,) principal curvatures in the coordinates of the surface.
    d1, normal:
        (n, 3) unit first principal directions and normals.

    Returns
    -------
    noise, radius:
        (n,) float64, in 1 / length and length of the surface's coordinates.
    """
    n = len(surface.vertices)
    start, neighbours = surface.neighbour_start, surface.neighbours
    valence = np.diff(start)
    gap, lengths = k1 - k2, surface.ring_lengths
    direction = np.ascontiguousarray((d1 + 1j * np.cross(normal, d1)).T)
    difference, edge = np.empty(n), np.empty(n)
    # Whole fans to a block.
    ends = np.unique(np.searchsorted(start, np.arange(0, start[-1] + _BLOCK, _BLOCK)).clip(0, n))

    def block(part: int) -> None:
        rows = slice(ends[part], ends[part + 1])
        some = slice(start[rows.start], start[rows.stop])
        other, count = neighbours[some], valence[rows]
        own = np.repeat(direction[:, rows], count, axis=1)
        turned = rotation(own, direction.take(other, axis=1, mode="clip"))
        place = start[rows] - start[rows.start]
        mean = np.add.reduceat(gap.take(other, mode="clip") * turned * turned, place) / count
        difference[rows] = np.abs(gap[rows] - mean)
        edge[rows] = np.add.reduceat(lengths[some], place) / count

    run(block, range(len(ends) - 1), Progress())
    square = difference**2
    around = (np.add.reduceat(square[neighbours], start[:-1]) + square) / (valence + 1)
    largest = np.maximum(np.abs(k1), np.abs(k2))
    coarse = DISCRETIZATION * largest * (edge * largest) ** 2 + SINGLE_PRECISION * largest
    return NEIGHBOUR_SHARE * np.sqrt(around + coarse**2), FIELD_REACH * edge
