"""Surface types from the signs of mean and Gaussian curvature (Besl & Jain 1986), and the opening
of the elliptic part: erosions, then dilations, on the vertex graph."""

from __future__ import annotations

import numpy as np

from ..mesh.rings import adjacency
from ..mesh.surface import Surface

SURFACE_TYPES = (
    "peak",
    "pit",
    "ridge",
    "valley",
    "flat",
    "minimal",
    "saddle ridge",
    "saddle valley",
)
"""Names of the codes 0 to 7. With outward normals a convex place is a peak: a sphere's
curvatures are positive. On an open surface the side that the normals point to decides."""

PEAK, PIT, RIDGE, VALLEY, FLAT, MINIMAL, SADDLE_RIDGE, SADDLE_VALLEY = range(8)

# Rows by the sign of H, columns by that of K: 0, 1 and, as the last one, -1.
_TYPE_BY_SIGNS = np.array(
    [[FLAT, FLAT, MINIMAL], [RIDGE, PEAK, SADDLE_RIDGE], [VALLEY, PIT, SADDLE_VALLEY]], np.int8
)


def typical_curvature(surface: Surface, k1: np.ndarray, k2: np.ndarray) -> float:
    """What counts as an ordinary curvature on this surface, in 1 / length.

    The median over the vertices of the larger principal curvature in absolute value, but at
    least the curvature of a sphere around the whole surface: on a mesh that is mostly flat the
    median says nothing about its curved parts. `k1`, `k2` are (n,).
    """
    largest = np.maximum(k1, -k2)  # k1 >= k2
    largest = largest[np.isfinite(largest)]
    median = float(np.median(largest)) if len(largest) else 0.0
    diagonal = float(np.linalg.norm([np.ptp(column) for column in surface.vertices.T]))
    # A mesh may lie in a single point.
    return max(median, 2.0 / diagonal) if diagonal > 0.0 else median


def surface_types(k1: np.ndarray, k2: np.ndarray, tolerance: float) -> np.ndarray:
    """(n,) int8 code of `SURFACE_TYPES` at each vertex, -1 where a curvature is not a number.

    Principal curvatures (n,) within `tolerance` (1 / length) of zero count as zero. The sign
    of K is then that of their product, and H counts as zero within the tolerance where K < 0;
    in this way H = 0 with K > 0, which no surface has, cannot come out. The tolerance is
    `Settings.flatness` times `typical_curvature`.
    """
    first, second = _sign_beyond(tolerance, k1), _sign_beyond(tolerance, k2)
    gaussian = first * second
    total = np.where(first, k1, 0.0) + np.where(second, k2, 0.0)
    mean = _sign_beyond(np.where(gaussian < 0, 2.0 * tolerance, 0.0), total)
    types = _TYPE_BY_SIGNS[mean, gaussian]
    types[~(np.isfinite(k1) & np.isfinite(k2))] = -1
    return types


def _sign_beyond(tolerance: float | np.ndarray, values: np.ndarray) -> np.ndarray:
    """(n,) int8 signs of values, zero within the tolerance."""
    return (values > tolerance).astype(np.int8) - (values < -tolerance).astype(np.int8)


def opened_elliptic_part(surface: Surface, types: np.ndarray, passes: int) -> np.ndarray:
    """(n,) bool, the vertices of type peak or pit that survive an opening.

    An erosion drops the vertices that have a neighbour outside, a dilation adds all neighbours;
    `passes` of the first are followed by as many of the second. Narrow connectors go, what is
    broad comes back nearly whole. Flat vertices are not part of it. A border of the mesh is not
    an outside: nothing is eroded from there. `types` is (n,), see `surface_types`.
    """
    inside = (types == PEAK) | (types == PIT)
    if passes <= 0:
        return inside
    ring = adjacency(surface)
    for _ in range(passes):
        inside = inside & (ring @ (~inside).astype(np.int32) == 0)
    for _ in range(passes):
        inside = inside | (ring @ inside.astype(np.int32) > 0)
    return inside


def lies_within(
    surface: Surface, inside: np.ndarray, triangle: np.ndarray, barycentric: np.ndarray
) -> np.ndarray:
    """(k,) bool, whether points given by triangle (k,) and weights (k, 3) lie in a set of
    vertices (n,): decided by the corner nearest to the point, the one of largest weight."""
    corner = np.asarray(barycentric).argmax(axis=1) if len(triangle) else np.zeros(0, int)
    return inside[surface.triangles[triangle, corner]]
