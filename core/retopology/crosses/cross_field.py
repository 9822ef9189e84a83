"""A smooth cross field: four directions at right angles, along the curvature where it has any.

A cross is kept as the fourth power u of any of its directions, written as a complex number in
the tangent frame of a vertex, so that all four give the same u (Palacios & Zhang 2007). The field
minimizes

    sum over edges w_ij |u_i - T_ij u_j|^2  +  sum over vertices (c_i A_i / l^2) |u_i - g_i|^2

with cotangent weights w, transport T by the smallest rotation between the normals, confidence c,
vertex areas A and g the principal directions or those of a feature; l is the length over which
the field is smoothed. One sparse Hermitian solve; after Knoeppel et al. 2013.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse

from ...base.progress import Progress
from ...curvature.field import CurvatureField
from ...fields.connection import connection_laplacian, weights_and_areas
from ...fields.directions import DirectionField
from ...fields.multigrid import Multigrid, solve
from ...fields.transport import tangents
from ...mesh.half_edges import ends_of
from ...mesh.normals import vertex_normals
from ...mesh.surface import Surface
from ..features import Features, find_features, fourth_power, wanted_directions
from ..field.near_pairs import without_near_pairs
from ..settings import GuidanceSettings
from .dipoles import without_dipoles
from .in_triangles import on_faces, told_by_triangles
from .least_smoothing import QUAD_EDGE, Smoothed, least_smoothed
from .smoothing import (
    CREST_WEIGHT,
    FIXED_WEIGHT,
    LEAST_CONFIDENCE,
    curvature_data,
    per_component,
    smoothing_lengths,
)

# Mean confidence below which a component has no direction of its own: its smoothest field is
# taken then, by this many steps of inverse iteration.
NO_DIRECTION, INVERSE_STEPS = 1e-3, 5


@dataclass(frozen=True)
class CrossField:
    """Crosses on a `Surface` of n vertices and m triangles.

    Attributes
    ----------
    direction:
        (n, 3) float64 one unit direction of each vertex's cross; the others follow by right
        angles about `normal`.
    normal:
        (n, 3) float64 unit normals.
    confidence:
        (n,) float64 how much the curvature says there, 0 to 1; 1 on features.
    strength:
        (n,) float64 length of u: near 0 around singularities and where directions compete.
    face_direction:
        (m, 3) float64 one unit direction of each triangle's cross, in its plane.
    triangle_index:
        (m,) float64 index of the field in each triangle, a multiple of one quarter. Over a
        closed component they sum to its Euler characteristic.
    smoothing:
        Length over which the field was smoothed, median over the vertices, in the coordinates
        of the surface.
    astray:
        How many poles the field of the triangles lacks, and has that were not planned.
    in_triangles:
        (m,) bool, True on components whose field the triangles tell, not the vertices: there
        `triangle_index` is of triangles beside the vertices around which `face_direction` turns.
        None for nowhere.
    """

    direction: np.ndarray
    normal: np.ndarray
    confidence: np.ndarray
    strength: np.ndarray
    face_direction: np.ndarray
    triangle_index: np.ndarray
    smoothing: float
    astray: int = 0
    in_triangles: np.ndarray | None = None


def cross_field(
    surface: Surface,
    field: CurvatureField,
    settings: GuidanceSettings,
    progress: Progress,
    *,
    sharp: np.ndarray | None = None,
    undirected: np.ndarray | None = None,
    features: Features | None = None,
    on_outlines: bool = True,
) -> CrossField:
    """The cross field of a surface.

    Parameters
    ----------
    surface:
        The surface; n vertices, m triangles.
    field:
        Shape operators at its vertices, in its coordinates.
    settings:
        Smoothness and what to align to.
    sharp:
        (s, 2) pairs of input vertices whose edges are marked sharp.
    undirected:
        (m,) bool triangles of regions where the directions mean nothing.
    features:
        What to run along, if it is known; else hard features by the settings.
    on_outlines:
        Whether vertices of tessellated parts may lie on outlines alone, so that triangles have to
        tell the field.
    """
    progress.step(0.0)
    if features is None:
        features = find_features(surface, settings, sharp)
    normal = _frame_normals(surface, field, features)
    e1, e2 = tangents(normal)
    axis = np.ascontiguousarray((e1 + 1j * e2).T)
    confidence, data = curvature_data(surface, field, normal, axis, undirected, 4)
    weights, area = weights_and_areas(surface)
    matrix, pull = connection_laplacian(surface, weights, axis, 4)
    progress.step(0.15)
    feature, wanted = wanted_directions(surface, features, axis)
    problem = _Problem(
        surface, normal, axis, confidence, data, area, matrix, pull, features, feature, wanted
    )
    part = progress.part("Solving", 0.15, 0.9)
    if isinstance(settings.smoothness, str):
        weight = np.where(feature, 0.0, confidence * area)
        # What is drawn must not change the field elsewhere: the surface alone decides.
        plain = replace(problem, features=features.hard)
        found = least_smoothed(surface, plain.smoothed, weight, part)
        if len(features.crest_vertex):
            found = problem.smoothed(found.length, progress.quiet())
    else:
        found = problem.smoothed(smoothing_lengths(surface, area, settings.smoothness), part)
    u = found.strength * fourth_power(axis, found.direction)
    part = progress.part("Carrying to faces", 0.9, 1.0)
    face_direction, _ = on_faces(surface, u, axis, part)
    told = None
    if on_outlines:
        told = told_by_triangles(
            surface, features, field, axis, confidence * data / found.length**2, found.index
        )
    return CrossField(
        direction=found.direction,
        normal=normal,
        confidence=np.where(feature, np.abs(wanted), confidence),
        strength=found.strength,
        face_direction=face_direction if told is None else told.over(face_direction),
        triangle_index=found.index if told is None else told.index,
        smoothing=float(np.median(found.length)),
        in_triangles=None if told is None else told.there,
    )


@dataclass(frozen=True)
class _Problem:
    """What is smoothed on a surface, by whatever length."""

    surface: Surface
    normal: np.ndarray
    axis: np.ndarray
    confidence: np.ndarray
    data: np.ndarray
    area: np.ndarray
    matrix: sparse.csr_array
    pull: np.ndarray
    features: Features
    feature: np.ndarray
    wanted: np.ndarray

    def smoothed(self, length: np.ndarray, progress: Progress) -> Smoothed:
        """The field smoothed over lengths (n,), without pairs that stand closer than it
        resolves."""
        surface, pull, feature = self.surface, self.pull, self.feature
        weight = np.maximum(self.confidence, LEAST_CONFIDENCE) * self.area / length**2
        held = np.abs(self.wanted) * feature
        right = weight * self.data
        weight = np.where(feature, FIXED_WEIGHT * pull * held, weight)
        unit = self.wanted / np.maximum(np.abs(self.wanted), 1e-12)
        right = np.where(feature, weight * unit, right)
        crest = self.features.crest_vertex
        extra = CREST_WEIGHT * pull[crest] * self.features.crest_weight
        weight[crest] += extra
        across = fourth_power(self.axis[:, crest], self.features.crest_direction)
        right[crest] += extra * across
        diagonal = (weight + 1e-12 * pull).astype(complex)
        system = (self.matrix + sparse.diags_array(diagonal)).tocsr()
        u = solve(system, right, progress.part("Solving", 0.0, 0.8))
        u = _smoothest(
            surface, system, u, self.confidence, self.area, feature, progress.quiet()
        )
        e1, e2 = self.axis.real.T, self.axis.imag.T
        edge = smoothing_lengths(surface, self.area, QUAD_EDGE)
        apart = float(np.median(np.minimum(length, edge)))
        u, index = without_dipoles(
            surface,
            self.matrix,
            u,
            feature,
            self.normal,
            lambda u: _direction(u, e1, e2),
            apart,
            progress.part("Joining singularities", 0.8, 0.9),
        )
        crosses = DirectionField(_direction(u, e1, e2), self.normal, np.abs(u), symmetry=4)
        sure = np.where(feature, 1.0, self.confidence)
        part = progress.part("Joining singularities", 0.9, 1.0)
        direction, index = without_near_pairs(
            surface, crosses, index, sure, feature, apart, part
        )
        off = np.angle(fourth_power(self.axis, direction) * self.data.conj()) / 4.0
        return Smoothed(direction, crosses.magnitude, index, length, np.degrees(np.abs(off)))


def _frame_normals(surface: Surface, field: CurvatureField, features: Features) -> np.ndarray:
    """(n, 3) unit normals of the frames: those of the fits.

    The mesh's own turn so wildly on a rough surface that transport between them makes
    singularities, however smooth the field is. But on hard features fits see one side only; there
    they are the mesh's.
    """
    normal = field.normal.copy()
    on = np.unique(np.concatenate(ends_of(surface.triangles, features.half_edge)))
    normal[on] = vertex_normals(surface)[on]
    return normal


def _smoothest(
    surface: Surface,
    system: sparse.csr_array,
    u: np.ndarray,
    confidence: np.ndarray,
    area: np.ndarray,
    feature: np.ndarray,
    progress: Progress,
) -> np.ndarray:
    """u, made the smoothest field on components that have no direction of their own."""
    mean = per_component(surface, confidence * area) / per_component(surface, area)
    aligned = per_component(surface, feature.astype(float)) > 0
    free = ((mean < NO_DIRECTION) & ~aligned)[surface.component]
    if not free.any():
        return u
    rows = np.flatnonzero(free)
    part = system[rows][:, rows].tocsr()
    value = u[rows]
    component = surface.component[rows]
    precondition = Multigrid(part, progress)
    for _ in range(INVERSE_STEPS):
        value = solve(part, area[rows] * value, progress, precondition=precondition)
        size = np.sqrt(np.bincount(component, weights=area[rows] * np.abs(value) ** 2))
        value /= np.maximum(size, np.finfo(float).tiny)[component]
    u = u.copy()
    scale = np.bincount(component, weights=np.abs(value)) / np.maximum(np.bincount(component), 1)
    u[rows] = value / np.maximum(scale, np.finfo(float).tiny)[component]
    return u


def _direction(u: np.ndarray, e1: np.ndarray, e2: np.ndarray) -> np.ndarray:
    angle = np.angle(u) / 4.0
    return np.cos(angle)[:, None] * e1 + np.sin(angle)[:, None] * e2
