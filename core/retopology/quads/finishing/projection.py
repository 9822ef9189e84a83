"""Closest points on a triangle mesh."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

# Triangles are sampled about as densely as the median one, with so many rows at most.
MOST_ROWS = 12
# Samples looked at for each point, and rounds of going on to neighbouring triangles.
CANDIDATES, ROUNDS = 6, 4
BLOCK = 1 << 15


class ClosestPoints:
    """Closest points on (m, 3) triangles, on the side that a normal faces.

    Parameters
    ----------
    vertices, triangles, twin:
        Of a `Surface`.
    """

    def __init__(self, vertices: np.ndarray, triangles: np.ndarray, twin: np.ndarray) -> None:
        self._corner = vertices[triangles]
        self._across = np.where(twin >= 0, twin // 3, np.arange(len(twin)) // 3).reshape(-1, 3)
        a, b, c = self._corner.transpose(1, 0, 2)
        normal = np.cross(b - a, c - a)
        length = np.linalg.norm(normal, axis=1, keepdims=True)
        self.normal = normal / np.maximum(length, np.finfo(float).tiny)
        points, self._owner = _samples(self._corner)
        self._tree = cKDTree(points)

    def __call__(
        self, points: np.ndarray, normals: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Triangles (p,) and closest points (p, 3) on them.

        With `normals` (p, 3) triangles that face away from them are taken only where no other is
        near: the two sides of a thin sheet stay apart.
        """
        triangle = np.empty(len(points), np.int64)
        closest = np.empty((len(points), 3))
        for first in range(0, len(points), BLOCK):
            rows = slice(first, first + BLOCK)
            facing = None if normals is None else normals[rows]
            triangle[rows], closest[rows] = self._block(points[rows], facing)
        return triangle, closest

    def _block(
        self, points: np.ndarray, normals: np.ndarray | None
    ) -> tuple[np.ndarray, np.ndarray]:
        count = min(CANDIDATES, self._tree.n)
        _, near = self._tree.query(points, k=count)
        best, closest, least = self._best(points, normals, self._owner[near.reshape(-1, count)])
        for _ in range(ROUNDS):
            found, there, distance = self._best(points, normals, self._across[best])
            better = distance < least
            if not better.any():
                break
            best = np.where(better, found, best)
            closest = np.where(better[:, None], there, closest)
            least = np.where(better, distance, least)
        return best, closest

    def _best(
        self, points: np.ndarray, normals: np.ndarray | None, triangles: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The closest of the triangles (p, k) to each point, the place, and the squared distance
        (more for those that face away)."""
        count = triangles.shape[1]
        flat = triangles.ravel()
        place = closest_on(np.repeat(points, count, axis=0), self._corner[flat])
        square = ((place.reshape(-1, count, 3) - points[:, None]) ** 2).sum(axis=2)
        if normals is not None:
            facing = np.einsum("pkc,pc->pk", self.normal[triangles], normals)
            # Facing away counts like being farther by the spread of the candidates.
            spread = square.max(axis=1, keepdims=True)
            square = square + np.where(facing < 0.0, 4.0 * spread + 1e-30, 0.0)
        item = square.argmin(axis=1)
        row = np.arange(len(points))
        return triangles[row, item], place.reshape(-1, count, 3)[row, item], square[row, item]


def closest_on(points: np.ndarray, corner: np.ndarray) -> np.ndarray:
    """(p, 3) the point of each triangle, corners (p, 3, 3), that is closest to its point.

    By the region of the plane that the point lies over (Ericson 2004, Real-Time Collision
    Detection, 5.1.5).
    """
    a, b, c = corner[:, 0], corner[:, 1], corner[:, 2]
    ab, ac = b - a, c - a
    d1, d2 = _dot(ab, points - a), _dot(ac, points - a)
    d3, d4 = _dot(ab, points - b), _dot(ac, points - b)
    d5, d6 = _dot(ab, points - c), _dot(ac, points - c)
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    total = va + vb + vc
    with np.errstate(divide="ignore", invalid="ignore"):
        v, w = vb / total, vc / total
        on_ab, on_ac = d1 / (d1 - d3), d2 / (d2 - d6)
        on_bc = (d4 - d3) / ((d4 - d3) + (d5 - d6))
    v, w = np.where(total > 0, v, 0.0), np.where(total > 0, w, 0.0)
    cases = [
        ((d1 <= 0) & (d2 <= 0), 0.0, 0.0),
        ((d3 >= 0) & (d4 <= d3), 1.0, 0.0),
        ((d6 >= 0) & (d5 <= d6), 0.0, 1.0),
        ((vc <= 0) & (d1 >= 0) & (d3 <= 0), on_ab, 0.0),
        ((vb <= 0) & (d2 >= 0) & (d6 <= 0), 0.0, on_ac),
        ((va <= 0) & (d4 >= d3) & (d5 >= d6), 1.0 - on_bc, on_bc),
    ]
    conditions = [case[0] for case in cases]
    v = np.select(conditions, [np.broadcast_to(case[1], v.shape) for case in cases], v)
    w = np.select(conditions, [np.broadcast_to(case[2], w.shape) for case in cases], w)
    v, w = np.nan_to_num(v), np.nan_to_num(w)
    return a + v[:, None] * ab + w[:, None] * ac


def _dot(one: np.ndarray, two: np.ndarray) -> np.ndarray:
    return np.einsum("pc,pc->p", one, two)


def _samples(corner: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points spread over the triangles, and the triangle of each."""
    side = np.linalg.norm(np.roll(corner, -1, axis=1) - corner, axis=2).max(axis=1)
    typical = max(float(np.median(side)), np.finfo(float).tiny)
    rows = np.clip(np.ceil(side / (1.5 * typical)), 1, MOST_ROWS).astype(np.int64)
    points, owner = [], []
    for count in np.unique(rows):
        mine = np.flatnonzero(rows == count)
        i, j = np.divmod(np.arange(count * count), count)
        inside = i + j < count
        u, v = (i[inside] + 1 / 3) / count, (j[inside] + 1 / 3) / count
        weight = np.column_stack([1.0 - u - v, u, v])
        points.append(np.einsum("sk,tkc->tsc", weight, corner[mine]).reshape(-1, 3))
        owner.append(np.repeat(mine, len(weight)))
    return np.concatenate(points), np.concatenate(owner)
