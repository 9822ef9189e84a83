"""How far points are from the open border of a surface."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from .half_edges import ends_of
from .surface import Surface

# Steps to the farthest border that counts, at most, and of an edge: more of them are shorter
# than the rounding of its coordinates.
FINEST, MOST_STEPS = 64, 2**40


def distance_to_border(
    surface: Surface, points: np.ndarray, step: float, farthest: float
) -> np.ndarray:
    """(k,) float64 straight distance from points (k, 3) to the border; infinite without one and
    above `farthest`.

    Edges of the border are followed in steps of at most `step`, so that the hull of scattered
    points, whose few edges are long, is a border all along; the result is too large by at most
    half of that. Only steps that come near a point are looked at: however long an edge, they
    are no more than the points ask for.
    """
    half_edges = np.flatnonzero(surface.twin < 0)
    if not len(half_edges) or not len(points):
        return np.full(len(points), np.inf)
    tails, heads = (surface.vertices[end] for end in ends_of(surface.triangles, half_edges))
    length = np.linalg.norm(heads - tails, axis=1)
    steps = np.ones(len(length))
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        np.fmax(steps, np.ceil(length / max(step, farthest / FINEST)), out=steps)
    steps = np.minimum(steps, MOST_STEPS).astype(np.int64)
    edge, place = _near(tails, heads, length, steps, points, farthest)
    if not len(edge):
        return np.full(len(points), np.inf)
    share = (place / steps[edge])[:, None]
    distance, _ = cKDTree((1 - share) * tails[edge] + share * heads[edge]).query(points)
    return np.where(distance <= farthest, distance, np.inf)


def _near(
    tails: np.ndarray,
    heads: np.ndarray,
    length: np.ndarray,
    steps: np.ndarray,
    points: np.ndarray,
    farthest: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Edge and number of the steps that may lie within `farthest` of a point.

    The steps of an edge are halved, and halves that no point is near to are left out.
    """
    edge, first, count = np.arange(len(steps)), np.zeros(len(steps), np.int64), steps
    tree = cKDTree(points)
    found = []
    while len(edge):
        single = count == 1
        found.append((edge[single], first[single]))
        edge, first, count = edge[~single], first[~single], count[~single]
        share = ((first + 0.5 * (count - 1)) / steps[edge])[:, None]
        distance, _ = tree.query((1 - share) * tails[edge] + share * heads[edge])
        near = distance <= farthest + 0.5 * (count - 1) / steps[edge] * length[edge]
        edge, first, count = edge[near], first[near], count[near]
        half = count // 2
        edge = np.concatenate([edge, edge])
        first = np.concatenate([first, first + half])
        count = np.concatenate([half, count - half])
    edges, firsts = (np.concatenate(part) for part in zip(*found, strict=True))
    return edges, firsts
