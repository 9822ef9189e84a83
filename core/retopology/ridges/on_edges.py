"""Ridges on the edges of a mesh that lie nearest to them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from ..lines.edge_paths import edge_paths
from .ridge_lines import RidgeLines

NONE, RIDGE, RAVINE = range(3)


@dataclass(frozen=True)
class RidgeEdges:
    """What the e edges of a mesh have of its ridges.

    Attributes
    ----------
    kind:
        (e,) int64 `NONE`, `RIDGE` or `RAVINE`.
    bend:
        (e,) float64 degrees that the normal turns across the line there, 0 on other edges.
    strength:
        (e,) float64 size of the curvature across the line, in 1 / length, 0 on other edges.
    """

    kind: np.ndarray
    bend: np.ndarray
    strength: np.ndarray


def ridge_edges(vertices: np.ndarray, edges: np.ndarray, ridges: RidgeLines) -> RidgeEdges:
    """The edges (e, 2) of vertices (n, 3) that lead along ridges, connected as these are, each
    with the figures of the nearest point of a ridge.

    Examples
    --------
    On an ellipsoid of `vertices` and `triangles`, as in `detect`:

    >>> import numpy as np
    >>> guide = core.Guide(vertices, triangles, core.detect(vertices, triangles))
    >>> edges = np.unique(np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)), axis=0)
    >>> found = core.ridge_edges(vertices, edges, guide.ridges())
    >>> bool((found.kind == 1).any())
    True
    """
    vertices, edges = np.asarray(vertices, float), np.asarray(edges)
    on = np.flatnonzero(edge_paths(vertices, edges, ridges))
    found = RidgeEdges(np.zeros(len(edges), np.int64), np.zeros(len(edges)), np.zeros(len(edges)))
    if not len(on):
        return found
    _, point = cKDTree(ridges.position).query(vertices[edges[on]].mean(axis=1))
    family = np.repeat(ridges.family, np.diff(ridges.start))
    found.kind[on] = np.where(family[point] == 0, RIDGE, RAVINE)
    found.bend[on], found.strength[on] = ridges.bend[point], ridges.strength[point]
    return found
