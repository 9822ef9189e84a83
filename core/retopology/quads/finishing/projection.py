"""Closest points on a triangle mesh."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from ....base.parallel import run
from ....base.progress import Progress
from ....base.unit import unit

# Triangles are sampled about as densely as the median one, with so many rows at most; larger ones
# make levels of their own, in each of which the samples are as far apart to this factor.
MOST_ROWS, LEVEL = 12, 2.0
# Samples looked at for each point, and rounds of going on to neighbouring triangles.
CANDIDATES, ROUNDS = 6, 4
# Samples looked at where the nearest ones may all be those of another sheet, and at most: more may
# be the closest only to points far off.
MANY, MOST_CANDIDATES = 64, 768
# Points that a thread takes at a time, and samples of all its points where each has many.
BLOCK, AT_ONCE = 1 << 11, 1 << 13


class ClosestPoints:
    """Closest points on (m, 3) triangles, on the side that a normal faces.

    Parameters
    ----------
    vertices, triangles, twin:
        Of a `Surface`.
    """

    def __init__(self, vertices: np.ndarray, triangles: np.ndarray, twin: np.ndarray) -> None:
        self._across = np.where(twin >= 0, twin // 3, np.arange(len(twin)) // 3).reshape(-1, 3)
        corner = vertices[triangles]
        self._plane = _planes(corner)
        self.normal = unit(np.cross(self._plane[:, 3:6], self._plane[:, 6:9]))
        self._levels = _levels(corner)

    def __call__(
        self, points: np.ndarray, normals: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Triangles (p,) and closest points (p, 3) on them.

        With `normals` (p, 3) triangles that face away from them are taken only where no other is
        near: the two sides of a thin sheet stay apart. The search is quick then, and sure where
        triangles are well shaped; without them it is exact, but for points so far off that
        hundreds of places are nearly as close.
        """
        triangle = np.empty(len(points), np.int64)
        closest = np.empty((len(points), 3))

        def block(first: int) -> None:
            rows = slice(first, first + BLOCK)
            facing = None if normals is None else normals[rows]
            triangle[rows], closest[rows], square = self._block(points[rows], facing)
            if facing is None:
                self._exactly(points[rows], triangle[rows], closest[rows], square)

        run(block, range(0, len(points), BLOCK), Progress())
        return triangle, closest

    def below(self, points: np.ndarray, normals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """As a call with normals, on any mesh: the closest triangles of all where they face
        them."""
        triangle, closest = self(points)
        away = np.flatnonzero(np.einsum("pc,pc->p", self.normal[triangle], normals) < 0.0)
        triangle[away], closest[away] = self(points[away], normals[away])
        return triangle, closest

    def faced(self, points: np.ndarray, normals: np.ndarray, reach: np.ndarray) -> np.ndarray:
        """(p,) bool whether any triangle within `reach` (p,) of a point faces its normal (p, 3)."""
        found = np.zeros(len(points), bool)
        for first in range(0, len(points), AT_ONCE // MANY):
            rows = slice(first, first + AT_ONCE // MANY)
            triangles = self._near(points[rows], MANY)
            square = _closest(points[rows, None], self._plane.take(triangles, axis=0))[2]
            facing = np.einsum("pkc,pc->pk", self.normal.take(triangles, axis=0), normals[rows])
            found[rows] = ((square <= reach[rows, None] ** 2) & (facing > 0.0)).any(axis=1)
        return found

    def _exactly(
        self, points: np.ndarray, triangle: np.ndarray, closest: np.ndarray, square: np.ndarray
    ) -> None:
        """What was found, with its squared distances, made exact in place. Triangles whose samples
        are all farther away than what was found, by more than they reach, are farther."""
        for level in self._levels:
            rows, count = np.arange(len(points)), 2 * CANDIDATES
            while len(rows) and count <= MOST_CANDIDATES:
                left = []
                for mine in np.array_split(rows, len(rows) * count // (MANY * AT_ONCE // 4) + 1):
                    away, near = level.nearest(points[mine], count)
                    found, there, distance = self._best(points[mine], None, near)
                    better = distance < square[mine]
                    triangle[mine[better]], closest[mine[better]] = found[better], there[better]
                    square[mine[better]] = distance[better]
                    left.append(mine[away < np.sqrt(square[mine]) + level.reach])
                rows = np.concatenate(left)
                count *= 2

    def _near(self, points: np.ndarray, count: int) -> np.ndarray:
        """(p, k) triangles of the samples that are nearest to points in each level, so many."""
        found = [level.nearest(points, count)[1] for level in self._levels]
        return found[0] if len(found) == 1 else np.concatenate(found, axis=1)

    def _block(
        self, points: np.ndarray, normals: np.ndarray | None
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        near = self._near(points, CANDIDATES)
        if len(self._levels) > 1:
            # What faces away gives way to what is near, and not to all that a level has.
            square = _closest(points[:, None], self._plane.take(near, axis=0))[2]
            nearest = np.argsort(square, axis=1, kind="stable")[:, :CANDIDATES]
            near = np.take_along_axis(near, nearest, axis=1)
        best, closest, least = self._best(points, normals, near)
        moving = np.arange(len(points))
        for _ in range(ROUNDS):
            facing = None if normals is None else normals[moving]
            found, there, distance = self._best(points[moving], facing, self._across[best[moving]])
            better = distance < least[moving]
            moving = moving[better]
            if not len(moving):
                break
            best[moving], closest[moving] = found[better], there[better]
            least[moving] = distance[better]
        return best, closest, least

    def _best(
        self, points: np.ndarray, normals: np.ndarray | None, triangles: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The closest of the triangles (p, k) to each point, the place, and the squared distance
        (more for those that face away)."""
        count = triangles.shape[1]
        plane = self._plane.take(triangles, axis=0)
        second, third, square = _closest(points[:, None], plane)
        if normals is not None:
            facing = np.einsum("pkc,pc->pk", self.normal.take(triangles, axis=0), normals)
            # Facing away counts like being farther by the spread of the candidates.
            spread = square.max(axis=1, keepdims=True)
            square = square + np.where(facing < 0.0, 4.0 * spread + 1e-30, 0.0)
        item = count * np.arange(len(points)) + square.argmin(axis=1)
        second, third = second.ravel()[item], third.ravel()[item]
        place = _places(plane.reshape(-1, plane.shape[-1])[item], second, third)
        return triangles.ravel()[item], place, square.ravel()[item]


def _planes(corner: np.ndarray) -> np.ndarray:
    """(t, 13) of triangles with corners (t, 3, 3): the first corner, the sides b and c from it to
    the others, b b, b c, c c, and the inverse of their determinant, NaN where there is none."""
    a, b, c = corner[:, 0], corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    bb, bc, cc = _dot(b, b), _dot(b, c), _dot(c, c)
    determinant = bb * cc - bc * bc
    inverse = np.full(len(a), np.nan)
    np.divide(1.0, determinant, out=inverse, where=determinant > np.finfo(float).eps * bb * cc)
    return np.column_stack([a, b, c, bb, bc, cc, inverse])


def _closest(points: np.ndarray, plane: np.ndarray) -> tuple[np.ndarray, ...]:
    """Weights of the second and third corner at the closest points, and the squared distances.

    Where a point does not lie over its triangle the nearest point of a side is the closest.

    Parameters
    ----------
    points, plane:
        (..., 3) and (..., 13) as of `_planes`.
    """
    out = points - plane[..., 0:3]
    along = np.einsum("...c,...c->...", out, plane[..., 3:6])
    beside = np.einsum("...c,...c->...", out, plane[..., 6:9])
    bb, bc, cc, inverse = (plane[..., column] for column in range(9, 13))
    second = (cc * along - bc * beside) * inverse
    third = (bb * beside - bc * along) * inverse
    inside = (second >= 0.0) & (third >= 0.0) & (second + third <= 1.0)
    tiny = np.finfo(float).tiny
    on_b = np.clip(along / np.maximum(bb, tiny), 0.0, 1.0)
    on_c = np.clip(beside / np.maximum(cc, tiny), 0.0, 1.0)
    across = np.maximum(bb - 2.0 * bc + cc, tiny)
    on_a = np.clip((beside - along + bb - bc) / across, 0.0, 1.0)
    # What the square of the distance is beyond that to the first corner.
    by_b = on_b * (on_b * bb - 2.0 * along)
    by_c = on_c * (on_c * cc - 2.0 * beside)
    by_a = bb - 2.0 * along + on_a * (on_a * across - 2.0 * (beside - along + bb - bc))
    sides = [by_b <= np.minimum(by_c, by_a), by_c <= by_a]
    second = np.where(inside, second, np.where(sides[0], on_b, np.where(sides[1], 0.0, 1.0 - on_a)))
    third = np.where(inside, third, np.where(sides[0], 0.0, np.where(sides[1], on_c, on_a)))
    away = out - second[..., None] * plane[..., 3:6] - third[..., None] * plane[..., 6:9]
    return second, third, np.einsum("...c,...c->...", away, away)


def _places(plane: np.ndarray, second: np.ndarray, third: np.ndarray) -> np.ndarray:
    return plane[:, 0:3] + second[:, None] * plane[:, 3:6] + third[:, None] * plane[:, 6:9]


def _dot(one: np.ndarray, two: np.ndarray) -> np.ndarray:
    return np.einsum("pc,pc->p", one, two)


@dataclass(frozen=True)
class _Level:
    """Samples of triangles that are about as far apart in all of them.

    Attributes
    ----------
    triangles:
        Rows of the triangles.
    tree:
        Of the samples.
    owner:
        The triangle of each.
    reach:
        How far a place of these triangles is from its nearest sample at most.
    """

    triangles: np.ndarray
    tree: cKDTree
    owner: np.ndarray
    reach: float

    def nearest(self, points: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
        """How far all others are at least (p,), and the triangles (p, k) of the nearest samples,
        so many; all triangles where there are no more."""
        if count >= len(self.triangles):
            return np.full(len(points), np.inf), np.tile(self.triangles, (len(points), 1))
        away, near = self.tree.query(points, k=count)
        return away.reshape(-1, count)[:, -1], self.owner[near.reshape(-1, count)]


def _levels(corner: np.ndarray) -> list[_Level]:
    """Points spread over triangles with corners (t, 3, 3), in levels by how far they are apart: in
    one, a single large triangle would have the search look at all that lie as near as it reaches.
    """
    side = np.linalg.norm(np.roll(corner, -1, axis=1) - corner, axis=2).max(axis=1)
    typical = 1.5 * max(float(np.median(side)), np.finfo(float).tiny)
    rows = np.clip(np.ceil(side / typical), 1, MOST_ROWS).astype(np.int64)
    apart = side / rows
    larger = np.log(np.maximum(apart / typical, 1.0)) / np.log(LEVEL)
    level = np.ceil(larger).astype(np.int64)
    found = []
    for number in np.unique(level).tolist():
        mine = np.flatnonzero(level == number)
        points, owner = _samples(corner[mine], rows[mine])
        # Sorted by medians a tree answers hardly faster and takes three times as long to plant.
        tree = cKDTree(points, balanced_tree=False, compact_nodes=False)
        # From the middle of a triangle to its corners it is two thirds of a median, which is
        # shorter than the longest side.
        found.append(_Level(mine, tree, mine[owner], float(apart[mine].max() * 2.0 / 3.0)))
    return found


def _samples(corner: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points spread over triangles (t, 3, 3) in so many rows (t,), and the triangle of each."""
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
