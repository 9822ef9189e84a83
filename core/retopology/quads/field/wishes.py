"""What the field of a layout, and the layout, should respect."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ....umbilics.result import Umbilics
from ...by_hand import Strokes, WantedPoles
from ..surface.subdivision import MARK_BIT


@dataclass(frozen=True)
class Wishes:
    """What a layout should respect on a working surface of n vertices and m triangles.

    Attributes
    ----------
    smoothness:
        Of the cross field, see `GuidanceSettings`.
    feature:
        (3 m,) int8 half-edges on features inside the surface, as in `Triangles`.
    size:
        (m,) float64 length of a quad's edge in each triangle.
    undirected:
        (m,) bool triangles where the curvature means nothing.
    avoided:
        (n,) bool vertices where no pole is wanted.
    mirror:
        (n,) bool vertices on the plane of symmetry.
    single, imaged:
        Whether it stays as it is where others are mirrored, and whether its image is on the input.
    umbilics, umbilic_row:
        Those kept on the surface, in its triangles, and the rows (u,) int64 that they have among
        all that were kept.
    strokes:
        Lines that the field is to run along, None for none.
    wanted:
        All the poles that there are to be, None where the field tells them.
    reach:
        Opposite poles cancel that are nearer than so many times what they always do.
    plain:
        (n,) bool vertices where corners get the number of quads that their angle is nearest to,
        whatever the field says; None for none.
    failed:
        (n,) bool vertices around which maps have failed so far, on which no pole is left; None for
        none.
    smoothed, dropped, unmarked:
        How many places were smoothed, creases left out and marks left out so far.
    """

    smoothness: float
    feature: np.ndarray
    size: np.ndarray
    undirected: np.ndarray
    avoided: np.ndarray
    mirror: np.ndarray
    umbilics: Umbilics
    umbilic_row: np.ndarray
    strokes: Strokes | None = None
    wanted: WantedPoles | None = None
    single: bool = False
    imaged: bool = False
    reach: float = 1.0
    plain: np.ndarray | None = None
    failed: np.ndarray | None = None
    smoothed: int = 0
    dropped: int = 0
    unmarked: int = 0

    def without(self, edges: np.ndarray) -> Wishes:
        """Without one feature, whose half-edges are given as (3 m,) bool."""
        marked = bool((self.feature[edges] & MARK_BIT).any())
        return replace(
            self,
            feature=np.where(edges, np.int8(0), self.feature),
            dropped=self.dropped + (not marked),
            unmarked=self.unmarked + marked,
        )
