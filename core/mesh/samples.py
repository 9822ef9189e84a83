"""Points spread over a surface by area."""

from __future__ import annotations

import numpy as np

from ..base.unit import unit
from .normals import corner_weights

# Cosine between a triangle and the mean about its corner from which on that is a crease.
_SMOOTH = float(np.cos(np.radians(30.0)))

def spread_points(
    vertices: np.ndarray,
    triangles: np.ndarray,
    face_normal_area: tuple[np.ndarray, np.ndarray],
    count: int,
    random: np.random.Generator,
) -> tuple[np.ndarray, np.ndarray]:
    """(count, 3) points, evenly distributed over the surface, and (count, 3) unit normals there,
    as `points_at` has them."""
    _, area = face_normal_area
    row = random.choice(len(area), count, p=area / area.sum())
    a, b = np.sqrt(random.random(count)), random.random(count)
    weights = np.stack([1.0 - a, a * (1.0 - b), a * b], axis=1)
    return points_at(vertices, triangles, face_normal_area, row, weights)


def points_at(
    vertices: np.ndarray,
    triangles: np.ndarray,
    face_normal_area: tuple[np.ndarray, np.ndarray],
    row: np.ndarray,
    weights: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """(s, 3) points of the surface that the triangles stand for, over the triangles `row` (s,) at
    barycentric `weights` (s, 3), and (s, 3) unit normals there.

    The normals go over from corner to corner: each has the mean of its triangles', where that is no
    crease. The points are lifted off the triangles to parabolas over their edges that have these
    normals at the ends: a plane through points of a rounded surface lies on its inner side, the
    deeper the coarser the mesh, and two meshes of one surface would differ by that.
    """
    normal, _ = face_normal_area
    corners = triangles[row]
    own = mean_normals(vertices, triangles, face_normal_area)[corners]
    smooth = np.einsum("skc,sc->sk", own, normal[row]) > _SMOOTH
    own = np.where(smooth[..., None], own, normal[row][:, None])
    across = unit(np.einsum("sk,skc->sc", weights, own))
    points = np.einsum("sk,skc->sc", weights, vertices[corners])
    return points + _height(vertices[corners], own, weights)[:, None] * across, across


def _height(corner: np.ndarray, normal: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """(s,) how far the surface with the unit `normal` (s, 3, 3) at each `corner` (s, 3, 3) lies
    above a triangle at (s, 3) barycentric `weights`.

    Linear interpolation of f misses the sum of w_i w_j e.f''e / 2 over the edges e from i to j;
    along an edge the normal turns by -f''e.
    """
    height = np.zeros(len(weights))
    for one in range(3):
        other = (one + 1) % 3
        edge = corner[:, other] - corner[:, one]
        turned = normal[:, other] - normal[:, one]
        height += 0.5 * weights[:, one] * weights[:, other] * np.einsum("sc,sc->s", edge, turned)
    return height


def mean_normals(
    vertices: np.ndarray,
    triangles: np.ndarray,
    face_normal_area: tuple[np.ndarray, np.ndarray],
) -> np.ndarray:
    """(n, 3) unit means of the normals of each vertex' triangles by `corner_weights`."""
    normal, area = face_normal_area
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    squares = np.stack([np.einsum("tc,tc->t", side, side) for side in (b - a, c - b, a - c)])
    weights = corner_weights(area, squares)
    mean: np.ndarray = np.stack(
        [
            np.bincount(triangles.ravel(), (weights * normal[:, k, None]).ravel(), len(vertices))
            for k in range(3)
        ],
        axis=1,
    )
    return unit(mean)
