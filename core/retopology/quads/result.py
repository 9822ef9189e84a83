"""What the remeshing returns."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..poles import Poles


@dataclass(frozen=True)
class QuadMesh:
    """A mesh of n vertices and q quads on the surface of an input mesh.

    Attributes
    ----------
    vertices:
        (n, 3) float64 positions, in the coordinates of the input.
    quads:
        (q, 4) int64 corners, wound outwards like the input.
    pole:
        (n,) int64 row of the pole that the vertex is, -1 for none.
    pole_valence:
        (k,) int64 edges that meet at each pole.
    pole_umbilic:
        (k,) int64 row of the kept umbilic that it comes from, -1 for none.
    pole_confidence:
        (k,) float64 0 to 1, see `Poles`.
    border, feature:
        (n,) bool, True at vertices on an open border; on a crease or an edge marked sharp.
    patch:
        (q,) int64 rectangle of the layout that each quad belongs to.
    angle:
        (q,) float64 degrees from the quad's directions to the principal directions, 0 to 45; NaN
        where the surface has none.
    source_triangle:
        (n,) int64 input triangle near each vertex.
    planned:
        The poles that it was laid out with; pieces that no layout was found for have none. Which
        umbilics they come from is not told.
    warnings:
        Sentences about what was mended, dropped or smoothed.
    timings:
        Seconds spent in each stage, by name.
    """

    vertices: np.ndarray
    quads: np.ndarray
    pole: np.ndarray
    pole_valence: np.ndarray
    pole_umbilic: np.ndarray
    pole_confidence: np.ndarray
    border: np.ndarray
    feature: np.ndarray
    patch: np.ndarray
    angle: np.ndarray
    source_triangle: np.ndarray
    planned: Poles = field(default_factory=Poles.none)
    warnings: tuple[str, ...] = ()
    timings: dict[str, float] = field(default_factory=dict)

    @property
    def valence(self) -> np.ndarray:
        """(n,) int64 edges that meet at each vertex that is a pole, 0 at the others."""
        valence = np.zeros(len(self.vertices), np.int64)
        is_pole = self.pole >= 0
        valence[is_pole] = self.pole_valence[self.pole[is_pole]]
        return valence
