"""The record of an analytic surface and its operators from first and second derivatives."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from core import CurvatureField
from core.mesh.surface import Surface


@dataclass(frozen=True)
class UmbilicPoints:
    """Exact umbilics: position (k, 3), index (k,), kind (k,) "star", "lemon" or "flat"."""

    position: np.ndarray
    index: np.ndarray
    kind: np.ndarray

    def __len__(self) -> int:
        return len(self.index)

    @classmethod
    def none(cls) -> UmbilicPoints:
        return cls(np.zeros((0, 3)), np.zeros(0), np.zeros(0, dtype="<U7"))

    @classmethod
    def of(cls, rows: list[tuple[tuple[float, float, float], float, str]]) -> UmbilicPoints:
        """From rows of (position, index, kind)."""
        position, index, kind = zip(*rows, strict=True)
        return cls(np.array(position, float), np.array(index, float), np.array(kind))


@dataclass(frozen=True)
class AnalyticSurface:
    """A mesh inscribed in a known surface.

    Attributes
    ----------
    vertices, triangles:
        (n, 3) float64 and (m, 3) int64, outward winding (upward for graphs).
    k1, k2, d1, d2, normal:
        Exact principal curvatures (n,), directions (n, 3) and normals (n, 3) at the vertices,
        d1 x d2 = normal.
    umbilics:
        The isolated umbilics of the surface over the domain that was meshed.
    everywhere:
        True where every point is an umbilic (sphere, plane).
    """

    name: str
    vertices: np.ndarray
    triangles: np.ndarray
    k1: np.ndarray
    k2: np.ndarray
    d1: np.ndarray
    d2: np.ndarray
    normal: np.ndarray
    umbilics: UmbilicPoints
    everywhere: bool = False

    @property
    def curvature(self) -> CurvatureField:
        """The exact operators in the form that the core takes."""
        noise = np.full(len(self.k1), np.nan)
        return CurvatureField(self.k1, self.k2, self.d1, self.d2, self.normal, noise)

    def curvature_on(self, surface: Surface) -> CurvatureField:
        """The exact operators at the vertices of the cleaned mesh, in its unit box."""
        rows, unit = surface.source_vertex, surface.unit
        return CurvatureField(
            self.k1[rows] * unit,
            self.k2[rows] * unit,
            self.d1[rows],
            self.d2[rows],
            self.normal[rows],
            np.full(len(rows), np.nan),
        )

    @property
    def edge_length(self) -> float:
        """Mean length of the triangles' sides."""
        return float(np.linalg.norm(self._sides(), axis=2).mean())

    @property
    def local_edge(self) -> np.ndarray:
        """(n,) mean length of the sides of the triangles around each vertex."""
        length = np.linalg.norm(self._sides(), axis=2)
        both = length + np.roll(length, 1, axis=1)  # the two sides that meet in each corner
        corner = self.triangles.ravel()
        total = np.bincount(corner, both.ravel(), minlength=len(self.vertices))
        return total / np.maximum(2 * np.bincount(corner, minlength=len(self.vertices)), 1)

    def _sides(self) -> np.ndarray:
        corners = self.vertices[self.triangles]
        return np.roll(corners, -1, axis=1) - corners


def tangent_frame(normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Some orthonormal e1, e2 (n, 3) with e1 x e2 = normal."""
    axis = np.zeros_like(normal)
    axis[np.arange(len(normal)), np.abs(normal).argmin(axis=1)] = 1.0
    e1 = np.cross(axis, normal)
    e1 /= np.linalg.norm(e1, axis=1)[:, None]
    return e1, np.cross(normal, e1)


def operators(
    gradient: np.ndarray, hessian: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """k1, k2, d1, d2, normal of the level set of a function, normal along its gradient.

    The shape operator is the derivative of the unit normal: the Hessian (n, 3, 3) cut down to
    the tangent plane and divided by the length of the gradient (n, 3).
    """
    length = np.linalg.norm(gradient, axis=1)
    normal = gradient / length[:, None]
    e1, e2 = tangent_frame(normal)
    s11 = np.einsum("ni,nij,nj->n", e1, hessian, e1) / length
    s12 = np.einsum("ni,nij,nj->n", e1, hessian, e2) / length
    s22 = np.einsum("ni,nij,nj->n", e2, hessian, e2) / length
    mean, half_gap = 0.5 * (s11 + s22), np.hypot(0.5 * (s11 - s22), s12)
    angle = 0.5 * np.arctan2(2.0 * s12, s11 - s22)
    d1 = np.cos(angle)[:, None] * e1 + np.sin(angle)[:, None] * e2
    return mean + half_gap, mean - half_gap, d1, np.cross(normal, d1), normal
