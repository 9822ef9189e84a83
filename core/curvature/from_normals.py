"""Shape operators from vertex normals (Rusinkiewicz 2004)."""

from __future__ import annotations

import numpy as np

from ..base.parallel import run
from ..base.progress import Progress
from ..base.unit import unit
from ..fields.transport import carried, doubled_angle, tangents
from ..mesh.surface import Surface
from .field import CurvatureField, field_from_deviators

# Triangles whose sides span the plane worse than this (determinant over squared trace of the
# sides' moments) fix no operator; an equilateral triangle has 1/4.
_LEAST_SPAN = 1e-14
# Triangles per block: its arrays stay in the second cache.
_BLOCK = 1 << 14
# What stands for the area of triangles without one: their cotangents stay numbers.
_LEAST_AREA = 1e-300


def curvature_from_normals(
    surface: Surface,
    normals: np.ndarray,
    progress: Progress | None = None,
    vertices: np.ndarray | None = None,
) -> CurvatureField:
    """Shape operators at the vertices from unit vertex normals (n, 3).

    In each triangle the symmetric operator S that best turns its sides e into the differences
    of the normals along them, sum |S e - dn|^2 least; carried into the vertices' tangent planes
    by the smallest rotation and averaged with the part of the triangle that is nearest to each
    vertex (its Voronoi area) as weight. The smallest rotation keeps mean curvature and |D|.

    Returns curvatures in 1 / (length unit of the surface); `noise` is NaN. Where only some vertices
    (n,) bool are asked for, nothing is said of the others.
    """
    n, corners = len(surface.vertices), surface.triangles
    if vertices is not None:
        corners = corners[surface.touching(vertices)]
    m = len(corners)
    e1, e2 = tangents(normals)
    # For each corner: weight, then weighted mean curvature and deviator (real, imaginary).
    parts = np.empty((4, 3, m))

    def block(first: int) -> None:
        rows = slice(first, first + _BLOCK)
        triangles = corners[rows]
        u, face_normal, face_mean, face_deviator, area = _face_operators(
            surface.vertices, triangles, normals
        )
        for k in range(3):
            vertex = triangles[:, k]
            along = carried(u, face_normal, normals[vertex])
            turned = face_deviator * doubled_angle(along, e1[vertex], e2[vertex])
            parts[0, k, rows] = area[:, k]
            parts[1, k, rows] = area[:, k] * face_mean
            parts[2, k, rows] = area[:, k] * turned.real
            parts[3, k, rows] = area[:, k] * turned.imag

    run(block, range(0, m, _BLOCK), progress or Progress())
    weight, mean, real, imaginary = (
        np.sum(
            [np.bincount(corners[:, k], part[k], minlength=n) for k in range(3)], axis=0
        )
        for part in parts
    )
    weight[weight == 0] = 1.0
    mean, deviator = mean / weight, (real + 1j * imaginary) / weight
    if vertices is None:
        return field_from_deviators(mean, deviator, normals, np.full(n, np.nan))
    rows = np.flatnonzero(vertices)
    noise = np.full(len(rows), np.nan)
    some = field_from_deviators(mean[rows], deviator[rows], normals[rows], noise)
    values = {}
    for name, value in vars(some).items():
        values[name] = np.full((n, *value.shape[1:]), np.nan)
        values[name][rows] = value
    return CurvatureField(**values)


def _face_operators(
    vertices: np.ndarray, triangles: np.ndarray, normals: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """First in-plane axis and normal (m, 3), mean curvature and deviator (m,) of each triangle
    and the Voronoi areas (m, 3) of its corners (0 where it fixes no operator)."""
    corners = vertices[triangles]
    side = np.roll(corners, -1, axis=1) - corners
    turn = np.roll(normals[triangles], -1, axis=1) - normals[triangles]
    square = np.einsum("mki,mki->mk", side, side)
    # The longest side gives the steadiest axis in a thin triangle.
    longest = square.argmax(axis=1)
    row = np.arange(len(triangles))
    length = np.sqrt(np.maximum(square[row, longest], np.finfo(float).tiny))
    u = side[row, longest] / length[:, None]
    cross = np.cross(side[:, 0], side[:, 1])
    doubled = np.linalg.norm(cross, axis=1)
    normal = unit(cross)
    v = np.cross(normal, u)
    x, y = np.einsum("mki,mi->mk", side, u), np.einsum("mki,mi->mk", side, v)
    p, q = np.einsum("mki,mi->mk", turn, u), np.einsum("mki,mi->mk", turn, v)
    # Normal equations G S + S G = M with G = sum e e^T; solved as
    # S = (det G M + adj G M adj G) / (2 tr G det G).
    g11, g12, g22 = (x * x).sum(1), (x * y).sum(1), (y * y).sum(1)
    m11, m22 = 2.0 * (x * p).sum(1), 2.0 * (y * q).sum(1)
    m12 = (x * q).sum(1) + (y * p).sum(1)
    trace, det = g11 + g22, g11 * g22 - g12 * g12
    sound = det > _LEAST_SPAN * trace * trace
    scale = np.divide(0.5, trace * det, out=np.zeros_like(det), where=sound)
    s11 = scale * (det * m11 + g22 * g22 * m11 - 2 * g22 * g12 * m12 + g12 * g12 * m22)
    s22 = scale * (det * m22 + g12 * g12 * m11 - 2 * g12 * g11 * m12 + g11 * g11 * m22)
    s12 = scale * (det * m12 - g22 * g12 * m11 + (g11 * g22 + g12 * g12) * m12 - g11 * g12 * m22)
    area = voronoi_areas(square, 0.5 * doubled)
    area[~sound] = 0.0
    return u, normal, 0.5 * (s11 + s22), (s11 - s22) + 2j * s12, area


def voronoi_areas(square: np.ndarray, area: np.ndarray) -> np.ndarray:
    """(m, 3) area nearest to each corner, the obtuse case as in Meyer et al. 2003.

    `square` (m, 3) squared lengths of the sides ab, bc, ca; `area` (m,).
    """
    # Cotangents at a, b, c: (squares of the adjacent sides - square of the opposite) / 4 area.
    opposite = np.roll(square, -1, axis=1)
    numerator = square.sum(axis=1, keepdims=True) - 2.0 * opposite
    cotangent = numerator / np.maximum(4.0 * area, _LEAST_AREA)[:, None]
    # Corner a: (|ab|^2 cot c + |ca|^2 cot b) / 8.
    share = (
        square * np.roll(cotangent, 1, axis=1)
        + np.roll(square, 1, axis=1) * np.roll(cotangent, -1, axis=1)
    ) / 8.0
    obtuse = numerator < 0
    any_obtuse = obtuse.any(axis=1, keepdims=True)
    return np.where(any_obtuse, area[:, None] * np.where(obtuse, 0.5, 0.25), share)
