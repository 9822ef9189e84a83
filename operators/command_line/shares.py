"""How much of the whole each of the works on one mesh is."""

from __future__ import annotations

from collections.abc import Sequence

from ... import core

# Roughly how long they take beside one another.
_LENGTHS = {"Detecting": 6, "Planning": 3, "Checking": 2, "Matching": 1}


class Parts:
    """The works on one mesh, in the order in which they are done."""

    def __init__(self, works: Sequence[str], progress: core.Progress) -> None:
        self._works = works
        self._progress = progress

    def begin(self, work: str) -> core.Progress:
        """The stretch of that work, which begins now."""
        place = self._works.index(work)
        return self._progress.part(work, self._share(place), self._share(place + 1))

    def _share(self, count: int) -> float:
        """Of the first so many works."""
        lengths = [_LENGTHS[work] for work in self._works]
        return sum(lengths[:count]) / sum(lengths)
