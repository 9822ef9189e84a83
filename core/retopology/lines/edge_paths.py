"""Lines on a surface as paths along the edges of a mesh, for seams and sharp edges."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph
from scipy.spatial import cKDTree

from ...base.subsets import places_in
from .polylines import Lines

# Vertices farther from the line than this many of their edges are not passed.
CORRIDOR = 2.0
# A path is pinned to the line at as many places as keep it from taking short cuts.
PINS = 4


def edge_paths(vertices: np.ndarray, edges: np.ndarray, lines: Lines) -> np.ndarray:
    """(e,) bool, the edges along which the lines run best.

    Within a corridor around each line the shortest path is taken, where the length of an edge
    counts more the farther it lies from the line.

    Parameters
    ----------
    vertices:
        (n, 3) float64 positions, in the coordinates of the lines.
    edges:
        (e, 2) int vertices of each edge of the mesh, polygons' diagonals not among them. Those
        with an end that is no place are never chosen.

    Examples
    --------
    On an ellipsoid of `vertices` and `triangles`, as in `detect`:

    >>> import numpy as np
    >>> guide = core.Guide(vertices, triangles, core.detect(vertices, triangles))
    >>> edges = np.unique(np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)), axis=0)
    >>> chosen = core.edge_paths(vertices, edges, guide.separatrices())
    >>> chosen.shape == (len(edges),), bool(chosen.any())
    (True, True)
    """
    vertices = np.asarray(vertices, float)
    marked = np.zeros(len(edges), bool)
    if not len(edges):
        return marked
    edges = np.asarray(edges, np.int64)
    placed = np.isfinite(vertices).all(axis=1)[edges].all(axis=1)
    if not placed.all():
        marked[placed] = edge_paths(vertices, edges[placed], lines)
        return marked
    length = np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1)
    if not length.any():
        return marked
    longest = np.zeros(len(vertices))
    np.maximum.at(longest, edges.ravel(), np.repeat(length, 2))
    used = np.zeros(len(vertices), bool)
    used[edges] = True
    candidates = np.flatnonzero(used)
    tree = cKDTree(vertices[candidates])
    reach = CORRIDOR * float(longest.max())
    # Shorter edges are round-off of the longest.
    shortest = np.finfo(float).eps * float(longest.max())
    # Doubles leave edges without a length, which say nothing of how far points are to be apart.
    step = float(np.median(length[length > shortest]))
    for line in range(len(lines)):
        points = _dense(lines.points(line), step, lines.closed[line])
        near = tree.query_ball_point(points, reach)
        inside = candidates[np.unique(np.concatenate([np.asarray(one, int) for one in near]))]
        distance, _ = cKDTree(points).query(vertices[inside])
        close = distance <= CORRIDOR * longest[inside]
        inside, distance = inside[close], distance[close]
        if len(inside) < 2:
            continue
        ends = places_in(inside, len(vertices))[edges]
        rows = np.flatnonzero((ends >= 0).all(axis=1))
        one, two = ends[rows].T
        off = (distance[one] + distance[two]) / np.maximum(length[rows], shortest)
        # What costs nothing would be no edge of the graph.
        cost = np.maximum(length[rows] * (1.0 + off**2), np.finfo(float).tiny)
        pins = points[np.linspace(0, len(points) - 1, PINS).round().astype(int)]
        _, anchor = cKDTree(vertices[inside]).query(pins)
        marked[_path(one, two, cost, rows, len(inside), anchor)] = True
    return marked


def _dense(points: np.ndarray, step: float, closed: bool) -> np.ndarray:
    """Points no farther apart than about a step; a closed line comes back to its first."""
    if closed:
        points = np.concatenate([points, points[:1]])
    chord = np.linalg.norm(np.diff(points, axis=0), axis=1)
    arc = np.concatenate([[0.0], np.cumsum(chord)])
    count = int(np.ceil(arc[-1] / step)) + 1
    at = np.linspace(0.0, arc[-1], max(count, PINS))
    return np.stack([np.interp(at, arc, points[:, axis]) for axis in range(3)], axis=1)


def _path(
    one: np.ndarray,
    two: np.ndarray,
    cost: np.ndarray,
    rows: np.ndarray,
    count: int,
    anchor: np.ndarray,
) -> np.ndarray:
    """Edges `rows` on the cheapest path through the anchors in turn."""
    graph = sparse.csr_array((cost, (one, two)), shape=(count, count))
    name = sparse.csr_array((rows + 1, (one, two)), shape=(count, count))
    name = (name + name.T).tocsr()
    _, before = csgraph.dijkstra(
        graph, directed=False, indices=anchor[:-1], return_predecessors=True
    )
    found = []
    for leg, end in enumerate(anchor[1:]):
        vertex = end
        while before[leg, vertex] >= 0:
            found.append(int(name[vertex, before[leg, vertex]]) - 1)
            vertex = before[leg, vertex]
    return np.unique(np.array(found, np.int64))
