"""Faces of a mesh that pass through one another."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from .....mesh.surface import Surface

# Faces are looked for among those at most as large, in classes of sizes a factor two apart.
CLASSES = 24
# Volumes below this part of the cube of an edge count as touching, not crossing.
TOUCHING = 1e-9
# Pairs tested at once.
BLOCK = 1 << 17
# Crossings of a surface are sought within so many times the distance that is asked for, so that
# they are not sought again for what has moved a little.
WIDER = 2.0


def crossings(position: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """(p, 2) int64 pairs of faces (f, k) that share no corner and pass through each other.

    Quads count as two triangles, parted along their shorter diagonal.
    """
    pairs = _near(position, faces)
    found = []
    for first in range(0, len(pairs), BLOCK):
        some = pairs[first : first + BLOCK]
        one, two = (_triangles(position[faces[rows]]) for rows in some.T)
        crossing = np.zeros(len(some), bool)
        for a in range(one.shape[1]):
            for b in range(two.shape[1]):
                crossing |= _pierced(one[:, a], two[:, b]) | _pierced(two[:, b], one[:, a])
        found.append(some[crossing])
    return np.concatenate([np.zeros((0, 2), np.int64), *found])


class OwnCrossings:
    """Where a surface passes through itself, sought beside what is asked for and then kept.

    Parameters
    ----------
    surface:
        What is asked for lies in the coordinates of its input.
    """

    def __init__(self, surface: Surface) -> None:
        self.surface = surface
        # Within so far of these places all pairs are known.
        self._places, self._far = np.zeros((0, 3)), 0.0
        self._pairs = np.zeros((0, 2), np.int64)

    @cached_property
    def _corner(self) -> np.ndarray:
        surface = self.surface
        return np.asarray((surface.vertices * surface.unit + surface.origin)[surface.triangles])

    @cached_property
    def _middle(self) -> np.ndarray:
        return np.asarray(self._corner.mean(axis=1))

    @cached_property
    def _widest(self) -> float:
        """How far a corner is from the middle of its triangle at most."""
        return float(np.linalg.norm(self._corner - self._middle[:, None], axis=2).max())

    def beside(self, centre: np.ndarray, reach: np.ndarray) -> np.ndarray:
        """(p,) bool whether a triangle that reaches into a ball (its centre of (p, 3), its radius
        of (p,)) crosses another one that reaches into any of them."""
        reach = reach + self._widest
        self._seek(centre, reach)
        ends, pair = np.unique(self._pairs, return_inverse=True)
        pair = pair.reshape(-1, 2)
        near = cKDTree(self._middle[ends]).query_ball_point(centre, reach)
        inside = np.zeros(len(ends), bool)
        for rows in near:
            inside[rows] = True
        crossing = np.zeros(len(ends), bool)
        crossing[pair[inside[pair].all(axis=1)]] = True
        return np.array([crossing[rows].any() for rows in near])

    def _seek(self, centre: np.ndarray, reach: np.ndarray) -> None:
        """Know all pairs within these balls."""
        if len(self._places):
            new = cKDTree(self._places).query(centre)[0] + reach > self._far
        else:
            new = np.ones(len(centre), bool)
        if not new.any():
            return
        self._places = np.concatenate([self._places, centre[new]])
        self._far = max(self._far, WIDER * float(reach.max()))
        away, _ = cKDTree(self._places).query(self._middle, distance_upper_bound=self._far)
        some = np.flatnonzero(np.isfinite(away))
        self._pairs = some[crossings(self.surface.vertices, self.surface.triangles[some])]


def _near(position: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """(p, 2) pairs of faces without a common corner whose boxes overlap, each once."""
    at = position[faces]
    low, high = at.min(axis=1), at.max(axis=1)
    middle = 0.5 * (low + high)
    radius = 0.5 * np.linalg.norm(high - low, axis=1)
    largest = float(radius.max(initial=0.0))
    found = [np.zeros((0, 2), np.int64)]
    if largest <= 0.0:
        return found[0]
    kind = np.log2(largest / np.maximum(radius, largest * 0.5**CLASSES)).astype(np.int64)
    for number in np.unique(kind):
        large, others = np.flatnonzero(kind == number), np.flatnonzero(kind >= number)
        reach = 2.0 * largest * 0.5**number
        matrix = cKDTree(middle[large]).sparse_distance_matrix(
            cKDTree(middle[others]), reach, output_type="ndarray"
        )
        one, two = large[matrix["i"]], others[matrix["j"]]
        # Within a class both orders are found.
        once = (kind[two] > number) | (one < two)
        one, two = one[once], two[once]
        overlap = np.all((low[one] <= high[two]) & (low[two] <= high[one]), axis=1)
        one, two = one[overlap], two[overlap]
        shared = np.any(faces[one][:, :, None] == faces[two][:, None, :], axis=(1, 2))
        found.append(np.column_stack([one, two])[~shared])
    return np.concatenate(found)


def _triangles(at: np.ndarray) -> np.ndarray:
    """(p, t, 3, 3) triangles of faces with corners (p, k, 3)."""
    if at.shape[1] == 3:
        return at[:, None]
    short = ((at[:, 0] - at[:, 2]) ** 2).sum(axis=1) <= ((at[:, 1] - at[:, 3]) ** 2).sum(axis=1)
    at = np.where(short[:, None, None], at, np.roll(at, -1, axis=1))
    return np.stack([at[:, [0, 1, 2]], at[:, [0, 2, 3]]], axis=1)


def _pierced(one: np.ndarray, two: np.ndarray) -> np.ndarray:
    """(p,) bool whether a side of the triangles `one` (p, 3, 3) passes through those of `two`."""
    a, b, c = two[:, 0], two[:, 1], two[:, 2]
    normal = np.cross(b - a, c - a)
    height = np.einsum("pkc,pc->pk", one - a[:, None], normal)
    size = np.einsum("pc,pc->p", normal, normal)
    least = TOUCHING * size**0.75 * np.maximum(size, np.finfo(float).tiny) ** 0.75
    found = np.zeros(len(one), bool)
    for side in range(3):
        start, end = one[:, side], one[:, (side + 1) % 3]
        through = height[:, side] * height[:, (side + 1) % 3] < -least
        along = end - start
        volumes = [
            np.einsum("pc,pc->p", along, np.cross(p - start, q - start))
            for p, q in ((a, b), (b, c), (c, a))
        ]
        inside = np.all([v > 0 for v in volumes], axis=0) | np.all([v < 0 for v in volumes], axis=0)
        found |= through & inside
    return found
