"""Where the tracks of a motorcycle graph begin: at the nodes of features, which are tracks laid
from the outset, and at poles, along each axis of the map.
"""

from __future__ import annotations

import heapq
import math

import numpy as np

from ....base.plane import corner_angles
from ..field.crosses import QUARTER, fans
from ..mapping.seamless_map import SeamlessMap
from .feature_chains import Around, FeatureChains
from .rectangles import Node, Place, Segment, Track, Visit

# A track on its way: its length, its number, the triangle and the side or corner by which it
# enters, the place on the side (None: from the corner) and its direction in quarter turns.
State = tuple[float, int, int, int, float | None, int]


class TrackStarts:
    """Tracks before any of them has advanced.

    Parameters
    ----------
    forced:
        (vertex, sector) of straight features that a track leaves all the same.

    Attributes
    ----------
    tracks, nodes:
        Those of features are whole, of the others only the start is known.
    states:
        A heap of the tracks that are to advance, the shortest first.
    on_feature:
        For each half-edge on a feature the track along it, its segment there, whether it runs the
        same way, and the length in the map.
    x, y, twin:
        The places of the corners of each triangle in the map and the twins of its half-edges, as
        lists, which are read one by one faster than arrays.
    sound:
        False where the map does not suit the features.
    """

    def __init__(self, map_: SeamlessMap, forced: set[tuple[int, int]]) -> None:
        crosses = map_.crosses
        self.tracks: list[Track] = []
        self.nodes: list[Node] = []
        self.states: list[State] = []
        self.on_feature: dict[int, tuple[int, int, bool, float]] = {}
        self._crosses = crosses
        self._forced = forced
        self.x, self.y = map_.place.real.tolist(), map_.place.imag.tolist()
        self.twin = crosses.twin.tolist()
        out = np.roll(map_.place, -1, axis=1) - map_.place
        self._angle = corner_angles(map_.place)
        self._leaves_at = np.angle(out).ravel()
        features = FeatureChains(crosses, self._angle)
        self.sound = features.sound
        self._start(features)

    def _start(self, features: FeatureChains) -> None:
        ends = {vertex for vertex, around in features.around.items() if not around.straight}
        loops = features.closed(ends)
        node_of = {
            vertex: self._node(vertex, features.around[vertex].sectors[0].edge)
            for vertex in sorted(ends | loops)
        }
        outgoing = self._feature_tracks(features, node_of)
        for vertex, node in node_of.items():
            self._feature_node(node, features.around[vertex], outgoing, vertex in loops)
        poles = np.flatnonzero(self._crosses.singular)
        if not node_of and not len(poles):
            # A torus without a pole: any vertex starts four tracks.
            poles = self._crosses.tail[3 * (len(self._crosses.triangles) // 2)][None]
        self._poles(poles)

    def _node(self, vertex: int, corner: int) -> int:
        triangle, side = divmod(corner, 3)
        place = self.x[triangle][side], self.y[triangle][side]
        self.nodes.append(Node(triangle, place, [], vertex))
        return len(self.nodes) - 1

    def _feature_tracks(
        self, features: FeatureChains, node_of: dict[int, int]
    ) -> dict[int, tuple[int, bool]]:
        """Lay the features as tracks; (track, forwards) for each half-edge that leaves a node,
        and for -1 - (half-edge) that reaches one along a border."""
        outgoing: dict[int, tuple[int, bool]] = {}
        nodes = set(node_of)
        for vertex in node_of:
            for sector in features.around[vertex].sectors:
                edge = sector.edge
                if edge in self.on_feature:
                    continue
                chain = features.chain(edge, nodes)
                number = self._lay(chain)
                outgoing[edge] = number, True
                last = self.twin[chain[-1]]
                outgoing[last if last >= 0 else -1 - chain[-1]] = number, False
        return outgoing

    def _lay(self, chain: list[int]) -> int:
        """The number of a new track along half-edges of a feature, on both sides of it."""
        number = len(self.tracks)
        track = Track(feature=True, border=self.twin[chain[0]] < 0, chain=chain)
        for place, half in enumerate(chain):
            triangle, side = divmod(half, 3)
            start, end = self._side(triangle, side)
            length = abs(end[0] - start[0]) + abs(end[1] - start[1])
            stretch = track.length, track.length + length
            track.segments.append(Segment(triangle, start, end, *stretch, _axis(start, end)))
            self.on_feature[half] = number, place, True, length
            other = self.twin[half]
            if other >= 0:
                beyond, side = divmod(other, 3)
                end, start = self._side(beyond, side)
                track.back.append(Segment(beyond, start, end, *stretch, _axis(start, end)))
                self.on_feature[other] = number, place, False, length
            track.length += length
        self.tracks.append(track)
        return number

    def _side(self, triangle: int, side: int) -> tuple[Place, Place]:
        x, y, end = self.x[triangle], self.y[triangle], (side + 1) % 3
        return (x[side], y[side]), (x[end], y[end])

    def _feature_node(
        self, node: int, around: Around, outgoing: dict[int, tuple[int, bool]], loop: bool
    ) -> None:
        """Ports and quadrants of a node on features, and the tracks that leave it."""
        vertex = self.nodes[node].vertex
        quadrants = self.nodes[node].quadrants
        touched = []

        def along(name: int) -> None:
            number, forwards = outgoing[name]
            track = self.tracks[number]
            touched.append(number)
            last = len(track.segments) - 1
            port = len(quadrants)
            if forwards:
                track.visits.append(Visit((0, 0.0, -1), node, port, -1))
            else:
                length = track.segments[last].far - track.segments[last].near
                track.visits.append(Visit((last, length, 1), node, -1, port))

        for sector in around.sectors:
            along(sector.edge)
            turns = sector.turns
            forced = loop or (vertex, len(quadrants)) in self._forced
            shoots = turns > 2 or (turns == 2 and forced)
            if not shoots:
                quadrants.append(turns)
                continue
            quadrants.append(1)
            at = np.arange(1, turns) * QUARTER
            self._shoot(node, sector.corners, at, quadrants)
        if around.opened:
            along(-1 - around.sectors[-1].last)
            quadrants.append(-1)
        self.nodes[node].features = tuple(touched)

    def _poles(self, poles: np.ndarray) -> None:
        if not len(poles):
            return
        first = np.zeros(len(self._crosses.vertices), np.int64)
        first[self._crosses.tail] = np.arange(len(self._crosses.tail))
        none = np.zeros(len(self.twin), bool)
        corner, start = fans(self._crosses.twin, none, first[poles])
        for row, vertex in enumerate(poles.tolist()):
            around = corner[start[row] : start[row + 1]]
            node = self._node(vertex, int(around[0]))
            total = self._angle[around].sum()
            turns = int(np.rint(total / QUARTER))
            offset = -self._leaves_at[around[0]] % QUARTER
            at = offset + np.arange(turns) * QUARTER
            self._shoot(node, around, at, self.nodes[node].quadrants)

    def _shoot(
        self, node: int, corners: np.ndarray, angles: np.ndarray, quadrants: list[int]
    ) -> None:
        """Start a track at each of the angles from the first corner on; each adds a port."""
        passed = np.cumsum(self._angle[corners])
        for angle in angles:
            item = min(int(np.searchsorted(passed, angle, side="right")), len(corners) - 1)
            corner = int(corners[item])
            within = angle - (passed[item] - self._angle[corner])
            direction = int(np.rint((self._leaves_at[corner] + within) / QUARTER)) % 4
            track = Track(feature=False)
            track.visits.append(Visit((0, 0.0, -1), node, len(quadrants), -1))
            quadrants.append(1)
            number = len(self.tracks)
            self.tracks.append(track)
            triangle, side = divmod(corner, 3)
            heapq.heappush(self.states, (0.0, number, triangle, side, None, direction))


def _axis(start: Place, end: Place) -> int:
    """The direction of a stretch along an axis, in quarter turns."""
    return round(math.atan2(end[1] - start[1], end[0] - start[0]) / QUARTER) % 4
