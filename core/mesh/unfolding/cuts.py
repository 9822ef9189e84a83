"""Cuts that open the charts of a surface to disks which conformal maps distort little.

A chart is first opened along shortest paths of a tree-cotree decomposition (Eppstein 2003,
Erickson & Whittlesey 2005). A conformal map of the disk that keeps the lengths of its border
scales the inside by exp(u), with u the solution of a Poisson equation for the curvature (Ben-Chen
et al. 2008, doi 10.1111/j.1467-8659.2008.01142.x). Where that is far from 1 a tip of the shape is
squeezed or spread: the cut is led there along the shortest path and u solved again, as geometry
images lead theirs to the worst stretch (Gu et al. 2002, doi 10.1145/566570.566589).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from ...base.factors import definite_factors
from ...base.progress import Progress
from ..half_edges import edge_keys, ends_of, inner_edges
from ..surface import Surface
from .charts import Charts, cut_along
from .cotangents import angles_and_cotangents

# Lengths that a map with isometric border scales more than so many times have the cut led to them.
MOST_SCALING = 3.0
# Each round leads the cut to the worst places at once; a hand needs two, a bunny four.
ROUNDS = 12


@dataclass(frozen=True)
class _Graph:
    """The edges of charts, those of their borders as good as without length.

    `lengths` (c, c) symmetric; `border` (c,) bool, vertices of a border; `chart` (c,).
    """

    lengths: sparse.csr_array
    border: np.ndarray
    chart: np.ndarray


def opened_to_disks(surface: Surface, charts: Charts, progress: Progress | None = None) -> Charts:
    """Charts cut further until each is a disk that scales lengths at most `MOST_SCALING` times.

    The cuts that are there stay; a disk that is flat enough is left as it is. The bound holds for
    a map with isometric border, unless `ROUNDS` rounds do not suffice.
    """
    progress = progress or Progress()
    progress.step(0.0)
    seam = charts.border.copy()
    _mark(surface, seam, _to_disks(surface, charts))
    charts = cut_along(surface, seam)
    for number in range(ROUNDS):
        progress.step((number + 1) / (ROUNDS + 1))
        graph = _graph(surface, charts)
        peaks = _peaks(graph, _scaling(surface, charts, graph.border))
        if not len(peaks):
            break
        towards = _shortest(graph, np.flatnonzero(graph.border))[1]
        _mark(surface, seam, _half_edges(charts, *_paths(towards, peaks)))
        charts = cut_along(surface, seam)
    return charts


def _mark(surface: Surface, seam: np.ndarray, half_edges: np.ndarray) -> None:
    """Mark both halves of the edges."""
    seam[half_edges] = True
    other = surface.twin[half_edges]
    seam[other[other >= 0]] = True


def _graph(surface: Surface, charts: Charts) -> _Graph:
    points = surface.vertices[charts.vertex]
    start, end = ends_of(charts.corners)
    length = np.linalg.norm(points[end] - points[start], axis=1)
    # Zeros would be read as no edge at all.
    least = 1e-9 * max(float(length.mean()), np.finfo(float).tiny)
    length = np.where(charts.border, least, np.maximum(length, least))
    count = len(charts.vertex)
    # Both directions, once each: the pairs of the two triangles at an inner edge are the same.
    key = np.concatenate([start * count + end, end * count + start])
    key, first = np.unique(key, return_index=True)
    lengths = sparse.csr_array(
        (np.tile(length, 2)[first], (key // count, key % count)), shape=(count, count)
    )
    on_border = np.zeros(count, bool)
    on_border[start[charts.border]] = on_border[end[charts.border]] = True
    return _Graph(lengths, on_border, charts.of_vertex)


def _shortest(graph: _Graph, sources: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(c,) distance to the nearest source, and the next vertex on the way there (negative at
    the sources)."""
    distance, towards, _ = csgraph.dijkstra(
        graph.lengths, indices=sources, min_only=True, return_predecessors=True
    )
    return distance, towards.astype(np.int64)


def _paths(towards: np.ndarray, starts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Ends of the edges that lead from the starts to the sources, each once."""
    seen = np.zeros(len(towards), bool)
    here = np.unique(starts)
    # All paths walk together; one that meets another ends there.
    while len(here):
        here = here[~seen[here] & (towards[here] >= 0)]
        seen[here] = True
        here = np.unique(towards[here])
    on_the_way = np.flatnonzero(seen)
    return on_the_way, towards[on_the_way]


def _half_edges(charts: Charts, one: np.ndarray, two: np.ndarray) -> np.ndarray:
    """A half-edge for each pair of neighbouring chart vertices."""
    count = len(charts.vertex)
    key = edge_keys(*ends_of(charts.corners), count)
    order = np.argsort(key, kind="stable")
    return order[np.searchsorted(key[order], edge_keys(one, two, count))]


def _to_disks(surface: Surface, charts: Charts) -> np.ndarray:
    """Half-edges along which every chart opens to a disk."""
    graph = _graph(surface, charts)
    root = _roots(graph)
    distance, towards = _shortest(graph, root)
    left = _left_by_trees(surface, charts, distance, towards)
    one, two = ends_of(charts.corners, left)
    on_border = np.flatnonzero(graph.border)
    starts = [one, two, on_border[np.unique(charts.loops[on_border], return_index=True)[1]]]
    # A closed chart without handles is slit along a longest way over it.
    opened = np.zeros(charts.count, bool)
    opened[graph.chart[np.concatenate(starts)]] = True
    order = np.lexsort((distance, graph.chart))
    last = np.cumsum(np.bincount(graph.chart, minlength=charts.count)) - 1
    starts.append(order[last][~opened])
    paths = _without_tails(graph, _paths(towards, np.concatenate(starts)), one, two, ~opened)
    return np.concatenate([left, _half_edges(charts, *paths)])


def _roots(graph: _Graph) -> np.ndarray:
    """A vertex of each chart: on its border, or at one end of a longest way over it."""
    count = int(graph.chart.max()) + 1
    last = np.cumsum(np.bincount(graph.chart, minlength=count)) - 1
    any_vertex = np.lexsort((graph.border, graph.chart))[last]
    distance, _ = _shortest(graph, any_vertex)
    far = np.lexsort((distance, graph.chart))[last]
    return np.where(graph.border[any_vertex], any_vertex, far)


def _left_by_trees(
    surface: Surface, charts: Charts, distance: np.ndarray, towards: np.ndarray
) -> np.ndarray:
    """Half-edges, one of each edge, in neither the tree of shortest paths nor a spanning tree of
    the triangles that crosses the edges farthest out: two for each handle of a chart."""
    corners = charts.corners
    inner = inner_edges(np.where(charts.border, -1, surface.twin))
    a, b = ends_of(corners, inner)
    in_tree = (towards[a] == b) | (towards[b] == a)
    points = surface.vertices[charts.vertex]
    loop = distance[a] + distance[b] + np.linalg.norm(points[a] - points[b], axis=1)
    # Least first in the spanning tree; paths only where triangles hang together by nothing else.
    cost = np.where(in_tree, 4.0, 2.0 - loop / loop.max(initial=np.finfo(float).tiny))
    m = len(corners)
    one, two = inner // 3, surface.twin[inner] // 3
    key = edge_keys(one, two, m)
    order = np.lexsort((cost, key))
    # Of two edges between the same triangles the cheaper one.
    order = order[np.concatenate([[True], np.diff(key[order]) > 0])] if len(order) else order
    # SciPy's graphs want narrow indices.
    pairs = (one[order].astype(np.int32), two[order].astype(np.int32))
    tree = csgraph.minimum_spanning_tree(sparse.csr_array((cost[order], pairs), shape=(m, m)))
    tree = tree.tocoo()
    kept = np.zeros(len(inner), bool)
    kept[order] = np.isin(key[order], edge_keys(tree.row, tree.col, m))
    return inner[~kept & ~in_tree]


def _without_tails(
    graph: _Graph,
    paths: tuple[np.ndarray, np.ndarray],
    one: np.ndarray,
    two: np.ndarray,
    slit: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """The paths without ends that lead nowhere, in charts that are not merely `slit`."""
    start, end = paths
    degree = np.bincount(np.concatenate([start, end, one, two]), minlength=len(graph.border))
    fixed = graph.border | slit[graph.chart]
    kept = np.ones(len(start), bool)
    at: dict[int, list[int]] = {}
    for row, (a, b) in enumerate(zip(start.tolist(), end.tolist(), strict=True)):
        at.setdefault(a, []).append(row)
        at.setdefault(b, []).append(row)
    stack = [v for v in at if degree[v] == 1 and not fixed[v]]
    while stack:
        vertex = stack.pop()
        for row in at[vertex]:
            if kept[row]:
                kept[row] = False
                other = int(start[row] + end[row]) - vertex
                degree[other] -= 1
                if degree[other] == 1 and not fixed[other]:
                    stack.append(other)
    return start[kept], end[kept]


def _scaling(surface: Surface, charts: Charts, border: np.ndarray) -> np.ndarray:
    """(c,) logarithm of the scale of a conformal map that keeps the lengths of the border."""
    angle, cotangent = angles_and_cotangents(surface.vertices, surface.triangles)
    count = len(charts.vertex)
    corners = charts.corners
    # The edge from corner k + 1 to k + 2 by the angle at k.
    a, b = np.roll(corners, -1, axis=1).ravel(), np.roll(corners, -2, axis=1).ravel()
    weight = 0.5 * cotangent.ravel()
    off = sparse.coo_array((weight, (a, b)), shape=(count, count))
    off = (off + off.T).tocsr()
    laplacian = sparse.diags_array(off.sum(axis=1)) - off
    defect = 2.0 * np.pi - np.bincount(corners.ravel(), angle.ravel(), minlength=count)
    inside = np.flatnonzero(~border)
    scaling = np.zeros(count)
    if not len(inside):
        return scaling
    matrix = laplacian.tocsr()[inside][:, inside].tocsc()
    # Vertices of triangles without area would have nothing on the diagonal.
    matrix = matrix + 1e-12 * sparse.eye_array(len(inside), format="csc")
    scaling[inside] = definite_factors(matrix).solve(-defect[inside])
    return scaling


def _peaks(graph: _Graph, scaling: np.ndarray) -> np.ndarray:
    """The worst vertex of each patch that is scaled too much."""
    size = np.abs(scaling)
    too_much = np.flatnonzero(size > np.log(MOST_SCALING))
    if not len(too_much):
        return too_much
    label = csgraph.connected_components(graph.lengths[too_much][:, too_much], directed=False)[1]
    order = np.lexsort((size[too_much], label))
    last = np.cumsum(np.bincount(label)) - 1
    return too_much[order[last]]
