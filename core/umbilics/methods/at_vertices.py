"""Umbilics by looking at vertices alone: what method S is measured against.

The commonly used ways that the paper names before its own: a vertex where f = k1 - k2 or
g = H^2 - K is less than at its neighbours, or where the curvatures are alike within a ratio. They
find vertices, not points between them, and know no index.
"""

from __future__ import annotations

import numpy as np

from ...curvature.field import CurvatureField
from ...curvature.from_normals import voronoi_areas
from ...mesh.surface import NO_AREA, Surface
from ...mesh.unfolding.cotangents import angles_and_cotangents

# The less curvature over the larger above which a vertex counts as umbilical.
ALIKE = 0.95


def least_gap(surface: Surface, field: CurvatureField) -> np.ndarray:
    """Inner vertices where k1 - k2 is less than at all neighbours."""
    return _least(surface, field.gap)


def least_difference(surface: Surface) -> np.ndarray:
    """Inner vertices where H^2 - K is less than at all neighbours."""
    return _least(surface, mean_square_less_gaussian(surface))


def mean_square_less_gaussian(surface: Surface) -> np.ndarray:
    """(n,) H^2 - K at the vertices, which means nothing on a border; infinite where all triangles
    are without area.

    From shape operators it would be a quarter of the squared gap; the form is used because H and
    K can be had without them. H is taken from the cotangent Laplacian and K from the angle defect
    (Meyer et al. 2003, doi 10.1007/978-3-662-05105-4_2).
    """
    n = len(surface.vertices)
    triangles = surface.triangles
    angle, cotangent = angles_and_cotangents(surface.vertices, triangles)
    area = np.zeros(n)
    square = np.stack(list(surface.side_squares), axis=1)
    shares = voronoi_areas(square, surface.face_normal_area[1])
    defect = np.full(n, 2.0 * np.pi)
    pull = np.zeros((n, 3))
    for k in range(3):
        area += np.bincount(triangles[:, k], shares[:, k], minlength=n)
        defect -= np.bincount(triangles[:, k], angle[:, k], minlength=n)
        one, two = triangles[:, (k + 1) % 3], triangles[:, (k + 2) % 3]
        along = cotangent[:, k, None] * (surface.vertices[one] - surface.vertices[two])
        for axis in range(3):
            pull[:, axis] += np.bincount(one, along[:, axis], minlength=n)
            pull[:, axis] -= np.bincount(two, along[:, axis], minlength=n)
    found = np.full(n, np.inf)
    known = np.flatnonzero(area > NO_AREA)
    area, pull = area[known], pull[known]
    # The sum is four times the area times the mean curvature.
    mean_square = np.einsum("nc,nc->n", pull, pull) / (16.0 * area**2)
    found[known] = mean_square - defect[known] / area
    return found


def alike(surface: Surface, field: CurvatureField, ratio: float = ALIKE) -> np.ndarray:
    """Inner vertices whose curvatures have one sign and a ratio above `ratio`."""
    one, two = np.abs(field.k1), np.abs(field.k2)
    less, larger = np.minimum(one, two), np.maximum(one, two)
    same = (np.sign(field.k1) * np.sign(field.k2) > 0) & (less > ratio * larger)
    return np.flatnonzero(same & ~surface.border)


def _least(surface: Surface, values: np.ndarray) -> np.ndarray:
    """Inner vertices with a value less than that of every neighbour."""
    owner = surface.owner
    beaten = surface.border.copy()
    beaten[owner[~(values[owner] < values[surface.neighbours])]] = True
    return np.flatnonzero(~beaten)
