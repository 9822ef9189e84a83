"""Vertices thinned along the short sides of long thin triangles.

Rings of edges are as stretched as the triangles: two rings of a mesh that is 25 times finer one
way than the other are a strip, and nothing that is fitted to a strip knows how the surface bends
along its short side. Vertices that crowd along the short sides are gathered into cells until
none is much longer than wide; rings of cells are the neighbourhoods of an even mesh, at the cost
of one. It is the semicoarsening of multigrid methods for anisotropic grids (Mulder 1989,
https://doi.org/10.1016/0021-9991(89)90151-4).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from ..base.progress import Progress
from ..base.subsets import spans
from .surface import Surface

# Length over height of a long thin triangle, and the share of such around a vertex and its
# neighbours from which on its rings are a strip.
NEEDLE, MOST = 6.0, 0.75
# What a fit misses of a surface that turns by some angle along its long sides it takes, as much
# larger as they are longer, for bending along the short ones. Least product of the turn, in
# radians, and length over height: ellipsoids of 16 segments (0.4) keep their umbilics by rings
# where triangles are 6 times as long as high, and lose them at 12 (16 x 50, 16 x 100 rings).
BENT = 1.5
# Edges are drawn together that are shorter than this share of the longest at both of their ends.
# Cells as long as wide would be worse: a mesh is often denser where it bends more, and a share
# of a half moves the umbilics of those ellipsoids by 1, a quarter by 0.2 of their long edges.
# Confirmed on 400 x 16 and 200 x 16 segments with the poles on another axis.
SHORT = 0.25


@dataclass(frozen=True)
class Thinned:
    """Cells of vertices; all vertices that are not crowded are cells of their own.

    Attributes
    ----------
    crowded:
        (n,) bool, vertices among long thin triangles and others like them.
    cell:
        (n,) int64 cell of each vertex.
    seed:
        (c,) int64 vertex that stands for each cell, the one nearest to its middle.
    graph:
        (c, c) bool, whether an edge joins two cells.
    """

    crowded: np.ndarray
    cell: np.ndarray
    seed: np.ndarray
    graph: sparse.csr_array


def thinned(
    surface: Surface, normals: np.ndarray, crease_vertices: np.ndarray | None, progress: Progress
) -> Thinned | None:
    """The cells of a surface; None where no vertices are drawn together.

    Parameters
    ----------
    normals:
        (n, 3) unit vertex normals.
    crease_vertices:
        (n,) bool, vertices that stay cells of their own, or None.
    """
    crowded = _crowded(surface, normals)
    if crowded is None:
        return None
    free = crowded if crease_vertices is None else crowded & ~crease_vertices
    cell = _gathered(surface, free, progress)
    seed = _middles(surface.vertices, cell)
    if len(seed) == len(cell):
        return None
    low, high = _edges(surface)
    low, high = cell[low], cell[high]
    apart = low != high
    rows = np.concatenate([low[apart], high[apart]])
    columns = np.concatenate([high[apart], low[apart]])
    ones = np.ones(len(rows), bool)
    graph = sparse.coo_array((ones, (rows, columns)), shape=(len(seed), len(seed))).tocsr()
    return Thinned(crowded, cell, seed, graph)


def _crowded(surface: Surface, normals: np.ndarray) -> np.ndarray | None:
    """(n,) bool, vertices among long thin triangles; None without any."""
    _, area = surface.face_normal_area
    longest = np.maximum(np.maximum(*surface.side_squares[:2]), surface.side_squares[2])
    rows = np.flatnonzero(longest > 2.0 * NEEDLE * area)
    if not len(rows):
        return None
    # How far the normals turn along the longest side.
    side = surface.side_squares[:, rows].argmax(axis=0)
    tail = surface.triangles[rows, side]
    head = surface.triangles[rows, (side + 1) % 3]
    turn = np.linalg.norm(normals[tail] - normals[head], axis=1)
    needle = rows[turn * longest[rows] > 2.0 * BENT * area[rows]]
    n = len(surface.vertices)
    needles = np.bincount(surface.triangles[needle].ravel(), minlength=n)
    share = needles / np.bincount(surface.triangles.ravel(), minlength=n)
    crowded = (share >= MOST) & ~surface.border
    # A strip is more than some slivers, of which every mesh of scattered points has a few, and
    # more where it is steep.
    asked = np.flatnonzero(crowded)
    begin, valence = surface.neighbour_start[asked], np.diff(surface.neighbour_start)[asked]
    row = np.repeat(np.arange(len(asked)), valence)
    ring = surface.neighbours[spans(begin, valence)]
    beside = np.bincount(row, share[ring], len(asked))
    crowded[asked] = beside >= MOST * valence
    return crowded if crowded.any() else None


def _edges(surface: Surface) -> tuple[np.ndarray, np.ndarray]:
    """(e,), (e,) ends of the edges, the smaller number first."""
    owner = surface.owner
    once = owner < surface.neighbours
    return owner[once], surface.neighbours[once].astype(np.int64)


def _gathered(surface: Surface, free: np.ndarray, progress: Progress) -> np.ndarray:
    """(n,) cells, numbered from 0: pairs along the shortest edges of free ones become one, over
    and over, until no edge is short."""
    n = len(free)
    cell = np.arange(n)
    middle, weight = surface.vertices.copy(), np.ones(n)
    low, high = _edges(surface)
    near = free[low] | free[high]
    low, high = low[near], high[near]
    random = np.random.default_rng(0)
    while len(low):
        progress.ask()
        length = np.linalg.norm(middle[low] - middle[high], axis=1)
        longest = np.zeros(n)
        for end in (low, high):
            np.maximum.at(longest, end, length)
        short = length <= SHORT * np.minimum(longest[low], longest[high])
        short = np.flatnonzero(short & free[low] & free[high])
        if not len(short):
            break
        # An edge is drawn together that comes first at both of its ends. Among lengths that are
        # alike the order is random: ever longer edges in a row would go one by one.
        octave = np.frexp(length[short])[1]
        order = short[np.lexsort((random.random(len(short)), octave))]
        rank = np.full(n, len(order))
        for end in (low, high):
            np.minimum.at(rank, end[order], np.arange(len(order)))
        first = (rank[low[order]] == rank[high[order]]).nonzero()[0]
        kept, gone = low[order[first]], high[order[first]]
        total = weight[kept] + weight[gone]
        share = (weight[gone] / total)[:, None]
        middle[kept] += share * (middle[gone] - middle[kept])
        weight[kept] = total
        into = np.arange(n)
        into[gone] = kept
        cell = into[cell]
        low, high = into[low], into[high]
        low, high = np.minimum(low, high), np.maximum(low, high)
        keys = np.unique((low * n + high)[low != high])
        low, high = keys // n, keys % n
    return np.unique(cell, return_inverse=True)[1]


def _middles(points: np.ndarray, cell: np.ndarray) -> np.ndarray:
    """(c,) of the points (n, 3) in each cell the one nearest to their mean."""
    count = np.bincount(cell)
    mean = np.stack([np.bincount(cell, axis) for axis in points.T], axis=1) / count[:, None]
    away = np.linalg.norm(points - mean[cell], axis=1)
    order = np.lexsort((away, cell))
    return order[np.cumsum(count) - count]
