"""Whether a mesh suits the fits that a detection rests on: fine enough, and smooth.

A jet is a height function over the tangent plane. That of a sphere of radius R is a power series
in r/R that converges for r < R only: where the neighbourhoods are wider than the radius of
curvature, no polynomial in r describes the surface, however well it fits its few vertices.

On a smooth surface, sampled as densely as a fit needs, hardly any edge is sharp, and there are
many more edges that bend a little. Where most edges are flat and the sharp ones outnumber those
that only bend, the surface is made of smooth parts that meet at creases, and no fit should reach
across them; where most edges are sharp there are no smooth parts, but too few triangles.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base.arguments import vertex_pairs
from ..mesh.creases import are_few
from ..mesh.half_edges import edge_keys, ends_of
from .result import UNRESOLVED, Detection

# Turn of the surface within a neighbourhood, in radians, from which on it is coarse: see above.
COARSE = 1.0
# Degrees from which an edge bends, and from which it is sharp: a third of the crease angle of the
# preset for hard surfaces, and that angle. Chosen on cubes, cylinders, Suzanne, fandisk, Spot's
# cage and the bunny; confirmed on a wing nut (hard), a teapot and a chair (coarse), and on
# rocker-arm, Spot, the hand, the beetle, the face, a torso and MakeHuman's base (neither).
_BENT, SHARP = 10.0, 30.0


@dataclass(frozen=True)
class Suitability:
    """How a mesh suits a detection.

    Attributes
    ----------
    turn:
        Median over the vertices of larger curvature times radius of the neighbourhoods, in
        radians; NaN where nothing was fitted.
    edges, sharp, bent:
        Numbers of the edges between two triangles, of those at which they meet at more than 30°,
        and of those at 10° to 30°.
    crossed:
        How many of the sharp edges the detection fitted across.
    few:
        Whether a piece has too few vertices to tell its umbilics apart.
    """

    turn: float
    edges: int
    sharp: int
    bent: int
    crossed: int
    few: bool = False

    @property
    def is_hard(self) -> bool:
        """Whether it is made of smooth parts that meet at sharp edges."""
        are_flat = 2 * (self.sharp + self.bent) < self.edges
        return are_flat and self.sharp > self.bent

    @property
    def is_smeared(self) -> bool:
        """Whether it is hard, and the detection did not heed its creases."""
        return self.is_hard and self.crossed > self.bent

    @property
    def is_coarse(self) -> bool:
        """Whether its triangles are too large for the fits."""
        if self.few:
            return True
        if self.is_hard:
            # Fits across the creases are wide and curved; that says nothing of the parts between.
            return False
        return self.turn >= COARSE or 2 * self.sharp > self.edges


def suitability(
    vertices: np.ndarray,
    triangles: np.ndarray,
    detection: Detection,
    marked: np.ndarray | None = None,
) -> Suitability:
    """How vertices (n, 3) float64 and triangles (m, 3) int suit the detection made on them.

    `marked` (s, 2) int are the ends of edges that were marked as creases, if marks were heeded.

    Examples
    --------
    On an ellipsoid of `vertices` and `triangles`, as in `detect`:

    >>> core.suitability(vertices, triangles, core.detect(vertices, triangles)).is_coarse
    False
    """
    vertices, triangles = np.asarray(vertices, float), np.asarray(triangles)
    detection.check_mesh(len(vertices))
    marked = vertex_pairs(marked, len(vertices), "marked edges")
    field = detection.curvature
    used = np.zeros(len(vertices), bool)
    used[triangles] = True
    bending = np.maximum(np.abs(field.k1), np.abs(field.k2))[used]
    bending = bending[np.isfinite(bending)]
    turn = float(np.median(bending)) * detection.scale if len(bending) else np.nan
    edge, cosine = _edge_cosines(vertices, triangles)
    sharp = cosine < np.cos(np.radians(SHARP))
    bent = ~sharp & (cosine < np.cos(np.radians(_BENT)))
    crossed = sharp & (cosine >= np.cos(np.radians(detection.crease_angle)))
    if marked is not None and len(marked):
        one, other = marked.T
        creases = np.isin(edge, edge_keys(one, other, len(vertices)))
        if are_few(int(np.count_nonzero(creases)), triangles.size):
            crossed &= ~creases
    few = any(region.kind == UNRESOLVED for region in detection.regions)
    counted = tuple(int(np.sum(one)) for one in (sharp, bent, crossed))
    return Suitability(turn, len(cosine), counted[0], counted[1], counted[2], few)


def _edge_cosines(vertices: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(e,) edges of two triangles with area, by `edge_keys`, and the cosine between the normals
    there."""
    a, b, c = (vertices[triangles[:, corner]] for corner in range(3))
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1)
    tail, head = ends_of(triangles)
    edge = edge_keys(tail, head, len(vertices))
    order = np.argsort(edge, kind="stable")
    first = np.flatnonzero(edge[order[1:]] == edge[order[:-1]])
    half_edge, twin = order[first], order[first + 1]
    has_area = (length[half_edge // 3] > 0.0) & (length[twin // 3] > 0.0)
    half_edge, twin = half_edge[has_area], twin[has_area]
    one, other = half_edge // 3, twin // 3
    # Triangles wound against each other have opposite normals: that is no crease.
    sign = np.where(tail[half_edge] == head[twin], 1.0, -1.0)
    cosine = sign * np.sum(normal[one] * normal[other], axis=1) / (length[one] * length[other])
    return edge[half_edge], cosine
