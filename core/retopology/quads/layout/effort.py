"""How much is tried before a surface is given up, counted in work and not in seconds: a slow
machine tries as much as a fast one."""

from __future__ import annotations

# What may be tried beyond the first attempt of each piece, as triangles times fields and maps made
# on them: so much, and so many times what the first attempts take. A unit is about 60 microseconds.
ANYWAY, MORE = 120_000, 2.0
# Fields and maps that a first attempt makes.
FIRST = 2
# Fields that take as long as evening out once (the dragon of 11,000 triangles at 1,500 quads).
EVENING = 4


class Effort:
    """What is left to be tried on all pieces together.

    Parameters
    ----------
    triangles:
        Of all pieces.
    """

    def __init__(self, triangles: int) -> None:
        self._left = ANYWAY + MORE * FIRST * triangles

    @property
    def left(self) -> bool:
        """Whether more may be tried."""
        return self._left > 0.0

    def spend(self, triangles: int) -> None:
        """A field or a map was made on so many triangles."""
        self._left -= triangles
