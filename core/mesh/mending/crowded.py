"""Edges with three or four triangles: which of the sheets that meet there go on as one."""

from __future__ import annotations

import numpy as np

from ...base.unit import unit

# Of so many half-edges on an edge the first two are wound alike: which of them go with which of the
# others, in each of two ways.
Ways = list[list[tuple[int, int]]]
WAYS: dict[int, Ways] = {3: [[(0, 2)], [(1, 2)]], 4: [[(0, 2), (1, 3)], [(0, 3), (1, 2)]]}


def straight_on(
    corners: np.ndarray, vertices: np.ndarray, edge: np.ndarray, count: np.ndarray
) -> np.ndarray:
    """(p, 2) int64 pairs of half-edges that are wound against each other and of one sheet.

    Around an edge where two solids touch their surfaces take turns: a sheet is what bounds one of
    them. Otherwise sheets cross, one lies within the other, or one ends at another: they go on as
    straight as can be (after Guéziec, Taubin, Lazarus & Horn 2001, 10.1109/2945.928166).

    Parameters
    ----------
    corners, vertices:
        (m, 3) triangles on (n, 3) positions.
    edge, count:
        (3 m,) number of the undirected edge of each half-edge, and the half-edges on each.
    """
    tails = corners.ravel()
    found = [np.zeros((0, 2), np.int64)]
    for number, ways in WAYS.items():
        members = np.flatnonzero((count == number)[edge])
        members = members[np.argsort(edge[members], kind="stable")].reshape(-1, number)
        back = tails[members] != tails[members].min(axis=1, keepdims=True)
        # The two that are wound alike first.
        back ^= (back.sum(axis=1) > number - 2)[:, None]
        members = np.take_along_axis(members, np.argsort(back, axis=1, kind="stable"), axis=1)
        members = members[back.sum(axis=1) == number - 2]
        found.append(_chosen(corners, vertices, members, ways))
    return np.concatenate(found)


def _chosen(
    corners: np.ndarray, vertices: np.ndarray, members: np.ndarray, ways: Ways
) -> np.ndarray:
    """(p, 2) the pairs of the better way, for half-edges `members` (e, 3 or 4)."""
    triangle, side = members // 3, members % 3
    start = vertices[corners[triangle[:, :1], side[:, :1]]]
    along = unit(vertices[corners[triangle[:, :1], (side[:, :1] + 1) % 3]] - start)
    apex = vertices[corners[triangle, (side + 2) % 3]] - start
    out = unit(apex - np.einsum("ekc,ec->ek", apex, along[:, 0])[..., None] * along)
    bend, solid = np.zeros((2, 2, len(members)))
    for number, pairs in enumerate(ways):
        for forth, back in pairs:
            sine = np.einsum("ec,ec->e", along[:, 0], np.cross(out[:, back], out[:, forth]))
            cosine = np.einsum("ec,ec->e", out[:, back], out[:, forth])
            # From those that go back anticlockwise to those that go forth it is solid behind both.
            solid[number] += np.arctan2(sine, cosine) % (2.0 * np.pi)
            bend[number] += cosine
    turns = len(ways[0]) == 2 and np.abs(solid[0] - solid[1]) > np.pi
    second = np.where(turns, solid[0] > solid[1], bend[0] > bend[1])
    pairs = np.array(ways)[second.astype(int)]
    return np.take_along_axis(members[:, None, :], pairs, axis=2).reshape(-1, 2)
