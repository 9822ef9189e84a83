"""The fans of triangles around poles as the map should have them: developed to whole turns."""

from __future__ import annotations

import numpy as np

from ..field.crosses import QUARTER, TURNS, fans
from .seamless_map import SeamlessProblem


def cone_targets(problem: SeamlessProblem, vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Jacobians that open the fans of inner vertices (v,) to their quarter turns.

    The angles of a fan are stretched alike, its lengths stay, and the whole is turned to the
    crosses as a mean.

    Returns
    -------
    triangle, target:
        (t,) int64 triangles of the fans and (t, 4) Jacobians wanted there.
    """
    crosses, cut = problem.crosses, problem.seams
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
