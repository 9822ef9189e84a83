"""Shape operators in the coordinates of any map of the surface to the plane.

In the coordinates (u, v) of a map with Jacobian A the shape operator S of an orthonormal frame is
A S A^-1, which is symmetric only where the map is conformal. The paper's t = (S11 - S22, S12 + S21)
vanishes at umbilics all the same, so that method S needs no particular parametrization.
"""

from __future__ import annotations

import numpy as np

from ...curvature.field import CurvatureField
from ...fields.transport import doubled_angle, tangents
from ...mesh.surface import Surface
from .curvature_tensor import Unfolding, vertex_maps

# A vertex whose map is nearly folded, the squares of |p| and |q| alike to this part, has no
# coordinates to speak of.
FOLDED = 1e-3


def corner_deviators(
    surface: Surface, field: CurvatureField, unfolding: Unfolding
) -> tuple[np.ndarray, np.ndarray]:
    """The paper's t at the corners of every triangle, in the coordinates of the map.

    With z -> p z + q conj(z) for A and the deviator D of S, t is (p^2 D - q^2 conj(D)) over
    |p|^2 - |q|^2. The vertex maps are shared by the triangles of a chart.

    Returns
    -------
    values:
        (m, 3) complex128; turned over where the map turns the triangle over, so that it winds
        about zero as D does.
    refused:
        (m,) bool, True where the map folds at a corner or turns only some of them over.
    """
    p, q = vertex_maps(surface, field.normal, unfolding)
    vertex = unfolding.charts.vertex
    e1, e2 = tangents(field.normal[vertex])
    deviator = doubled_angle(field.d1[vertex], e1, e2, field.gap[vertex])
    area = np.abs(p) ** 2 - np.abs(q) ** 2
    folded = np.abs(area) <= FOLDED * (np.abs(p) ** 2 + np.abs(q) ** 2)
    values = (p**2 * deviator - q**2 * deviator.conj()) / np.where(folded, 1.0, area)
    over = area < 0
    values = np.where(over, values.conj(), values)
    corners = unfolding.charts.corners
    mixed = over[corners].any(axis=1) & ~over[corners].all(axis=1)
    return values[corners], folded[corners].any(axis=1) | mixed
