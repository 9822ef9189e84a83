"""The layout of rectangles that the motorcycle graph makes: nodes, arcs and sides.

Its *nodes* are poles, corners and ends of features, and places where a track ends on another.
The *arcs* are the pieces of tracks between nodes; half-arc 2 a runs along the track, 2 a + 1 back.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise
from typing import NamedTuple

import numpy as np

Place = tuple[float, float]


class Segment(NamedTuple):
    """A stretch of a track in one triangle: places in its coordinates, distances along the track
    at its ends, and its direction in quarter turns."""

    triangle: int
    start: Place
    end: Place
    near: float
    far: float
    direction: int


class Visit(NamedTuple):
    """A node on a track. `key` orders them: the segment, the distance on it, and -1 for the
    track's start, 1 for its end. The ports lead forwards and backwards, -1 for none."""

    key: tuple[int, float, int]
    node: int
    forwards: int
    backwards: int


@dataclass
class Track:
    """A polyline in the map, straight and along an axis, through the triangles it crosses."""

    feature: bool
    border: bool = False
    segments: list[Segment] = field(default_factory=list)
    # The same on the other side of a feature; nothing on borders.
    back: list[Segment] = field(default_factory=list)
    # Half-edges of the surface that a feature runs along.
    chain: list[int] = field(default_factory=list)
    visits: list[Visit] = field(default_factory=list)
    length: float = 0.0


@dataclass
class Node:
    """Where tracks meet; `ports` of them leave anticlockwise, `quadrants[i]` right angles lie
    between ports i and i + 1, -1 outside of the surface."""

    triangle: int
    place: Place
    quadrants: list[int]
    # The vertex of the surface, -1 for a T.
    vertex: int
    # Tracks of the features that meet here.
    features: tuple[int, ...] = ()


@dataclass(frozen=True)
class Layout:
    """Rectangles that cover the surface.

    Attributes
    ----------
    tracks, nodes:
        See there.
    arc_track:
        (a,) int64 track of each arc.
    arc_start, arc_end:
        (a,) float64 distances along the track.
    arc_node:
        (a, 2) int64 nodes it starts and ends at.
    rectangles:
        For each rectangle its four sides, anticlockwise, as lists of half-arcs.
    """

    tracks: list[Track]
    nodes: list[Node]
    arc_track: np.ndarray
    arc_start: np.ndarray
    arc_end: np.ndarray
    arc_node: np.ndarray
    rectangles: list[list[list[int]]]

    @property
    def length(self) -> np.ndarray:
        """(a,) float64 lengths of the arcs, in lengths of quads."""
        return self.arc_end - self.arc_start


@dataclass(frozen=True)
class Fault:
    """Why tracks do not make rectangles: `loops` are the vertices (with the half-edge of the
    sector) whose side of a closed feature no track reaches; without any the map is at fault."""

    loops: tuple[tuple[int, int], ...] = ()


def rectangles_of(tracks: list[Track], nodes: list[Node], characteristic: int) -> Layout | Fault:
    """The layout of finished tracks on a connected surface of this Euler characteristic."""
    owner: list[int] = []
    start: list[float] = []
    end: list[float] = []
    ends: list[tuple[int, int]] = []
    # Half-arc that leaves each node by each port.
    leaving = [[-1] * len(node.quadrants) for node in nodes]
    for number, track in enumerate(tracks):
        for one, two in pairwise(sorted(track.visits, key=lambda visit: visit.key)):
            arc = len(owner)
            owner.append(number)
            start.append(_distance(track, one))
            end.append(_distance(track, two))
            ends.append((one.node, two.node))
            leaving[one.node][one.forwards] = 2 * arc
            leaving[two.node][two.backwards] = 2 * arc + 1
    if any(-1 in ports for ports in leaving):
        return Fault()
    at = {}
    for node, ports in enumerate(leaving):
        for port, half in enumerate(ports):
            at[half] = node, port
    if len(at) != 2 * len(owner):
        return Fault()
    faces, lonely = [], []
    seen = set()
    for first in range(2 * len(owner)):
        if first in seen:
            continue
        cycle, corners, half = [], [], first
        while half not in seen:
            seen.add(half)
            node, port = at[half ^ 1]
            port = (port - 1) % len(leaving[node])
            cycle.append(half)
            corners.append(nodes[node].quadrants[port])
            half = leaving[node][port]
        if -1 in corners:
            continue
        if not set(corners) <= {1, 2} or corners.count(1) not in (0, 4):
            return Fault()
        if 1 in corners:
            faces.append(_sides(cycle, corners))
        else:
            lonely += [at[half ^ 1] for half in cycle]
    if lonely:
        found = [(nodes[node].vertex, port) for node, port in lonely if nodes[node].vertex >= 0]
        return Fault(tuple((node, port - 1) for node, port in found))
    if len(nodes) - len(owner) + len(faces) != characteristic:
        return Fault()
    return Layout(
        tracks,
        nodes,
        np.array(owner),
        np.array(start),
        np.maximum(np.array(end), np.array(start)),
        np.array(ends).reshape(-1, 2),
        faces,
    )


def _distance(track: Track, visit: Visit) -> float:
    segment, way, _ = visit.key
    return track.segments[segment].near + way


def _sides(cycle: list[int], corners: list[int]) -> list[list[int]]:
    """The four sides of a rectangle; corner i lies at the end of half-arc i of its cycle."""
    begin = corners.index(1) + 1
    order = [(begin + step) % len(cycle) for step in range(len(cycle))]
    sides: list[list[int]] = [[]]
    for item in order:
        sides[-1].append(cycle[item])
        if corners[item] == 1 and len(sides) < 4:
            sides.append([])
    return sides
