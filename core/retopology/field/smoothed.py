"""Smoothed principal directions with the singularities of the curvature's own."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy import sparse

from ...base.progress import Progress
from ...curvature.field import CurvatureField
from ...curvature.noise import field_noise
from ...fields.connection import connection_laplacian, weights_and_areas
from ...fields.directions import DirectionField
from ...fields.frames import principal_directions
from ...fields.multigrid import solve
from ...fields.transport import tangents
from ...fields.winding import certified_index
from ...mesh.normals import vertex_normals
from ...mesh.surface import Surface
from ..crosses.smoothing import (
    FIXED_WEIGHT,
    LEAST_CONFIDENCE,
    curvature_data,
    smoothing_lengths,
    smoothness_of,
)
from .agreement import Agreement, with_index
from .simplified import STIFF, SimplifiedField

# Degrees by which directions may err without their lines being smoothed. With it a scanned bunny is
# smoothed by 0.52 and a rocker arm by 0.46, where 0.5 and 0.4 were chosen by eye before; clean
# meshes, a hand and a cow not at all.
STEADY = 1.0


def smoothness_by_noise(surface: Surface, field: CurvatureField, scale: float) -> float:
    """Smoothness that brings the median error of the directions down to `STEADY`.

    Fits apart by their radius err independently, so that over a length of so many radii the
    error falls in proportion.

    Parameters
    ----------
    field:
        Shape operators at the vertices of the surface, in its coordinates.
    scale:
        Median radius of the fits, in these coordinates; not used where the operators come without
        an error, which is then estimated from how neighbours differ.
    """
    gap, noise = field.gap, field.noise
    if not np.isfinite(noise).any():
        # Of operators that were made of normals or given.
        noise, radius = field_noise(surface, field.k1, field.k2, field.d1, field.normal)
        scale = float(np.median(radius))
    known = np.isfinite(noise) & np.isfinite(gap) & (gap > 0.0)
    if not known.any() or not np.isfinite(scale):
        return 0.0
    # The angle is half the deviator's.
    error = float(np.degrees(np.median(0.5 * noise[known] / gap[known])))
    return smoothness_of(surface, scale * (error / STEADY - 1.0))


def smoothed_field(
    surface: Surface,
    simple: SimplifiedField,
    smoothness: float,
    regions: Sequence[np.ndarray],
    progress: Progress,
    held: np.ndarray | None = None,
) -> Agreement:
    """The directions of a simplified field, smoothed, with its own index in every triangle outside
    the regions. Smoothing alone moves singularities about, makes some and loses others.

    Parameters
    ----------
    smoothness:
        `GuidanceSettings.line_smoothness`.
    regions:
        For each region the rows of its triangles.
    held:
        (n,) bool vertices whose directions are not smoothed.
    """
    undirected = np.zeros(len(surface.triangles), bool)
    for rows in regions:
        undirected[rows] = True
    part = progress.part("Smoothing the lines", 0.0, 0.5)
    smooth, index = smoothed_lines(surface, simple.curvature, smoothness, part, undirected, held)
    wanted = np.where(undirected, index, simple.index)
    for rows in regions:
        # Within a region the sum alone counts; what it lacks may turn up anywhere in it.
        lacking = int(np.rint(2.0 * (simple.index[rows].sum() - index[rows].sum())))
        at = rows[np.linspace(0, len(rows) - 1, abs(lacking)).astype(np.int64)]
        np.add.at(wanted, at, 0.5 * np.sign(lacking))
    stiffness = np.zeros(len(surface.vertices))
    stiffness[surface.triangles[simple.index != 0.0]] = STIFF
    if held is not None:
        stiffness[held] = STIFF
    part = progress.part("Simplifying the field", 0.5, 1.0)
    return with_index(surface, smooth, wanted, np.zeros(len(wanted)), stiffness, part)


def smoothed_lines(
    surface: Surface,
    field: CurvatureField,
    smoothness: float,
    progress: Progress,
    undirected: np.ndarray | None = None,
    held: np.ndarray | None = None,
) -> tuple[DirectionField, np.ndarray]:
    """The principal directions as a smooth line field, and its index (m,) in each triangle.

    As `cross_field.cross_field`, with second powers: the families stay apart. Features play no
    part, since either family may run along them. The magnitude of the result is the length of u.

    Parameters
    ----------
    held:
        (n,) bool vertices whose directions stay as they are.
    """
    normal = vertex_normals(surface)
    e1, e2 = tangents(normal)
    axis = np.ascontiguousarray((e1 + 1j * e2).T)
    confidence, data = curvature_data(surface, field, normal, axis, undirected, 2)
    weights, area = weights_and_areas(surface)
    matrix, pull = connection_laplacian(surface, weights, axis, 2)
    smoothing = smoothing_lengths(surface, area, smoothness)
    weight = np.maximum(confidence, LEAST_CONFIDENCE) * area / smoothing**2
    if held is not None:
        weight = np.where(held, FIXED_WEIGHT * pull, weight)
    system = (matrix + sparse.diags_array((weight + 1e-12 * pull).astype(complex))).tocsr()
    u = solve(system, weight * data, progress.part("Smoothing the lines", 0.0, 0.8))
    gap = np.abs(u)
    cosine, sine = principal_directions(u.real, u.imag, gap)
    smooth = DirectionField(cosine[:, None] * e1 + sine[:, None] * e2, normal, gap)
    part = progress.part("Counting", 0.8, 1.0)
    return smooth, certified_index(surface, smooth.direction, smooth.across, part)
