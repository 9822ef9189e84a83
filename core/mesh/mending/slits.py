"""Cuts along edges where more than two triangles meet, closed where both their sides are left."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from ...base.unit import unit
from ..half_edges import HalfEdges, ends_of, previous
from .sheets import linked, without_unused


def without_slits(
    corners: np.ndarray, vertices: np.ndarray, source: np.ndarray, links: HalfEdges
) -> tuple[np.ndarray, np.ndarray, HalfEdges]:
    """Close borders that go along an edge and come right back.

    What lies between is a hole without area; its two sides are joined from its end on, first where
    the sheet goes on straightest. That leaves the genus as it is. Where it would bring two edges
    together a border stays open.

    Parameters
    ----------
    corners, source, links:
        A manifold, and for each of its vertices the row among `vertices`.
    """
    slits = _slits(corners, vertices, source, links)
    tail, head = ends_of(corners)
    n = len(source)
    while slits:
        pairs = np.concatenate(slits)
        meeting = tail[pairs[:, 0]], head[pairs[:, 1]]
        graph = sparse.coo_array((np.ones(len(pairs)), meeting), shape=(n, n))
        joined = csgraph.connected_components(graph, directed=False)[1].astype(np.int64)
        edge, uses = np.unique(joined[tail] * n + joined[head], return_counts=True)
        twice = edge[uses > 1]
        twice = np.concatenate([twice // n, twice % n])
        sound = [some for some in slits if not np.isin(joined[tail[some[:, 0]]], twice).any()]
        if not len(twice) or len(sound) == len(slits):
            break
        slits = sound
    if not slits or len(twice):
        return corners, source, links
    _, first = np.unique(joined, return_index=True)
    corners = first.astype(corners.dtype)[joined][corners]
    return without_unused(corners, source, linked(corners, n))


def _slits(
    corners: np.ndarray, vertices: np.ndarray, source: np.ndarray, links: HalfEdges
) -> list[np.ndarray]:
    """The pairs (p, 2) of half-edges that lie on each other, border by border; the head of the
    first is where the second starts, or comes to lie there by pairs between."""
    tail, head = ends_of(corners)
    border = np.flatnonzero(links.twin < 0)
    leaving = np.full(len(source), -1)
    leaving[tail[border]] = border
    after = leaving[head[border]]
    back = np.flatnonzero(source[tail[border]] == source[head[after]])
    bend = _bend(corners, vertices[source], border[back], after[back])
    begin, end = source[tail].tolist(), source[head].tolist()
    onward = dict(zip(border.tolist(), after.tolist(), strict=True))
    seen: set[int] = set()
    found = []
    for first in border[back[np.argsort(bend, kind="stable")]].tolist():
        if first in seen:
            continue
        # Like brackets: what comes right back goes out with what it comes back along.
        left: list[int] = []
        pairs = []
        edge = first
        while edge not in seen:
            seen.add(edge)
            if left and begin[left[-1]] == end[edge]:
                pairs.append((left.pop(), edge))
            else:
                left.append(edge)
            edge = onward[edge]
        while len(left) > 1 and begin[left[-1]] == end[left[0]]:
            pairs.append((left.pop(), left.pop(0)))
        found.append(np.array(pairs))
    return found


def _bend(
    corners: np.ndarray, points: np.ndarray, one: np.ndarray, other: np.ndarray
) -> np.ndarray:
    """(e,) cosine between the triangles of two half-edges that lie on each other, seen along them:
    -1 where these go straight on."""
    start, end = (points[of] for of in ends_of(corners, one))
    along = unit(end - start)
    out = []
    for edge in (one, other):
        apex = points[corners.ravel()[previous(edge)]] - start
        out.append(unit(apex - np.einsum("ec,ec->e", apex, along)[:, None] * along))
    return np.einsum("ec,ec->e", *out)
