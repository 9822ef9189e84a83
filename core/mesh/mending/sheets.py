"""Sheets of triangles: wound alike, and taken apart where more than two meet.

After that every directed edge occurs once and the triangles around a vertex are one fan.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from ...base.words import counted
from ..half_edges import (
    HalfEdges,
    edge_keys,
    ends_of,
    fan_labels,
    following,
    has_pinched_vertex,
    link,
)


def separate(
    corners: np.ndarray, vertex_count: int, warnings: list[str]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Turn windings to agree and take sheets apart at edges that are not manifold.

    Returns
    -------
    kept, corners, source:
        Rows kept, their new corners, and the old vertex of each new one; every directed edge
        then occurs once.
    """
    _, first = np.unique(np.sort(corners, axis=1), axis=0, return_index=True)
    kept = np.sort(first)
    copies = len(corners) - len(kept)
    if copies:
        warnings.append(
            f"{counted(copies, 'duplicate triangle')} left out. Merge by Distance and Delete "
            "Loose mend this in the mesh."
        )
    corners = corners[kept]
    edge, count = _undirected_edges(corners, vertex_count)
    crowded = int(np.count_nonzero(count > 2))
    if crowded:
        warnings.append(
            f"{counted(crowded, 'edge')} with three or more triangles: the sheets that meet "
            "there were taken apart, and end at that edge where they do not go straight on."
        )
    corners = _oriented(corners, edge, count, warnings)
    source = np.arange(vertex_count)
    while True:
        corners, origin = _split_across(corners, len(source))
        source = source[origin]
        extra = _later_copies(corners, len(source))
        if not extra.any():
            return kept, corners, source
        # A slit of a single edge cannot be opened: its second triangle is given up.
        warnings.append(
            f"{counted(int(extra.sum()), 'triangle')} left out where sheets could not be told "
            "apart."
        )
        kept, corners = kept[~extra], corners[~extra]


def _undirected_edges(corners: np.ndarray, vertex_count: int) -> tuple[np.ndarray, np.ndarray]:
    """(3 m,) number of the undirected edge of each half-edge, and the half-edges on each."""
    keys = edge_keys(*ends_of(corners), vertex_count)
    _, edge, count = np.unique(keys, return_inverse=True, return_counts=True)
    return edge, count


def _pairs(edge: np.ndarray, usable: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The two half-edges on each edge that `usable` names (each such edge has exactly two)."""
    members = np.flatnonzero(usable[edge])
    members = members[np.argsort(edge[members], kind="stable")]
    return members[::2], members[1::2]


def _oriented(
    corners: np.ndarray, edge: np.ndarray, count: np.ndarray, warnings: list[str]
) -> np.ndarray:
    """Wind the triangles of each piece the way that most of them already are."""
    m = len(corners)
    first, second = _pairs(edge, count == 2)
    tails = corners.ravel()
    agree = tails[first] != tails[second]
    left, right = first // 3, second // 3
    # Each triangle stands twice, as it is and turned; two neighbours whose windings agree are
    # joined like with like. A piece is orientable when its two copies stay apart.
    shift = np.where(agree, 0, m)
    rows = np.concatenate([left, left + m])
    columns = np.concatenate([right + shift, right + m - shift])
    graph = sparse.coo_array((np.ones(len(rows)), (rows, columns)), shape=(2 * m, 2 * m))
    sheets, label = csgraph.connected_components(graph, directed=False)
    as_is, turned = label[:m], label[m:]
    votes = np.bincount(as_is, minlength=sheets)
    turn = (as_is != turned) & (
        (votes[turned] > votes[as_is]) | ((votes[turned] == votes[as_is]) & (turned < as_is))
    )
    flipped = int(turn.sum())
    if flipped:
        warnings.append(
            f"{counted(flipped, 'triangle')} wound against the others: turned for the analysis. "
            "Recalculate Outside mends this in the mesh."
        )
    if (as_is == turned).any():
        warnings.append(
            "A piece of the mesh is one-sided (like a Moebius strip): it was cut where its two "
            "sides meet, and its indices are not tied to its topology."
        )
    corners = corners.copy()
    corners[turn] = corners[turn][:, [0, 2, 1]]
    return corners


def _split_across(corners: np.ndarray, vertex_count: int) -> tuple[np.ndarray, np.ndarray]:
    """Give each fan of triangles, joined across edges with two consistent ones, its vertex."""
    edge, count = _undirected_edges(corners, vertex_count)
    first, second = _pairs(edge, count == 2)
    tails = corners.ravel()
    agree = tails[first] != tails[second]
    first, second = first[agree], second[agree]

    # Across a shared edge the tail of one half-edge is the head of the other.
    rows = np.concatenate([first, following(first)])
    columns = np.concatenate([following(second), second])
    size = corners.size
    graph = sparse.coo_array((np.ones(len(rows)), (rows, columns)), shape=(size, size))
    _, label = csgraph.connected_components(graph, directed=False)
    return _relabelled(corners, label)


def _relabelled(corners: np.ndarray, label: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """New corners (m, 3) numbered by label, in the order of their old vertices, and those."""
    old = corners.ravel()
    _, first, inverse = np.unique(label, return_index=True, return_inverse=True)
    order = np.argsort(old[first], kind="stable")
    rank = np.empty(len(order), np.int32)
    rank[order] = np.arange(len(order), dtype=np.int32)
    return rank[inverse].reshape(-1, 3), old[first][order].astype(np.int64)


def _later_copies(corners: np.ndarray, vertex_count: int) -> np.ndarray:
    """(m,) bool, triangles that hold a directed edge which an earlier triangle already has."""
    keys = corners.ravel().astype(np.int64) * vertex_count + corners[:, [1, 2, 0]].ravel()
    _, first = np.unique(keys, return_index=True)
    later = np.ones(len(keys), bool)
    later[first] = False
    return np.any(later.reshape(-1, 3), axis=1)


def linked(corners: np.ndarray, vertex_count: int) -> HalfEdges:
    """The half-edges of triangles that were made an oriented manifold before."""
    links = link(corners, vertex_count)
    assert links is not None
    return links


def split_fans(
    corners: np.ndarray, source: np.ndarray, links: HalfEdges, warnings: list[str]
) -> tuple[np.ndarray, np.ndarray, HalfEdges]:
    """Take pinched vertices, where several fans touch, apart; also drops unused vertices."""
    used = links.corner_count > 0
    is_pinched = has_pinched_vertex(corners, links)
    if not is_pinched and used.all():
        return corners, source, links
    if is_pinched:
        labels = fan_labels(links.twin)
        half_edges = np.arange(len(labels), dtype=labels.dtype)
        fans = int(np.count_nonzero((labels == half_edges) | (labels == half_edges - len(labels))))
        pinched = fans - int(np.count_nonzero(used))
        warnings.append(
            f"{counted(pinched, 'pinched vertex', 'pinched vertices')}: the sheets "
            "that touch there were taken apart."
        )
        corners, origin = _relabelled(corners, labels)
        source = source[origin]
        return corners, source, linked(corners, len(source))
    return without_unused(corners, source, links)


def without_unused(
    corners: np.ndarray, source: np.ndarray, links: HalfEdges
) -> tuple[np.ndarray, np.ndarray, HalfEdges]:
    """Drop vertices that no triangle has."""
    used = links.corner_count > 0
    rank = np.cumsum(used, dtype=np.int32) - np.int32(1)
    corners, source = rank[corners], source[used]
    return corners, source, linked(corners, len(source))
