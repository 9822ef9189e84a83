"""The surface that is mapped: the cleaned input with features, refined where it is coarse."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np

from ....base.progress import Progress
from ....curvature.field import CurvatureField, field_from_deviators
from ....fields.transport import tangents
from ....mesh.creases import bent_half_edges, marked_half_edges
from ....mesh.repair import clean
from ....mesh.surface import Surface
from ..settings import RemeshSettings
from .chains import long_chains
from .decimation import SHARE, coarsened
from .subdivision import Triangles, freed, refined

# Edges are at most so many lengths of quads, and at least so many triangles are wanted.
LONGEST, FEWEST = 1.0, 3000
# Triangles wanted for each quad, between these bounds, and how many more are coarsened away.
PER_QUAD, MOST, LIMIT, SLACK = 8.0, 20_000, 60_000, 1.3
# Rounds of splitting: each halves the longest edges.
ROUNDS = 12
# Creases stand out of the spread of the angles between triangles by so many standard deviations,
# which the lower quarter of the angles tells: of a normal distribution it ends at 0.32.
OUTSTANDING, LOWER_QUARTER = 3.0, 0.3186
# Features are at least this long, in lengths of quads.
LEAST_FEATURE = 2.0


@dataclass(frozen=True)
class WorkingSurface:
    """What is mapped.

    Attributes
    ----------
    surface:
        Its `source_vertex` are its own rows, its `source_triangle` those of the input; origin
        and unit lead to the input's coordinates.
    field:
        Shape operators at its vertices, in its coordinates.
    feature:
        (3 m,) bool half-edges on features, both of each edge, borders not among them.
    fine:
        What it was coarsened from, in its coordinates; None where it was not.
    """

    surface: Surface
    field: CurvatureField
    feature: np.ndarray
    fine: Surface | None


def prepared(
    whole: Surface,
    curvature: CurvatureField,
    settings: RemeshSettings,
    sharp: np.ndarray | None,
    size: float,
) -> Triangles:
    """A cleaned input as triangles with the curvature (input rows) at its vertices and features.

    Parameters
    ----------
    sharp:
        (s, 2) pairs of input vertices whose edges are marked sharp, or None.
    size:
        Length of a quad's edge, in the coordinates of `whole`.
    """
    feature = np.zeros(3 * len(whole.triangles), bool)
    edges = features(whole, settings, sharp, size)
    feature[edges] = feature[whole.twin[edges]] = True
    return Triangles(
        whole.vertices,
        whole.triangles.astype(np.int64),
        _values(whole, curvature, feature),
        whole.source_triangle,
        feature,
    )


def working_surface(
    mesh: Triangles, whole: Surface, size: float, progress: Progress
) -> WorkingSurface:
    """The surface to map, of a connected piece of what was prepared: coarser where that is finer
    than a map needs, finer where it is coarser.

    Parameters
    ----------
    size:
        Length of a quad's edge, in the coordinates of `whole`.
    """
    a, b, c = (mesh.vertices[mesh.triangles[:, k]] for k in range(3))
    area = 0.5 * float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())
    most = int(np.clip(PER_QUAD * area / size**2, MOST, LIMIT))
    fine = None
    if len(mesh.triangles) > SLACK * most:
        fine = mesh
        mesh = coarsened(mesh, most, progress)
    coarsest, finest = (1.5 * float(np.sqrt(area / SHARE / count)) for count in (FEWEST, LIMIT))
    longest = max(min(LONGEST * size, coarsest), finest)
    mesh = refined(mesh, longest, ROUNDS)
    surface, _ = clean(mesh.vertices, mesh.triangles)
    mesh = freed(replace(mesh, feature=mesh.feature | (surface.twin < 0)), surface.border)
    return _assembled(mesh, whole, fine)


def features(
    surface: Surface, settings: RemeshSettings, sharp: np.ndarray | None, size: float
) -> np.ndarray:
    """(e,) int64 one half-edge of each edge on a feature inside the surface."""
    found = [np.zeros(0, np.int64)]
    if settings.feature_angle < 180.0:
        bent = bent_half_edges(surface, max(settings.feature_angle, _spread(surface)))
        found.append(long_chains(surface, bent, LEAST_FEATURE * size))
    if settings.align_sharp:
        marked = marked_half_edges(surface, sharp)
        found.append(marked[surface.twin[marked] >= 0])
    edges = np.concatenate(found)
    return np.unique(np.minimum(edges, surface.twin[edges]))


def _spread(surface: Surface) -> float:
    """Degrees beyond which an edge of a rough or coarse surface is a crease."""
    inner = np.flatnonzero(np.arange(len(surface.twin)) < surface.twin)
    if not len(inner):
        return 0.0
    normal, _ = surface.face_normal_area
    cosine = np.einsum("ec,ec->e", normal[inner // 3], normal[surface.twin[inner] // 3])
    angle = np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))
    return float(OUTSTANDING / LOWER_QUARTER * np.quantile(angle, 0.25))


def _assembled(mesh: Triangles, whole: Surface, fine: Triangles | None) -> WorkingSurface:
    surface, _ = clean(mesh.vertices, mesh.triangles)
    values = mesh.values[surface.source_vertex]
    feature = mesh.feature & (surface.twin >= 0)
    # The coordinates of the input: those of `whole` first, then its own.
    surface = replace(
        surface,
        source_vertex=np.arange(len(surface.vertices)),
        source_triangle=mesh.source[surface.source_triangle],
        origin=surface.origin * whole.unit + whole.origin,
        unit=surface.unit * whole.unit,
    )
    field = _field(values, surface.unit / whole.unit)
    return WorkingSurface(surface, field, feature, _fine(fine, surface, whole))


def _fine(mesh: Triangles | None, surface: Surface, whole: Surface) -> Surface | None:
    """The finer surface in the coordinates of the one that is mapped."""
    if mesh is None:
        return None
    fine, _ = clean(mesh.vertices, mesh.triangles)
    place = fine.vertices * fine.unit + fine.origin
    origin = (surface.origin - whole.origin) / whole.unit
    return replace(
        fine,
        vertices=(place - origin) / (surface.unit / whole.unit),
        source_triangle=mesh.source[fine.source_triangle],
        origin=surface.origin,
        unit=surface.unit,
    )


def _values(whole: Surface, curvature: CurvatureField, feature: np.ndarray) -> np.ndarray:
    """(n, 13) normals, shape operators and noise at the vertices of `whole`, in its unit; those
    on creases have none, what was fitted across a crease says nothing."""
    rows = whole.source_vertex
    value = {item.name: getattr(curvature, item.name)[rows] for item in fields(CurvatureField)}
    tensor = sum(
        np.nan_to_num(value[k])[:, None, None]
        * np.nan_to_num(value[d])[:, :, None]
        * np.nan_to_num(value[d])[:, None, :]
        for k, d in (("k1", "d1"), ("k2", "d2"))
    )
    corners = whole.triangles.ravel()
    tensor[corners[feature]] = 0.0
    noise = value["noise"][:, None] * whole.unit
    return np.hstack([np.nan_to_num(value["normal"]), tensor.reshape(-1, 9) * whole.unit, noise])


def _field(values: np.ndarray, unit: float) -> CurvatureField:
    """The shape operators that `_values` holds, in a unit so much longer."""
    normal = values[:, :3]
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    normal = np.where(length > 1e-9, normal / np.maximum(length, 1e-9), [0.0, 0.0, 1.0])
    tensor = values[:, 3:12].reshape(-1, 3, 3) * unit
    e1, e2 = tangents(normal)
    s11 = np.einsum("ni,nij,nj->n", e1, tensor, e1)
    s22 = np.einsum("ni,nij,nj->n", e2, tensor, e2)
    s12 = np.einsum("ni,nij,nj->n", e1, tensor, e2)
    deviator = (s11 - s22) + 2j * s12
    return field_from_deviators(0.5 * (s11 + s22), deviator, normal, values[:, 12] * unit)
