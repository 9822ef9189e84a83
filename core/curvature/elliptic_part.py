"""The opening of the elliptic part: erosions, then dilations, on the vertex graph."""

from __future__ import annotations

import numpy as np

from ..mesh.rings import adjacency
from ..mesh.surface import Surface
from .surface_types import PEAK, PIT


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
        inside = inside & ~(ring @ ~inside)
    for _ in range(passes):
        inside = inside | (ring @ inside)
    return inside


def lies_within(
    surface: Surface, inside: np.ndarray, triangle: np.ndarray, barycentric: np.ndarray
) -> np.ndarray:
    """(k,) bool, whether points given by triangle (k,) and weights (k, 3) lie in a set of
    vertices (n,): decided by the corner nearest to the point, the one of largest weight."""
    corner = np.asarray(barycentric).argmax(axis=1) if len(triangle) else np.zeros(0, int)
    return inside[surface.triangles[triangle, corner]]
