"""How far points are from the open border of a surface."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from .surface import Surface


def distance_to_border(surface: Surface, points: np.ndarray, step: float) -> np.ndarray:
    """(k,) float64 straight distance from points (k, 3) to the border; infinite without one.

    Edges of the border are followed in steps of at most `step`, so that the hull of scattered
    points, whose few edges are long, is a border all along; the result is too large by at most
    half of that.
    """
    half_edges = np.flatnonzero(surface.twin < 0)
    if not len(half_edges) or not len(points):
        return np.full(len(points), np.inf)
    tails = surface.vertices[surface.triangles.ravel()[half_edges]]
    heads = surface.vertices[surface.triangles[:, [1, 2, 0]].ravel()[half_edges]]
    pieces = np.ceil(np.linalg.norm(heads - tails, axis=1) / step).astype(np.int64)
    pieces = np.maximum(pieces, 1)
    edge = np.repeat(np.arange(len(pieces)), pieces)
    place = np.arange(len(edge)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    share = (place / pieces[edge])[:, None]
    distance, _ = cKDTree((1 - share) * tails[edge] + share * heads[edge]).query(points)
    return distance
