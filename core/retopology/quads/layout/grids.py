"""Quads from a layout and whole lengths: which vertices there are and how they join.

Vertices are numbered anew for nodes, insides of arcs and insides of rectangles, and merged where
arcs or whole rectangles have no length.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from .rectangles import Layout

# Violations of one kind that are cut at once.
AT_ONCE = 200


@dataclass(frozen=True)
class Grids:
    """The grids of all rectangles.

    Attributes
    ----------
    lengths:
        (a,) int64 quads along each arc.
    arc_vertices:
        For each arc its vertices along the track, both ends included.
    sides:
        For each rectangle the vertices of its four sides, anticlockwise.
    inside:
        (r,) int64 first vertex within each rectangle; row by row from the bottom.
    count:
        How many vertices there are before merging.
    quads:
        (q, 4) int64 corners before merging.
    patch:
        (q,) int64 rectangle of each quad.
    merged:
        (count,) int64 vertex that each is merged into; themselves where not.
    """

    lengths: np.ndarray
    arc_vertices: list[np.ndarray]
    sides: list[list[np.ndarray]]
    inside: np.ndarray
    count: int
    quads: np.ndarray
    patch: np.ndarray
    merged: np.ndarray
    joins: _Joins


@dataclass(frozen=True)
class _Joins:
    """Pairs of vertices that are one, and the arcs whose lengths, all 0, make them so."""

    pair: np.ndarray
    reason: np.ndarray
    reasons: list[tuple[int, ...]]

    def cause(self, one: int, other: int, count: int) -> frozenset[int]:
        """Arcs that make two vertices one."""
        graph = sparse.coo_array(
            (np.ones(len(self.pair)), (self.pair[:, 0], self.pair[:, 1])), shape=(count, count)
        ).tocsr()
        _, before = csgraph.breadth_first_order(graph, other, directed=False)
        arcs: set[int] = set()
        low, high = self.pair.min(axis=1), self.pair.max(axis=1)
        at = one
        while at != other:
            up = int(before[at])
            row = np.flatnonzero((low == min(at, up)) & (high == max(at, up)))[0]
            arcs.update(self.reasons[self.reason[row]])
            at = up
        return frozenset(arcs)


def grids(layout: Layout, lengths: np.ndarray) -> Grids:
    """The grids that whole lengths make of the rectangles of a layout."""
    count = len(layout.nodes)
    arc_vertices = []
    for (start, end), length in zip(layout.arc_node.tolist(), lengths.tolist(), strict=True):
        between = max(length - 1, 0)
        arc_vertices.append(np.concatenate([[start], np.arange(count, count + between), [end]]))
        count += between
    pairs: list[np.ndarray] = []
    reasons: list[np.ndarray] = []
    causes: list[tuple[int, ...]] = []

    def join(one: np.ndarray, two: np.ndarray, cause: tuple[int, ...]) -> None:
        pairs.append(np.column_stack([one, two]))
        reasons.append(np.full(len(one), len(causes)))
        causes.append(cause)

    for arc in np.flatnonzero(lengths == 0).tolist():
        join(arc_vertices[arc][:1], arc_vertices[arc][1:], (arc,))
    sides, inside, quads, patch = [], [], [], []
    for number, rectangle in enumerate(layout.rectangles):
        around = [_side(side, lengths, arc_vertices) for side in rectangle]
        sides.append(around)
        inside.append(count)
        bottom, right, top, left = around[0], around[1], around[2][::-1], around[3][::-1]
        width, height = len(bottom) - 1, len(right) - 1
        if width == 0:
            join(left, right, tuple(half // 2 for half in rectangle[0]))
        if height == 0:
            join(bottom, top, tuple(half // 2 for half in rectangle[1]))
        if width == 0 or height == 0:
            continue
        grid = np.empty((height + 1, width + 1), np.int64)
        grid[0], grid[-1], grid[:, 0], grid[:, -1] = bottom, top, left, right
        within = (width - 1) * (height - 1)
        grid[1:-1, 1:-1] = np.arange(count, count + within).reshape(height - 1, width - 1)
        count += within
        corners = grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]
        quads.append(np.stack(corners, axis=-1).reshape(-1, 4))
        patch.append(np.full(width * height, number))
    none = np.zeros((0, 2), np.int64)
    pair = np.concatenate([none, *pairs]).astype(np.int64)
    reason = np.concatenate([none[:, 0], *reasons]).astype(np.int64)
    graph = sparse.coo_array((np.ones(len(pair)), (pair[:, 0], pair[:, 1])), shape=(count, count))
    _, merged = csgraph.connected_components(graph, directed=False)
    return Grids(
        lengths,
        arc_vertices,
        sides,
        np.array(inside, np.int64),
        count,
        np.concatenate([np.zeros((0, 4), np.int64), *quads]),
        np.concatenate([none[:, 0], *patch]),
        merged.astype(np.int64),
        _Joins(pair, reason, causes),
    )


def _side(side: list[int], lengths: np.ndarray, arc_vertices: list[np.ndarray]) -> np.ndarray:
    """Vertices along a side; arcs without length add none."""
    first = arc_vertices[side[0] // 2]
    parts = [first[:1] if side[0] % 2 == 0 else first[-1:]]
    for half in side:
        if lengths[half // 2]:
            along = arc_vertices[half // 2]
            parts.append(along[1:] if half % 2 == 0 else along[-2::-1])
    return np.concatenate(parts)


def violations(layout: Layout, made: Grids) -> set[frozenset[int]]:
    """Sets of arcs of which one must have length, for what must not be merged.

    Two poles or ends of features must not meet, a pole and a feature, two features off their
    common ends, a feature and itself, nor two corners of a quad.
    """
    merged = made.merged
    pairs: list[tuple[int, int]] = []
    special = np.array([number for number, node in enumerate(layout.nodes) if node.vertex >= 0])
    group: dict[int, list[int]] = {}
    for node in special.tolist():
        group.setdefault(int(merged[node]), []).append(node)
    for nodes in group.values():
        pairs += [(nodes[0], other) for other in nodes[1:]]
    pairs += _feature_pairs(layout, made, group)
    corner = merged[made.quads]
    for one, two in ((0, 1), (1, 2), (2, 3), (3, 0), (0, 2), (1, 3)):
        same = np.flatnonzero(corner[:, one] == corner[:, two])[:AT_ONCE]
        pairs += [tuple(made.quads[row, [one, two]].tolist()) for row in same]
    found = {made.joins.cause(one, two, made.count) for one, two in pairs[: 3 * AT_ONCE]}
    return {cause for cause in found if cause}


def _feature_pairs(
    layout: Layout, made: Grids, group: dict[int, list[int]]
) -> list[tuple[int, int]]:
    """Pairs of vertices, merged, of which one or both lie on features they must not leave."""
    # Per merged vertex: the tracks of features in it, with a node and its place along the track.
    touching: dict[int, dict[int, tuple[int, int]]] = {}
    pairs: list[tuple[int, int]] = []
    passed: dict[int, int] = {}
    for arc, track in enumerate(layout.arc_track.tolist()):
        if not layout.tracks[track].feature:
            continue
        along = passed.get(track, 0)
        for node, place in zip(
            layout.arc_node[arc].tolist(), (along, along + int(made.lengths[arc])), strict=True
        ):
            there = touching.setdefault(int(made.merged[node]), {})
            before = there.setdefault(track, (node, place))
            if before[1] != place and not _closes(layout, track, before[0], node):
                pairs.append((before[0], node))
        passed[track] = along + int(made.lengths[arc])
    for vertex, tracks in touching.items():
        special = group.get(vertex, [])
        poles = [node for node in special if not layout.nodes[node].features]
        first = next(iter(tracks.values()))[0]
        pairs += [(first, pole) for pole in poles]
        own = {track for node in special for track in layout.nodes[node].features}
        ends = [node for node in special if layout.nodes[node].features]
        strangers = [node for track, (node, _) in tracks.items() if track not in own]
        anchor = ends[0] if ends else (strangers[0] if strangers else -1)
        pairs += [(anchor, node) for node in strangers if node != anchor]
    return pairs


def _closes(layout: Layout, track: int, one: int, other: int) -> bool:
    """Whether two nodes are the one where a closed feature starts and ends."""
    return one == other and layout.nodes[one].features.count(track) == 2
