"""Every triangle laid into the complex plane, with the deviator of the curvature in it.

Corner a lies at 0, b on the positive real axis, c above it. What is traced in one triangle is
carried to the next by turning about the edge they share, so that points never leave the surface.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .detection import CurvatureField
from .parallel import run
from .progress import Progress
from .surface import Surface

BLOCK = 1 << 15


@dataclass(frozen=True)
class TrianglePlanes:
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
    """

    corner: np.ndarray
    turn: np.ndarray
    value: np.ndarray
    along: np.ndarray
    across: np.ndarray

    def deviator(self, triangle: np.ndarray, z: np.ndarray) -> np.ndarray:
        """D at the places z (r,) of triangles (r,)."""
        return self.value[triangle] + self.along[triangle] * z + self.across[triangle] * z.conj()


def lay_out(surface: Surface, field: CurvatureField, progress: Progress) -> TrianglePlanes:
    """The triangles of a surface and the deviators of `field` at its vertices in their planes."""
    m = len(surface.triangles)
    normal, _ = surface.face_normal_area
    corner = np.zeros((m, 3), complex)
    edge = np.ones((m, 3), complex)
    value, along, across = (np.zeros(m, complex) for _ in range(3))
    gap = np.nan_to_num(field.gap)
    d1, d2 = np.nan_to_num(field.d1), np.nan_to_num(field.d2)

    def block(first: int) -> None:
        rows = slice(first, first + BLOCK)
        vertex = surface.triangles[rows]
        a, b, c = (surface.vertices[vertex[:, k]] for k in range(3))
        x = b - a
        length = np.linalg.norm(x, axis=1)
        x /= np.maximum(length, np.finfo(float).tiny)[:, None]
        y = np.cross(normal[rows], x)
        zb = length.astype(complex)
        zc = np.einsum("rc,rc->r", c - a, x) + 1j * np.einsum("rc,rc->r", c - a, y)
        corner[rows, 1], corner[rows, 2] = zb, zc
        sides = np.stack([zb, zc - zb, -zc], axis=1)
        edge[rows] = _unit(sides)
        at = []
        for k in range(3):
            one, two = d1[vertex[:, k]], d2[vertex[:, k]]
            # The rotation in the polar decomposition of the projection between the planes.
            turn = np.einsum("rc,rc->r", one, x) + np.einsum("rc,rc->r", two, y)
            turn = turn + 1j * (np.einsum("rc,rc->r", one, y) - np.einsum("rc,rc->r", two, x))
            at.append(gap[vertex[:, k]] * _unit(turn) ** 2)
        value[rows] = at[0]
        # D_b - D_a = (B + C) zb and D_c - D_a = B zc + C conj(zc).
        slope = (at[1] - at[0]) / np.maximum(length, np.finfo(float).tiny)
        height = np.where(np.abs(zc.imag) > np.finfo(float).tiny, zc.imag, np.inf)
        rest = (at[2] - at[0] - slope * zc.real) / height
        along[rows] = 0.5 * (slope - 1j * rest)
        across[rows] = 0.5 * (slope + 1j * rest)

    run(block, range(0, m, BLOCK), progress)
    edge = edge.ravel()
    twin = surface.twin
    inner = twin >= 0
    turn = np.ones(3 * m, complex)
    turn[inner] = -edge[twin[inner]] * edge[inner].conj()
    return TrianglePlanes(corner, turn, value, along, across)


def _unit(values: np.ndarray) -> np.ndarray:
    size = np.abs(values)
    return np.divide(values, size, out=np.ones_like(values), where=size > 0)
