"""The motorcycle graph of a seamless map (Eppstein, Goodrich, Kim & Tamstorf 2008,
10.1111/j.1467-8659.2008.01288.x).

From each pole a track leaves along each axis of the map; all advance alike, and each ends where it
meets one that was there before, or a feature. What they enclose are rectangles. Whether two tracks
cross within a triangle is told by the order of their ends around it alone.
"""

from __future__ import annotations

import heapq
import math

import numpy as np

from ....base.progress import Progress
from ..field.crosses import QUARTER, fans
from ..mapping.seamless_map import SeamlessMap
from .feature_chains import Around, FeatureChains
from .rectangles import Layout, Node, Place, Segment, Track, Visit, rectangles_of

DX, DY = (1.0, 0.0, -1.0, 0.0), (0.0, 1.0, 0.0, -1.0)
# Tracks keep off vertices by this part of an edge.
OFF_VERTEX = 1e-12
# Steps from triangle to triangle that the tracks may take, for each triangle and port.
MOST_STEPS = 200
Span = tuple[float, float]
# The places on the perimeter of a triangle where a track enters and leaves it, the track and its
# segment; for one that ended here the chord it ended on, and whether it came from within that.
Chord = tuple[float, float, int, int, tuple[float, float, bool] | None]
# How often closed features without a track are given one.
ROUNDS = 20


def motorcycle_graph(map_: SeamlessMap, progress: Progress) -> Layout | None:
    """The layout that the tracks of an injective map make, None where the map is at fault."""
    forced: set[tuple[int, int]] = set()
    for _ in range(ROUNDS):
        tracks = _Tracks(map_, forced)
        if not tracks.sound or not tracks.run(progress):
            return None
        crosses = map_.crosses
        edges = (len(crosses.twin) + int(np.count_nonzero(crosses.twin < 0))) // 2
        characteristic = len(crosses.vertices) - edges + len(crosses.triangles)
        found = rectangles_of(tracks.tracks, tracks.nodes, characteristic)
        if isinstance(found, Layout):
            return found
        new = [item for item in found.loops if item not in forced]
        if not new:
            return None
        forced.add(new[0])
    return None


class _Tracks:
    """Tracks while they advance."""

    def __init__(self, map_: SeamlessMap, forced: set[tuple[int, int]]) -> None:
        crosses = map_.crosses
        self.crosses = crosses
        self.forced = forced
        self.x, self.y = map_.place.real.tolist(), map_.place.imag.tolist()
        self.twin = crosses.twin.tolist()
        self.matching = map_.seams.matching.tolist()
        self.feature = crosses.feature.tolist()
        self.head = crosses.head
        self.tail = crosses.tail
        out = np.roll(map_.place, -1, axis=1) - map_.place
        back = np.roll(map_.place, 1, axis=1) - map_.place
        self.angle = np.angle(back * out.conj()).ravel()
        self.leaves_at = np.angle(out).ravel()
        self.tracks: list[Track] = []
        self.nodes: list[Node] = []
        self.heap: list[tuple[float, int, int, int, float | None, int]] = []
        self.chords: list[list[Chord]] = [[] for _ in range(len(crosses.triangles))]
        self.on_feature: dict[int, tuple[int, int, bool, float]] = {}
        # False where the map does not suit the features.
        self.sound = True
        self._start()

    # Nodes and first tracks ---------------------------------------------------------------

    def _start(self) -> None:
        features = FeatureChains(self.crosses, self.angle)
        self.sound = features.sound
        ends = {vertex for vertex, around in features.around.items() if not around.straight}
        loops = features.closed(ends)
        node_of = {
            vertex: self._node(vertex, features.around[vertex].sectors[0].edge)
            for vertex in sorted(ends | loops)
        }
        outgoing = self._feature_tracks(features, node_of)
        for vertex, node in node_of.items():
            self._feature_node(node, features.around[vertex], outgoing, vertex in loops)
        poles = np.flatnonzero(self.crosses.singular)
        if not node_of and not len(poles):
            # A torus without a pole: any vertex starts four tracks.
            poles = self.tail[3 * (len(self.crosses.triangles) // 2)][None]
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
        done: set[int] = set()
        nodes = set(node_of)
        for vertex in node_of:
            for sector in features.around[vertex].sectors:
                edge = sector.edge
                if edge in done:
                    continue
                chain = features.chain(edge, nodes)
                number = len(self.tracks)
                track = Track(feature=True, border=self.twin[edge] < 0, chain=chain)
                for place, half in enumerate(chain):
                    triangle, side = divmod(half, 3)
                    start, end = self._side(triangle, side)
                    length = abs(end[0] - start[0]) + abs(end[1] - start[1])
                    stretch = track.length, track.length + length
                    track.segments.append(
                        Segment(triangle, start, end, *stretch, _axis(start, end))
                    )
                    self.on_feature[half] = number, place, True, length
                    other = self.twin[half]
                    if other >= 0:
                        beyond, side = divmod(other, 3)
                        end, start = self._side(beyond, side)
                        track.back.append(Segment(beyond, start, end, *stretch, _axis(start, end)))
                        self.on_feature[other] = number, place, False, length
                    track.length += length
                    done.add(half)
                    done.add(other)
                self.tracks.append(track)
                outgoing[edge] = number, True
                last = self.twin[chain[-1]]
                outgoing[last if last >= 0 else -1 - chain[-1]] = number, False
        return outgoing

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
            shoots = turns > 2 or (turns == 2 and (loop or (vertex, len(quadrants)) in self.forced))
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
        first = np.zeros(len(self.crosses.vertices), np.int64)
        first[self.tail] = np.arange(len(self.tail))
        none = np.zeros(len(self.twin), bool)
        corner, start = fans(self.crosses.twin, none, first[poles])
        for row, vertex in enumerate(poles.tolist()):
            around = corner[start[row] : start[row + 1]]
            node = self._node(vertex, int(around[0]))
            total = self.angle[around].sum()
            turns = int(np.rint(total / QUARTER))
            offset = -self.leaves_at[around[0]] % QUARTER
            at = offset + np.arange(turns) * QUARTER
            self._shoot(node, around, at, self.nodes[node].quadrants)

    def _shoot(
        self, node: int, corners: np.ndarray, angles: np.ndarray, quadrants: list[int]
    ) -> None:
        """Start a track at each of the angles from the first corner on; each adds a port."""
        passed = np.cumsum(self.angle[corners])
        for angle in angles:
            item = min(int(np.searchsorted(passed, angle, side="right")), len(corners) - 1)
            corner = int(corners[item])
            within = angle - (passed[item] - self.angle[corner])
            direction = int(np.rint((self.leaves_at[corner] + within) / QUARTER)) % 4
            track = Track(feature=False)
            track.visits.append(Visit((0, 0.0, -1), node, len(quadrants), -1))
            quadrants.append(1)
            number = len(self.tracks)
            self.tracks.append(track)
            triangle, side = divmod(corner, 3)
            heapq.heappush(self.heap, (0.0, number, triangle, side, None, direction))

    # Advancing ----------------------------------------------------------------------------

    def run(self, progress: Progress) -> bool:
        """Let all tracks advance until each has ended; whether they all did, and soundly."""
        ports = sum(not track.feature for track in self.tracks)
        left = MOST_STEPS * (len(self.chords) + 100) * max(1, min(ports, 50))
        while self.heap:
            left -= 1
            if left < 0 or not self.sound:
                return False
            if left % 4096 == 0:
                progress.step(0.5)
            self._advance(*heapq.heappop(self.heap)[1:])
        return self.sound

    def _advance(
        self, number: int, triangle: int, side: int, share: float | None, direction: int
    ) -> None:
        """Take a track through one triangle, from a corner (`share` None) or a place on a side."""
        track = self.tracks[number]
        x, y = self.x[triangle], self.y[triangle]
        dx, dy = DX[direction], DY[direction]
        one, two = (side + 1) % 3, (side + 2) % 3
        if share is None:
            px, py = x[side], y[side]
            leaves, entry = one, float(side)
        else:
            px = x[side] + share * (x[one] - x[side])
            py = y[side] + share * (y[one] - y[side])
            # Where the far corner lies to the left, the track leaves by the side on the right.
            left = (y[two] - py) * dx - (x[two] - px) * dy
            leaves, entry = (one if left > 0 else two), side + share
        end = (leaves + 1) % 3
        a = (y[leaves] - py) * dx - (x[leaves] - px) * dy
        b = (y[end] - py) * dx - (x[end] - px) * dy
        at = a / (a - b) if a != b else 0.5
        at = min(max(at, OFF_VERTEX), 1.0 - OFF_VERTEX)
        qx = x[leaves] + at * (x[end] - x[leaves])
        qy = y[leaves] + at * (y[end] - y[leaves])
        length = max((qx - px) * dx + (qy - py) * dy, 0.0)
        exit_ = leaves + at
        hit = self._hit(triangle, entry, exit_, (px, py), direction, length)
        place = len(track.segments)
        before = track.length
        if hit is not None:
            way, host, segment, span = hit
            end_at = px + way * dx, py + way * dy
            within = span[0] < entry < span[1]
            self.chords[triangle].append((entry, exit_, number, place, (*span, within)))
            track.length += way
            track.segments.append(
                Segment(triangle, (px, py), end_at, before, track.length, direction)
            )
            self._end_on_track(number, host, segment, (px, py), direction, end_at)
            return
        self.chords[triangle].append((entry, exit_, number, place, None))
        track.length += length
        track.segments.append(
            Segment(triangle, (px, py), (qx, qy), before, track.length, direction)
        )
        edge = 3 * triangle + leaves
        if self.feature[edge]:
            self._end_on_feature(number, edge, at, (qx, qy))
            return
        other = self.twin[edge]
        turned = (direction + self.matching[edge]) % 4
        state = (track.length, number, other // 3, other % 3, 1.0 - at, turned)
        heapq.heappush(self.heap, state)

    def _hit(
        self,
        triangle: int,
        entry: float,
        exit_: float,
        start: Place,
        direction: int,
        length: float,
    ) -> tuple[float, int, int, Span] | None:
        """The first chord of the triangle that is crossed: way to it, track, segment, its ends."""
        low, high = min(entry, exit_), max(entry, exit_)
        best = None
        for one, two, host, segment, limit in self.chords[triangle]:
            if (low < one < high) == (low < two < high):
                continue
            if one in (low, high) or two in (low, high):
                continue
            # A track that ended here holds only the part on its own side of its host.
            if limit is not None and (limit[0] < entry < limit[1]) != limit[2]:
                continue
            other = self.tracks[host].segments[segment]
            if (other.direction - direction) % 2 == 0:
                # Parallel tracks cannot cross: round-off has put them in the wrong order.
                self.sound = False
                continue
            way = (other[1][0] - start[0]) * DX[direction] + (other[1][1] - start[1]) * DY[
                direction
            ]
            way = min(max(way, 0.0), length)
            if best is None or way < best[0]:
                best = way, host, segment, (min(one, two), max(one, two))
        return best

    def _end_on_track(
        self,
        number: int,
        host: int,
        segment: int,
        start: Place,
        direction: int,
        place: Place,
    ) -> None:
        triangle, begin, _, near, far, heading = self.tracks[host].segments[segment]
        along = (start[0] - begin[0]) * DX[heading] + (start[1] - begin[1]) * DY[heading]
        along = min(max(along, 0.0), far - near)
        from_right = DX[heading] * DY[direction] - DY[heading] * DX[direction] > 0
        self._tee(number, host, (segment, along, 0), from_right, triangle, place, 2)

    def _end_on_feature(self, number: int, edge: int, share: float, place: Place) -> None:
        host, segment, forwards, length = self.on_feature[edge]
        along = (share if forwards else 1.0 - share) * length
        beyond = -1 if self.tracks[host].border else 2
        self._tee(number, host, (segment, along, 0), not forwards, edge // 3, place, beyond)

    def _tee(
        self,
        number: int,
        host: int,
        key: tuple[int, float, int],
        from_right: bool,
        triangle: int,
        place: Place,
        beyond: int,
    ) -> None:
        """A node where a track ends on another; `beyond` are the quadrants across from it."""
        node = len(self.nodes)
        quadrants = [beyond, 1, 1] if from_right else [1, 1, beyond]
        back, own = (1, 2) if from_right else (2, 1)
        feature = (host,) if self.tracks[host].feature else ()
        self.nodes.append(Node(triangle, place, quadrants, -1, feature))
        self.tracks[host].visits.append(Visit(key, node, 0, back))
        track = self.tracks[number]
        last = len(track.segments) - 1
        length = track.segments[last].far - track.segments[last].near
        track.visits.append(Visit((last, length, 1), node, -1, own))


def _axis(start: Place, end: Place) -> int:
    """The direction of a stretch along an axis, in quarter turns."""
    return round(math.atan2(end[1] - start[1], end[0] - start[0]) / QUARTER) % 4
