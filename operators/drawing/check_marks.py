"""Marks of a check: the valence on a disc where a vertex stands for a planned pole, on a diamond
where it is extra, and on a hexagon where a planned pole has none."""

from __future__ import annotations

from .poles import Badge, badges
from .shapes import Places, Shape

# Told apart by shape and lightness as well as by hue; by the rows of `data.topology.STATES`.
_LOOKS = (
    Badge(24, 0.75, (0.1, 0.55, 0.16), (1.0, 1.0, 1.0)),
    Badge(4, 0.95, (0.95, 0.75, 0.1), (0.02, 0.01, 0.0)),
    Badge(6, 0.9, (0.75, 0.05, 0.1), (1.0, 1.0, 1.0)),
)
# The one that is chosen in the table, in sizes of the others.
CHOSEN = 1.6


def marks(
    state: int, valences: list[int], places: Places, size: float, opacity: float
) -> list[Shape]:
    """The marks of one state at places whose U is the viewer's right and V is up."""
    return badges(_LOOKS[state], valences, places, size, opacity)
