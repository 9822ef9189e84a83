"""What poles ask of a map around them: fans developed to whole turns, and sizes that change."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from ....base.factors import definite_factors
from ....base.plane import doubled_areas
from ....fields.connection import LARGEST_WEIGHT, LEAST_WEIGHT
from ....mesh.half_edges import previous
from ..field.crosses import QUARTER, TURNS, Crosses, fans
from .seams import Seams

# The logarithm of what sizes are off by at most.
FARTHEST = 2.0


def cone_scales(crosses: Crosses, evened: float) -> np.ndarray:
    """(m,) what a map stretches triangles by where it turns with the crosses about every vertex.

    Directions that turn leave no even map. One that scales alike to all sides has a scale whose
    logarithm's Laplacian is what the angles around each vertex are more than its quarter turns
    (Ben-Chen, Gotsman & Bunin 2008, 10.1111/j.1467-8659.2008.01142.x): at a pole of five sides it
    goes to 0, at one of three it grows. Here it goes back to 1 over `evened` lengths of quads.
    """
    n = len(crosses.vertices)
    angle = crosses.corner_angle
    half = np.arange(len(angle))
    weight = 0.5 / np.tan(np.maximum(angle[previous(half)], 1e-3))
    lower = crosses.inner[crosses.inner < crosses.twin[crosses.inner]]
    edge = np.concatenate([lower, np.flatnonzero(crosses.twin < 0)])
    other = np.where(crosses.twin[edge] >= 0, weight[crosses.twin[edge]], 0.0)
    both = np.clip(weight[edge] + other, LEAST_WEIGHT, LARGEST_WEIGHT)
    ends = crosses.tail[edge], crosses.head[edge]
    graph = sparse.coo_array((both, ends), shape=(n, n)).tocsr()
    graph = graph + graph.T
    area = np.repeat(np.abs(doubled_areas(crosses.corner)) / 6.0, 3)
    around = np.bincount(crosses.tail, area, n) / evened**2
    excess = np.bincount(crosses.tail, angle, n) - QUARTER * crosses.quarter_turns
    excess[crosses.border | crosses.on_feature] = 0.0
    system = sparse.diags_array(graph.sum(axis=1) + around) - graph
    scale = definite_factors(system.tocsr()).solve(excess)[crosses.triangles].mean(axis=1)
    return np.asarray(np.exp(np.clip(scale, -FARTHEST, FARTHEST)))


def cone_targets(
    crosses: Crosses, cut: Seams, vertices: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Jacobians that open the fans of inner vertices (v,) to their quarter turns.

    The angles of a fan are stretched alike, its lengths stay, and the whole is turned to the
    crosses as a mean.

    Returns
    -------
    triangle, target:
        (t,) int64 triangles of the fans and (t, 4) Jacobians wanted there.
    """
    if not len(vertices):
        return np.zeros(0, np.int64), np.zeros((0, 4))
    first = np.zeros(len(crosses.vertices), np.int64)
    first[crosses.tail] = np.arange(len(crosses.tail))
    none = np.zeros(len(crosses.twin), bool)
    corner, start = fans(crosses.twin, none, first[vertices])
    at = crosses.corner * TURNS[-cut.comb % 4][:, None]
    triangles, targets = [], []
    for row, vertex in enumerate(vertices.tolist()):
        around = corner[start[row] : start[row + 1]]
        face, side = around // 3, around % 3
        out = at[face, (side + 1) % 3] - at[face, side]
        back = at[face, (side + 2) % 3] - at[face, side]
        angle = np.angle(back * out.conj())
        passed = np.concatenate([[0.0], np.cumsum(angle)])
        passed *= crosses.quarter_turns[vertex] * QUARTER / passed[-1]
        # Each triangle is entered across the side before its corner, by a matching.
        crossed = 3 * face + (side + 2) % 3
        turn = -QUARTER * np.concatenate([[0], np.cumsum(cut.matching[crossed[:-1]])])
        off = np.angle(out) + turn - passed[:-1]
        off = off[0] + np.angle(np.exp(1j * (off - off[0])))
        here = np.abs(out) * np.exp(1j * (off.mean() + passed[:-1] - turn))
        there = np.abs(back) * np.exp(1j * (off.mean() + passed[1:] - turn))
        # The linear map that takes out and back to here and there.
        area = (out.conj() * back).imag
        x = (here * back.imag - there * out.imag) / area
        y = (there * out.real - here * back.real) / area
        triangles.append(face)
        targets.append(np.column_stack([x.real, y.real, x.imag, y.imag]))
    return np.concatenate(triangles), np.concatenate(targets)
