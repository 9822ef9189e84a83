"""Where the vertices of the grids lie on the surface: evenly in each rectangle of the map."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....base.subsets import places_in
from ..conformity import side_ends
from ..field.crosses import TURNS
from ..layout.grids import Grids
from ..layout.rectangles import Layout
from ..mapping.seamless_map import SeamlessMap
from ..mapping.walking import barycentric, walk


@dataclass(frozen=True)
class Placement:
    """Places of n merged vertices of the grids, renumbered without gaps.

    Attributes
    ----------
    quads:
        (q, 4) int64 corners.
    position:
        (n, 3) float64 points on the mapped surface.
    triangle:
        (n,) int64 its triangle at each of them.
    vertex:
        (n,) int64 vertex of the mapped surface that a pole or an end of features lies on, -1 for
        others.
    track:
        (n,) int64 track of the feature that the vertex lies on, -1 for none.
    beside:
        (n, 2) int64 vertices before and after it along that track, -1 for none.
    """

    quads: np.ndarray
    position: np.ndarray
    triangle: np.ndarray
    vertex: np.ndarray
    track: np.ndarray
    beside: np.ndarray


class _Places:
    """Triangles and places in the map, filled in for the vertices before merging."""

    def __init__(self, count: int) -> None:
        self.triangle = np.full(count, -1)
        self.place = np.zeros(count, complex)

    def put(self, vertex: np.ndarray, triangle: np.ndarray, place: np.ndarray) -> None:
        self.triangle[vertex] = triangle
        self.place[vertex] = place


def place(map_: SeamlessMap, layout: Layout, made: Grids) -> Placement:
    """The vertices of the grids on the surface."""
    places = _Places(made.count)
    track = np.full(made.count, -1)
    vertex = np.full(made.count, -1)
    nodes = np.arange(len(layout.nodes))
    places.put(
        nodes,
        np.array([node.triangle for node in layout.nodes]),
        np.array([complex(*node.place) for node in layout.nodes]),
    )
    vertex[nodes] = [node.vertex for node in layout.nodes]
    track[nodes] = [node.features[0] if node.features else -1 for node in layout.nodes]
    for arc, number in enumerate(layout.arc_track.tolist()):
        between = made.arc_vertices[arc][1:-1]
        if len(between):
            share = np.arange(1, len(between) + 1) / (len(between) + 1)
            start, end = layout.arc_start[arc], layout.arc_end[arc]
            found = _on_track(layout, number, start + share * (end - start), False)
            places.put(between, *found[:2])
            if layout.tracks[number].feature:
                track[between] = number
    _inside(map_, layout, made, places)
    return _merged(map_, layout, made, places, vertex, track)


def _on_track(
    layout: Layout, number: int, distance: np.ndarray, back: bool
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Triangle, place and direction of a track at distances along it.

    On a feature, `back` takes the triangles to its right."""
    track = layout.tracks[number]
    segments = track.back if back and track.feature else track.segments
    begin = np.array([segment[3] for segment in track.segments])
    item = np.clip(np.searchsorted(begin, distance, side="right") - 1, 0, len(begin) - 1)
    chosen = [segments[i] for i in item.tolist()]
    start = np.array([complex(*segment[1]) for segment in chosen])
    end = np.array([complex(*segment[2]) for segment in chosen])
    near = begin[item]
    length = np.array([segment[4] for segment in chosen]) - near
    share = np.divide(distance - near, length, out=np.zeros_like(near), where=length > 0)
    share = np.clip(share, 0.0, 1.0)
    triangle = np.array([segment[0] for segment in chosen])
    direction = np.array([segment[5] for segment in chosen])
    return triangle, start + share * (end - start), direction


def _coordinates(
    layout: Layout, made: Grids, side: list[int]
) -> tuple[np.ndarray, list[tuple[int, float]], float]:
    """Real coordinates of a side's vertices, the half-arc and place on it of each, its length."""
    at: list[float] = []
    along: list[tuple[int, float]] = []
    passed = 0.0
    for half in side:
        arc = half // 2
        length = layout.arc_end[arc] - layout.arc_start[arc]
        count = int(made.lengths[arc])
        first = 1 if at else 0
        for item in range(first, count + 1) if count else range(1 - first):
            offset = length * item / max(count, 1)
            at.append(passed + offset)
            along.append((half, offset))
        passed += length
    return np.array(at), along, passed


def _inside(map_: SeamlessMap, layout: Layout, made: Grids, places: _Places) -> None:
    """Place the insides of all rectangles, by walks from their left sides."""
    vertices, columns, rows, goals = ([] for _ in range(4))
    start_half: list[int] = []
    start_offset: list[float] = []
    start_y: list[float] = []
    for number, rectangle in enumerate(layout.rectangles):
        width, height = len(made.sides[number][0]) - 1, len(made.sides[number][1]) - 1
        if width < 2 or height < 2:
            continue
        bottom, _, wide = _coordinates(layout, made, rectangle[0])
        right, _, high = _coordinates(layout, made, rectangle[1])
        top = wide - _coordinates(layout, made, rectangle[2])[0][::-1]
        left, along, _ = _coordinates(layout, made, rectangle[3])
        left, along = high - left[::-1], along[::-1]
        i, j = np.arange(1, width), np.arange(1, height)
        across, up = i / width, (j / height)[:, None]
        x = bottom[i] * (1.0 - up) + top[i] * up
        y = left[j][:, None] * (1.0 - across) + right[j][:, None] * across
        first_row = len(start_half)
        start_half += [along[item][0] for item in j]
        start_offset += [along[item][1] for item in j]
        start_y += left[j].tolist()
        vertices.append(made.inside[number] + np.arange(x.size))
        columns.append(np.tile(i, height - 1))
        rows.append(np.repeat(first_row + np.arange(height - 1), width - 1))
        goals.append((x + 1j * y).ravel())
    if not vertices:
        return
    vertex, column, row_of, goal = map(np.concatenate, (vertices, columns, rows, goals))
    triangle, at, turn = _row_starts(layout, np.array(start_half), np.array(start_offset))
    origin = 1j * np.array(start_y)
    reached, reached_at = np.zeros(len(vertex), np.int64), np.zeros(len(vertex), complex)
    turned = np.zeros(len(vertex), np.int64)
    arrived = np.ones(len(vertex), bool)
    # A column is reached from the one whose number has its lowest bit cleared: walks are short,
    # and few rounds do.
    from_column = column & (column - 1)
    bits = np.array([value.bit_count() for value in range(int(column.max()) + 1)])[column]
    most = 4 * len(map_.place)
    for level in range(1, int(bits.max()) + 1):
        now = np.flatnonzero(bits == level)
        parent = now - (column[now] - from_column[now])
        edge = from_column[now] == 0
        parent = np.where(edge, 0, parent)
        row = row_of[now]
        begin = np.where(edge, triangle[row], reached[parent])
        begin_at = np.where(edge, at[row], reached_at[parent])
        by = np.where(edge, turn[row], turned[parent])
        step = goal[now] - np.where(edge, origin[row], goal[parent])
        end, end_at, more, fine = walk(map_, begin, begin_at, TURNS[by % 4] * step, most)
        reached[now], reached_at[now] = end, end_at
        turned[now] = by + more
        arrived[now] = fine & (edge | arrived[parent])
    places.put(vertex[arrived], reached[arrived], reached_at[arrived])


def _row_starts(
    layout: Layout, half: np.ndarray, offset: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Triangle, place and quarter turns of the rectangle's first axis at places on half-arcs of
    left sides, which run downwards."""
    triangle = np.zeros(len(half), np.int64)
    at = np.zeros(len(half), complex)
    turn = np.zeros(len(half), np.int64)
    arc, back = half // 2, half % 2 == 1
    distance = np.where(back, layout.arc_end[arc] - offset, layout.arc_start[arc] + offset)
    track = layout.arc_track[arc]
    order = np.lexsort((back, track))
    cuts = np.flatnonzero(np.diff(2 * track[order] + back[order])) + 1
    for rows in np.split(order, cuts):
        behind = bool(back[rows[0]])
        found = _on_track(layout, int(track[rows[0]]), distance[rows], behind)
        triangle[rows], at[rows] = found[:2]
        turn[rows] = found[2] + (3 if behind else 1)
    return triangle, at, turn


def _merged(
    map_: SeamlessMap,
    layout: Layout,
    made: Grids,
    places: _Places,
    vertex: np.ndarray,
    track: np.ndarray,
) -> Placement:
    """One place for vertices that are one: that of a pole or an end, else that on a feature."""
    used, corner = np.unique(made.merged[made.quads], return_inverse=True)
    owner = places_in(used, int(made.merged.max()) + 1)[made.merged]
    known = np.flatnonzero((owner >= 0) & (places.triangle >= 0))
    rank = np.where(vertex[known] >= 0, 0, np.where(track[known] >= 0, 1, 2))
    order = known[np.lexsort((known, rank, owner[known]))]
    found, first = np.unique(owner[order], return_index=True)
    chosen = np.full(len(used), -1)
    chosen[found] = order[first]
    has = chosen >= 0
    crosses = map_.crosses
    position = np.zeros((len(used), 3))
    triangle = np.zeros(len(used), np.int64)
    rows = chosen[has]
    triangle[has] = places.triangle[rows]
    weight = barycentric(map_, places.triangle[rows], places.place[rows])
    corners = crosses.vertices[crosses.triangles[places.triangle[rows]]]
    position[has] = np.einsum("pk,pkc->pc", weight, corners)
    quads = corner.reshape(-1, 4).astype(np.int64)
    _fill(quads, position, triangle, has)
    track = np.where(has, track[chosen], -1)
    beside = _beside(layout, made, owner, track)
    return Placement(quads, position, triangle, np.where(has, vertex[chosen], -1), track, beside)


def _beside(layout: Layout, made: Grids, owner: np.ndarray, track: np.ndarray) -> np.ndarray:
    """(n, 2) the vertices before and after each one along its feature."""
    beside = np.full((len(track), 2), -1)
    along: dict[int, list[np.ndarray]] = {}
    for arc, number in enumerate(layout.arc_track.tolist()):
        if layout.tracks[number].feature:
            along.setdefault(number, []).append(owner[made.arc_vertices[arc]])
    for number, parts in along.items():
        path = np.concatenate(parts)
        path = path[np.concatenate([[True], np.diff(path) != 0])]
        middle = np.flatnonzero(track[path[1:-1]] == number) + 1
        beside[path[middle], 0] = path[middle - 1]
        beside[path[middle], 1] = path[middle + 1]
    return beside


def _fill(quads: np.ndarray, position: np.ndarray, triangle: np.ndarray, has: np.ndarray) -> None:
    """Vertices without a place get the mean of their neighbours', in place."""
    has = has.copy()
    tail, head = side_ends(quads)
    tail, head = np.concatenate([tail, head]), np.concatenate([head, tail])
    while not has.all():
        rows = np.flatnonzero(~has[tail] & has[head])
        if not len(rows):
            return
        total = np.zeros_like(position)
        np.add.at(total, tail[rows], position[head[rows]])
        count = np.bincount(tail[rows], minlength=len(position))
        new = np.flatnonzero(count)
        position[new] = total[new] / count[new, None]
        triangle[tail[rows]] = triangle[head[rows]]
        has[new] = True
