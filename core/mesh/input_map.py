"""Between the surface as it is analysed and the mesh that came in.

Cleaning leaves triangles out, turns some and halves others, takes vertices apart and joins
them; whoever gave the mesh wants to hear of his own vertices, triangles and corners.
"""

from __future__ import annotations

import numpy as np

from ..base.subsets import places_in
from .surface import Surface


def at_vertices(surface: Surface, values: np.ndarray, count: int, empty: float) -> np.ndarray:
    """(count, ...) values (n, ...) of the surface's vertices at those of the input, all copies
    that were joined; `empty` where there are none."""
    result = scattered(values, surface.source_vertex, count, empty)
    copies, kept = surface.joined.T
    if len(copies):
        result[copies] = result[kept]
    return result


def at_triangles(surface: Surface, values: np.ndarray, count: int, empty: float) -> np.ndarray:
    """(count, ...) values (m, ...) of the surface's triangles at those of the input; of one that
    was split those of its last part."""
    return scattered(values, surface.source_triangle, count, empty)


def sums_at_triangles(surface: Surface, values: np.ndarray, count: int) -> np.ndarray:
    """(count,) sums over the parts of each input triangle of values (m,), 0 without any."""
    if len(surface.source_triangle) == count and not len(surface.recut):
        return at_triangles(surface, values, count, 0.0)
    return np.bincount(surface.source_triangle, values, minlength=count)


def scattered(values: np.ndarray, rows: np.ndarray, count: int, empty: float) -> np.ndarray:
    """(count, ...) `values` at their rows, `empty` elsewhere."""
    if len(rows) == count and np.array_equal(rows, np.arange(count)):
        return values
    result = np.full((count, *values.shape[1:]), empty, values.dtype)
    result[rows] = values
    return result


def kept_vertices(surface: Surface, vertices: np.ndarray) -> np.ndarray:
    """Input vertices (any shape), each replaced by the one that it was joined with."""
    if not len(surface.joined):
        return vertices
    count = 1 + max(int(vertices.max(initial=0)), int(surface.joined.max()))
    kept = np.arange(count)
    kept[surface.joined[:, 0]] = surface.joined[:, 1]
    return kept[vertices]


def places_in_input(
    surface: Surface, triangle: np.ndarray, barycentric: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Triangles (k,) of the surface and weights (k, 3) of their corners as input triangles and
    weights of the corners of these, in the order that they have there."""
    rows = surface.source_triangle[triangle]
    slot, recut = _slots(surface.recut, triangle)
    if not recut.any():
        return rows, barycentric
    barycentric = barycentric.copy()
    barycentric[recut] = np.einsum(
        "kc,kcd->kd", barycentric[recut], surface.recut_corners[slot[recut]]
    )
    return rows, barycentric


def places_on_surface(
    surface: Surface, rows: np.ndarray, barycentric: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Input triangles (k,) and weights (k, 3) as triangles of the surface, -1 where they are not
    part of it, and weights of the corners of these. Undoes `places_in_input`."""
    count = 1 + max(int(surface.source_triangle.max()), int(rows.max(initial=0)))
    triangle = places_in(surface.source_triangle, count)[rows]
    if not len(surface.recut):
        return triangle, barycentric
    weights = barycentric.copy()
    order = np.argsort(surface.source_triangle[surface.recut], kind="stable")
    parts = surface.source_triangle[surface.recut[order]]
    begin, end = np.searchsorted(parts, rows), np.searchsorted(parts, rows, side="right")
    best = np.full(len(rows), -np.inf)
    # Of the parts of a triangle the one that holds the point.
    for number in range(int((end - begin).max(initial=0))):
        some = np.flatnonzero(begin + number < end)
        slot = order[begin[some] + number]
        corners = surface.recut_corners[slot]
        sound = np.abs(np.linalg.det(corners)) > np.finfo(float).eps
        some, slot, corners = some[sound], slot[sound], corners[sound]
        within = np.linalg.solve(corners.transpose(0, 2, 1), barycentric[some][..., None])[..., 0]
        better = within.min(axis=1) > best[some]
        some, slot, within = some[better], slot[better], within[better]
        best[some] = within.min(axis=1)
        triangle[some], weights[some] = surface.recut[slot], within
    return triangle, weights


def _slots(ascending: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where values stand among ascending ones, and whether they do."""
    if not len(ascending):
        return np.zeros(len(values), int), np.zeros(len(values), bool)
    slot = np.minimum(np.searchsorted(ascending, values), len(ascending) - 1)
    return slot, ascending[slot] == values
