"""Every triangle laid into the complex plane, with the deviator of the curvature in it.

Corner a lies at 0, b on the positive real axis, c above it. What is traced in one triangle is
carried to the next by turning about the edge they share, so that points never leave the surface.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..base.parallel import run
from ..base.progress import Progress
from ..base.unit import phase
from ..mesh.surface import Surface
from .directions import DirectionField
from .frames import side_axes
from .transport import as_complex

BLOCK = 1 << 15
# Ratio of the singular values of the deviator's change below which it is taken for rank one. On
# ellipsoids it is 0.61 to 0.98 within two edges of an umbilic (5th to 95th percentile), on the
# circles of r = 2 + cos z 0.00 to 0.20 (five resolutions); confirmed as `STEADY_COSINE` is.
SINGULAR = 0.3


@dataclass(frozen=True)
class FaceFrames:
    """The m triangles of a surface in their planes.

    Attributes
    ----------
    corner:
        (m, 3) complex128 places of the corners.
    turn:
        (3 m,) complex128 of modulus 1: what a direction is multiplied with when it crosses
        half-edge 3 t + k into the triangle beyond; 1 on borders.
    value, along, across:
        (m,) complex128 deviator D(z) = value + along z + across conj(z), in 1 / length of the
        surface's coordinates.
    swapping:
        (m,) bool triangles over which, or over one beside, the deviator goes to its opposite rather
        than around zero, as where the families change places on a curve of umbilics: its change is
        nearly of rank one. Around an umbilic it is not.
    """

    corner: np.ndarray
    turn: np.ndarray
    value: np.ndarray
    along: np.ndarray
    across: np.ndarray
    swapping: np.ndarray

    @cached_property
    def size(self) -> np.ndarray:
        """(m,) float64 about an edge of each triangle: the root of twice its area."""
        doubled = self.corner[:, 1].real * self.corner[:, 2].imag
        return np.sqrt(np.maximum(doubled, np.finfo(float).tiny))

    @cached_property
    def doubt(self) -> np.ndarray:
        """(m,) float64 what the deviator changes by over about an edge of each triangle: directions
        of a smaller one are not resolved by the mesh."""
        return (np.abs(self.along) + np.abs(self.across)) * self.size

    def deviator(self, triangle: np.ndarray, z: np.ndarray) -> np.ndarray:
        """D at the places z (r,) of triangles (r,)."""
        return self.value[triangle] + self.along[triangle] * z + self.across[triangle] * z.conj()


def lay_out(surface: Surface, field: DirectionField, progress: Progress) -> FaceFrames:
    """The triangles of a surface and the line field `field` of its vertices in their planes."""
    m = len(surface.triangles)
    normal, _ = surface.face_normal_area
    corner = np.zeros((m, 3), complex)
    edge = np.ones((m, 3), complex)
    value, along, across = (np.zeros(m, complex) for _ in range(3))
    gap = np.nan_to_num(field.magnitude)
    d1, d2 = np.nan_to_num(field.direction), np.nan_to_num(field.across)

    def block(first: int) -> None:
        rows = slice(first, first + BLOCK)
        vertex = surface.triangles[rows]
        a, b, c = (surface.vertices[vertex[:, k]] for k in range(3))
        x = b - a
        length = np.linalg.norm(x, axis=1)
        x /= np.maximum(length, np.finfo(float).tiny)[:, None]
        y = np.cross(normal[rows], x)
        zb = length.astype(complex)
        zc = as_complex(c - a, x, y)
        corner[rows, 1], corner[rows, 2] = zb, zc
        sides = np.stack([zb, zc - zb, -zc], axis=1)
        edge[rows] = phase(sides)
        at = []
        for k in range(3):
            one, two = d1[vertex[:, k]], d2[vertex[:, k]]
            # The rotation in the polar decomposition of the projection between the planes.
            turn = np.einsum("rc,rc->r", one, x) + np.einsum("rc,rc->r", two, y)
            turn = turn + 1j * (np.einsum("rc,rc->r", one, y) - np.einsum("rc,rc->r", two, x))
            at.append(gap[vertex[:, k]] * phase(turn) ** 2)
        value[rows] = at[0]
        # D_b - D_a = (B + C) zb and D_c - D_a = B zc + C conj(zc).
        slope = (at[1] - at[0]) / np.where(length > np.finfo(float).tiny, length, np.inf)
        height = np.where(np.abs(zc.imag) > np.finfo(float).tiny, zc.imag, np.inf)
        rest = (at[2] - at[0] - slope * zc.real) / height
        along[rows] = 0.5 * (slope - 1j * rest)
        across[rows] = 0.5 * (slope + 1j * rest)

    run(block, range(0, m, BLOCK), progress)
    around = edge.ravel()
    twin = surface.twin
    inner = twin >= 0
    turn = np.ones(3 * m, complex)
    turn[inner] = -around[twin[inner]] * around[inner].conj()
    one, two = np.abs(along), np.abs(across)
    flat = np.abs(one - two) < SINGULAR * (one + two)
    swapping = flat | (flat[twin // 3] & inner).reshape(-1, 3).any(axis=1)
    return FaceFrames(corner, turn, value, along, across, swapping)


def places(planes: FaceFrames, triangle: np.ndarray, barycentric: np.ndarray) -> np.ndarray:
    """(r,) complex128 places of points given by barycentric coordinates (r, 3)."""
    return np.einsum("rk,rk->r", planes.corner[triangle], barycentric)


def barycentric_of(planes: FaceFrames, triangle: np.ndarray, z: np.ndarray) -> np.ndarray:
    """(r, 3) barycentric coordinates of places z in the planes of triangles, inside them."""
    second, third = second_and_third(planes, triangle, z)
    weights = np.clip(np.stack([1.0 - second - third, second, third], axis=1), 0.0, 1.0)
    return weights / weights.sum(axis=1, keepdims=True)


def second_and_third(
    planes: FaceFrames, triangle: np.ndarray, z: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(r,) barycentric coordinates of places z that belong to the second and third corners."""
    b, c = planes.corner[triangle, 1].real, planes.corner[triangle, 2]
    third = z.imag / np.where(c.imag > 0, c.imag, 1.0)
    return (z.real - third * c.real) / np.where(b > 0, b, 1.0), third


def in_plane(surface: Surface, triangle: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """(r,) complex128 of modulus 1: vectors (r, 3) laid into the planes of their triangles."""
    return phase(as_complex(vectors, *side_axes(surface, triangle)))
