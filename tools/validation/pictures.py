"""Panels of the installed extension, filled from the experiments."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from bl_ext.user_default.umbilics.operators.command_line.files import importers
from bl_ext.user_default.umbilics.operators.command_line.pictures import panels
from bl_ext.user_default.umbilics.operators.command_line.pictures.panels import (
    Panel,
    view_of,
    write,
)
from bl_ext.user_default.umbilics.operators.mesh.fetch import unit_vectors
from bl_ext.user_default.umbilics.operators.mesh.fingerprint import Fingerprint, metric_of
from bl_ext.user_default.umbilics.operators.mesh.read import MeshArrays, read_mesh
from surfaces import AnalyticSurface

import core
from core.curvature.elliptic_part import opened_elliptic_part
from core.mesh.mending.repair import clean

__all__ = ["Panel", "arrays_of", "by_index", "from_above", "panels", "read", "view_of", "write"]


def arrays_of(vertices: np.ndarray, triangles: np.ndarray) -> MeshArrays:
    """Arrays of a mesh that was not read from a scene."""
    none = np.empty((0, 2), dtype=np.int32)
    rows = np.arange(len(triangles))
    return MeshArrays(
        vertices=vertices,
        triangles=triangles,
        loop_triangle=rows,
        polygon=rows,
        polygon_count=len(triangles),
        matrix=np.eye(4),
        seams=none,
        sharp=none,
        uv=None,
        given=None,
        fingerprint=Fingerprint({}, metric_of(np.eye(4))),
    )


def read(path: Path) -> tuple[MeshArrays, str]:
    """The first mesh of a file with n-gons triangulated, and the axis that points up in it."""
    opened = importers.open_file(str(path), "")
    return read_mesh(opened.objects[0]), opened.up


def from_above(
    mesh: AnalyticSurface, found: core.Detection, umbilics: core.Umbilics, title: str
) -> Panel:
    """A panel of a graph patch laid flat: the plane of x and y, without the relief."""
    field = found.curvature
    arrays = arrays_of(_flat(mesh.vertices), mesh.triangles)
    up = np.tile([0.0, 0.0, 1.0], (len(mesh.vertices), 1))
    along = unit_vectors(_flat(field.d1))
    shown = core.CurvatureField(field.k1, field.k2, along, np.cross(up, along), up, field.noise)
    return Panel(
        [title],
        arrays,
        shown,
        laid_flat(umbilics),
        # The view "from the front" of a mesh that has y up is the one along z.
        view_of(arrays, "Y", turn=-28.0, lift=0.0),
        true_places=_flat(mesh.umbilics.position),
        enlarged=1.2,
        relief=False,
    )


def laid_flat(umbilics: core.Umbilics) -> core.Umbilics:
    """The umbilics of a graph patch in the plane of x and y."""
    return replace(
        umbilics,
        position=_flat(umbilics.position),
        normal=np.tile([0.0, 0.0, 1.0], (len(umbilics), 1)),
        separatrix=unit_vectors(_flat(umbilics.separatrix)),
    )


def _flat(points: np.ndarray) -> np.ndarray:
    return points * np.array([1.0, 1.0, 0.0])


def by_index(umbilics: core.Umbilics) -> core.Umbilics:
    """The same points, shown as star or lemon by the sign of their index alone."""
    kind = np.where(umbilics.index < 0, core.KINDS[0], core.KINDS[1])
    return replace(umbilics, kind=kind)


ELLIPTIC = (0.62, 0.80, 0.58, 1.0)


def elliptic_rows(
    vertices: np.ndarray, triangles: np.ndarray, found: core.Detection, passes: int
) -> np.ndarray:
    """The triangles inside the elliptic part, opened by so many passes."""
    surface, _ = clean(vertices, triangles)
    types = found.surface_type[surface.source_vertex]
    inside = opened_elliptic_part(surface, types, passes)
    return surface.source_triangle[inside[surface.triangles].all(axis=1)]
