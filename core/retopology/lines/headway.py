"""The bound on a trace, whatever the mesh: lines that get nowhere end.

Where the field goes round a vertex that it does not resolve, a line crosses the triangles around
it again and again, by next to nothing each time, and its length never comes to a limit.
"""

from __future__ import annotations

import numpy as np

from ...mesh.surface import Surface

# A chord shorter than this share of its triangle's least height is no headway. A line that passes
# a vertex so near crosses half of its triangles before it is out on the other side.
HEADWAY = 0.05
# Chords without headway that are looked at, where a vertex has more triangles than that: a line
# may end at the tip of such a fan.
MOST_IDLE = 256
# Chords to a triangle of the mesh that the longest line takes. Closed lines and lines of that
# length end before; a spiral so narrow says nothing more.
MOST_TURNS = 32


class Headway:
    """Tells of lines that are traced together which of them get nowhere.

    At least one chord in so many as a vertex has triangles is as long as `HEADWAY` of a height, so
    that the length bounds the number of chords; `MOST_TURNS` bounds it by the mesh alone.
    """

    def __init__(self, surface: Surface, lines: int) -> None:
        self._height = surface.least_height
        fan = int(np.diff(surface.neighbour_start).max(initial=0))
        self._patience = min(fan, MOST_IDLE)
        self._most = MOST_TURNS * len(surface.triangles)
        self._idle = np.zeros(lines, np.int64)
        self._steps = 0

    def lost(self, ids: np.ndarray, triangle: np.ndarray, length: np.ndarray) -> np.ndarray:
        """Which lines end, after their next chords.

        Parameters
        ----------
        ids:
            (r,) rows of the running lines.
        triangle, length:
            (r,) the triangles of their chords, and how long these are.

        Returns
        -------
        (r,) bool.
        """
        self._steps += 1
        if self._steps > self._most:
            return np.ones(len(ids), bool)
        idle = self._idle[ids]
        idle += 1
        idle[length >= HEADWAY * self._height[triangle]] = 0
        self._idle[ids] = idle
        return idle > self._patience
