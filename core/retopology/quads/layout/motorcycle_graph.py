"""The motorcycle graph of a seamless map (Eppstein, Goodrich, Kim & Tamstorf 2008,
10.1111/j.1467-8659.2008.01288.x).

From each pole a track leaves along each axis of the map; all advance alike, and each ends where it
meets one that was there before, or a feature. What they enclose are rectangles. Whether two tracks
cross within a triangle is told by the order of their ends around it alone.

Two that come towards each other on one line end together where they meet. That is no accident: all
lines along a closed feature are closed, and lead from a pole beside it back to that pole.
"""

from __future__ import annotations

import heapq

import numpy as np

from ....base.progress import Progress
from ..mapping.seamless_map import SeamlessMap
from .rectangles import Layout, Node, Place, Segment, Visit, rectangles_of
from .track_starts import TrackStarts

DX, DY = (1.0, 0.0, -1.0, 0.0), (0.0, 1.0, 0.0, -1.0)
# Tracks keep off vertices by this part of an edge.
OFF_VERTEX = 1e-12
# Tracks that enter a triangle by the place where another leaves it, but for so much of a side, and
# run the other way are on one line. Where they are, in a hand, it is the same number; of 13 other
# layouts of the benchmark's shapes none comes nearer than 8e-5.
ON_ONE_LINE = 1e-9
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
        starts = TrackStarts(map_, forced)
        self.x, self.y, self.twin = starts.x, starts.y, starts.twin
        self.matching = map_.seams.matching.tolist()
        self.feature = map_.crosses.feature.tolist()
        self.tracks, self.nodes, self.heap = starts.tracks, starts.nodes, starts.states
        self.on_feature = starts.on_feature
        # False where the map does not suit the features.
        self.sound = starts.sound
        self.chords: list[list[Chord]] = [[] for _ in range(len(map_.crosses.triangles))]
        # Tracks that another has met while they were still to advance.
        self.met: set[int] = set()

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
        if number in self.met:
            return
        track = self.tracks[number]
        start, end, entry, leaves, at, length = self._ahead(triangle, side, share, direction)
        towards = self._towards(triangle, entry, direction)
        if towards is not None and share is not None:
            self._end_together(number, towards, triangle, start)
            return
        leave = leaves + at
        hit = self._hit(triangle, entry, leave, start, direction, length)
        place, limit = len(track.segments), None
        if hit is not None:
            length, host, segment, span = hit
            end = start[0] + length * DX[direction], start[1] + length * DY[direction]
            limit = *span, span[0] < entry < span[1]
        self.chords[triangle].append((entry, leave, number, place, limit))
        before, track.length = track.length, track.length + length
        track.segments.append(Segment(triangle, start, end, before, track.length, direction))
        edge = 3 * triangle + leaves
        if hit is not None:
            self._end_on_track(number, host, segment, start, direction, end)
        elif self.feature[edge]:
            self._end_on_feature(number, edge, at, end)
        else:
            other = self.twin[edge]
            turned = (direction + self.matching[edge]) % 4
            state = (track.length, number, other // 3, other % 3, 1.0 - at, turned)
            heapq.heappush(self.heap, state)

    def _ahead(
        self, triangle: int, side: int, share: float | None, direction: int
    ) -> tuple[Place, Place, float, int, float, float]:
        """The way through a triangle that nothing stops: where it starts and ends, the place on the
        perimeter where it enters, the side and the share of it by which it leaves, its length."""
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
        return (px, py), (qx, qy), entry, leaves, at, length

    def _towards(self, triangle: int, entry: float, direction: int) -> int | None:
        """The track that is about to leave the triangle by the place at which another enters it."""
        for _, leave, host, segment, limit in self.chords[triangle]:
            if abs(leave - entry) > ON_ONE_LINE or limit is not None:
                continue
            segments = self.tracks[host].segments
            if segment == len(segments) - 1 and (segments[segment].direction - direction) % 4 == 2:
                return host
        return None

    def _hit(
        self,
        triangle: int,
        entry: float,
        leave: float,
        start: Place,
        direction: int,
        length: float,
    ) -> tuple[float, int, int, Span] | None:
        """The first chord of the triangle that is crossed: way to it, track, segment, its ends."""
        low, high = min(entry, leave), max(entry, leave)
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

    def _end_together(self, number: int, other: int, triangle: int, place: Place) -> None:
        """A node where two tracks meet on one line."""
        self.met.add(other)
        node = len(self.nodes)
        self.nodes.append(Node(triangle, place, [2, 2], -1))
        for port, ended in enumerate((number, other)):
            self.tracks[ended].visits.append(Visit(self._last(ended), node, -1, port))

    def _last(self, number: int) -> tuple[int, float, int]:
        """The key of a visit where a track ends."""
        segments = self.tracks[number].segments
        return len(segments) - 1, segments[-1].far - segments[-1].near, 1

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
        self.tracks[number].visits.append(Visit(self._last(number), node, -1, own))
