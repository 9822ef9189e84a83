"""What the experiments share: raw finds of a method on given operators, matched to the truth."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from surfaces import AnalyticSurface

import core
from core.curvature.from_normals import curvature_from_normals
from core.mesh.mending.repair import clean
from core.mesh.normals import vertex_normals
from core.umbilics.methods.shape_operators import face_deviators, zero_crossings

RAW = core.Settings(curvature="given", persistence=0.0, regions=False, merge=False)
"""A method alone: operators as they are, nothing cancelled, nothing merged."""


def raw(method: str, **changes: object) -> core.Settings:
    """Settings of a method alone."""
    return replace(RAW, method=method, **changes)


def paper_points(mesh: AnalyticSurface, parametrization: str) -> tuple[np.ndarray, np.ndarray]:
    """Positions (k, 3) and triangles (k,) by the paper's own test of each triangle alone."""
    surface, _ = clean(mesh.vertices, mesh.triangles)
    field = mesh.curvature_on(surface)
    triangle, weights, _ = zero_crossings(
        lambda rows: face_deviators(surface, field, rows, parametrization).values,
        len(surface.triangles),
    )
    corners = mesh.vertices[surface.source_vertex[surface.triangles[triangle]]]
    return np.einsum("kj,kji->ki", weights, corners), surface.source_triangle[triangle]


def operators(mesh: AnalyticSurface, kind: str) -> core.CurvatureField:
    """Shape operators of a mesh: "exact", "jets" or "normals"."""
    if kind == "exact":
        return mesh.curvature
    if kind == "normals":
        surface, _ = clean(mesh.vertices, mesh.triangles)
        field = curvature_from_normals(surface, vertex_normals(surface))
        order = np.argsort(surface.source_vertex)
        if len(order) != len(mesh.vertices):
            raise ValueError("a clean mesh was expected")
        return core.CurvatureField(
            field.k1[order] / surface.unit,
            field.k2[order] / surface.unit,
            field.d1[order],
            field.d2[order],
            field.normal[order],
            field.noise[order],
        )
    settings = core.Settings(persistence=0.0, regions=False)
    return core.detect(mesh.vertices, mesh.triangles, settings).curvature


def detect(
    mesh: AnalyticSurface, settings: core.Settings, field: core.CurvatureField | None = None
) -> core.Detection:
    """`core.detect` on an analytic mesh with given operators; no seams."""
    return core.detect(mesh.vertices, mesh.triangles, settings, given=field)


@dataclass(frozen=True)
class Match:
    """Found points against the true umbilics.

    Attributes
    ----------
    error:
        (t,) distance of each true umbilic to the nearest found point of its index, in edges;
        infinite where there is none within two edges.
    near:
        (t,) how many found points lie within two edges of each.
    spurious:
        Found points inside the region that are farther than two edges from every true one.
    outside:
        Found points outside the region.
    """

    error: np.ndarray
    near: np.ndarray
    spurious: int
    outside: int


def match(mesh: AnalyticSurface, points: np.ndarray, inside: np.ndarray | None = None) -> Match:
    """Compare points (k, 3) with the mesh's umbilics; `inside` (k,) restricts spurious ones."""
    count = len(mesh.umbilics)
    if inside is None:
        inside = np.ones(len(points), dtype=bool)
    if not len(points):
        return Match(np.full(count, np.inf), np.zeros(count, dtype=int), 0, 0)
    edge = local_edges(mesh)
    distance = np.linalg.norm(points[:, None] - mesh.umbilics.position[None], axis=2) / edge
    error = distance.min(axis=0)
    return Match(
        np.where(error <= 2.0, error, np.inf),
        (distance <= 2.0).sum(axis=0),
        int(np.count_nonzero(inside & (distance.min(axis=1) > 2.0))),
        int(np.count_nonzero(~inside)),
    )


def local_edges(mesh: AnalyticSurface) -> np.ndarray:
    """(t,) mean edge length around the vertex nearest to each true umbilic."""
    nearest = [
        np.linalg.norm(mesh.vertices - point, axis=1).argmin() for point in mesh.umbilics.position
    ]
    return mesh.local_edge[nearest]


def in_patch(points: np.ndarray, limit: float = 1.1) -> np.ndarray:
    """(k,) bool, whether points lie well inside the patch: |x|, |y| < limit."""
    return np.all(np.abs(points[:, :2]) < limit, axis=1)
