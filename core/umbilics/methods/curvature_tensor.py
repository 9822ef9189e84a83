"""Method C: the curvature tensor interpolated over a conformal unfolding of the surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...base.progress import Progress
from ...base.unit import phase
from ...curvature.field import CurvatureField
from ...fields.frames import side_axes
from ...fields.transport import as_complex, carried, tangents
from ...mesh.surface import Surface
from ...mesh.unfolding.charts import (
    Charts,
    charts_from_seams,
    charts_from_uv,
    corner_uv,
    scaled_to_area,
    unfold,
)
from ...mesh.unfolding.cuts import opened_to_disks
from ...mesh.unfolding.lscm import flattened
from .raw import RawUmbilics

# A triangle is called sheared when its plane image is this many times longer one way than the
# other relative to the mesh, and shrunken when lengths fall below this part of the chart's mean.
SHEARED = 3.0
SHRUNKEN = 0.02


@dataclass(frozen=True)
class Unfolding:
    """Charts in the plane and how they distort.

    Attributes
    ----------
    charts:
        The cut surface, c chart vertices and m triangles.
    place:
        (c,) complex places of the chart vertices.
    similarity, shear:
        (m,) complex p, q of the affine map z -> p z + q conj(z) of each triangle from its own
        plane (see `core.mesh.unfolding.lscm.flattened`) into the chart's; q = 0 where it is
        conformal, and |q| > |p| where the triangle is flipped. 0 for triangles without area.
    """

    charts: Charts
    place: np.ndarray
    similarity: np.ndarray
    shear: np.ndarray


def unfolded_along_seams(
    surface: Surface, seams: np.ndarray, progress: Progress | None = None, cut: bool = False
) -> Unfolding:
    """Unfold the pieces between seams, (s, 2) pairs of input vertices, conformally.

    With `cut` they are first cut further, see `opened_to_disks`. Raises `ChartError` where a
    piece is not a disk.
    """
    charts = charts_from_seams(surface, seams)
    progress = progress or Progress()
    if cut:
        charts = opened_to_disks(surface, charts, progress.part("Cutting", 0.0, 0.3))
        progress = progress.part("Unfolding", 0.3, 0.6)
    return _measured(surface, charts, unfold(surface, charts, progress))


def unfolded_by_uv(
    surface: Surface, input_triangles: np.ndarray, uv: np.ndarray, conformal: bool = False
) -> Unfolding:
    """Take the islands of a UV map (t, 3, 2) as they lie, or with `conformal` unfold them anew.

    Raises `ChartError` where an island to be unfolded is not a disk and `InvalidMeshError` on a
    map of another shape.
    """
    corner = corner_uv(surface, input_triangles, uv)
    charts = charts_from_uv(surface, corner)
    if conformal:
        return _measured(surface, charts, unfold(surface, charts))
    place = np.empty(len(charts.vertex), dtype=complex)
    place[charts.corners] = corner
    return _measured(surface, charts, scaled_to_area(surface, charts, place))


def _measured(surface: Surface, charts: Charts, place: np.ndarray) -> Unfolding:
    flat = flattened(surface.vertices, surface.triangles)
    side = np.roll(flat, -2, axis=1) - np.roll(flat, -1, axis=1)
    doubled = (np.conj(side[:, 0]) * side[:, 1]).imag
    factor = np.divide(0.5, doubled, out=np.zeros_like(doubled), where=doubled > 0)
    image = place[charts.corners]
    # Derivatives of the linear interpolation: d/dz of a corner's weight is -i conj(side) / 4A.
    similarity = -1j * factor * (np.conj(side) * image).sum(axis=1)
    shear = 1j * factor * (side * image).sum(axis=1)
    return Unfolding(charts, place, similarity, shear)


def detect_by_curvature_tensor(
    surface: Surface,
    curvature: CurvatureField,
    unfolding: Unfolding,
    progress: Progress | None = None,
) -> RawUmbilics:
    """Zeros of the deviator that is linear in each triangle of the plane.

    Each chart vertex carries its operator into the plane by the mean, weighted by area, of the
    maps of the triangles around it: their similarity part turns the principal directions, and
    the curvatures stay. Within a chart neighbours share these values, so a zero belongs to
    exactly one triangle; barycentric coordinates bring it back to the surface.

    Parameters
    ----------
    surface:
        n vertices, m triangles.
    curvature:
        Shape operators at the surface's vertices.
    unfolding:
        From `unfolded_along_seams` or `unfolded_by_uv`.
    """
    progress = progress or Progress()
    charts = unfolding.charts
    turned, _ = vertex_maps(surface, curvature.normal, unfolding)
    progress.step(0.5)
    e1, e2 = tangents(curvature.normal)
    first = as_complex(curvature.d1, e1, e2)
    deviator = curvature.gap[charts.vertex] * (first[charts.vertex] * phase(turned)) ** 2
    triangle, barycentric, index = zeros_in_triangles(deviator[charts.corners])
    return RawUmbilics(
        triangle=triangle,
        barycentric=barycentric,
        index=index,
        vertex=np.full(len(triangle), -1, dtype=np.int64),
        conformal_scale=_vertex_scale(surface, unfolding),
        warnings=_distortion_warnings(unfolding),
    )


def zeros_in_triangles(
    deviator: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Where a deviator that is linear in each triangle vanishes.

    `deviator` (m, 3) complex at the corners. Returns rows (k,), barycentric weights (k, 3) and
    indices (k,): plus or minus one half. Whether a triangle holds a zero is told from how far
    the argument turns along its sides, which neighbours see alike: a zero on a shared side
    counts once.
    """
    # A corner that is an umbilic itself has no argument: it is given one that all see alike.
    nudged = np.where(deviator == 0, 1.0, deviator)
    product = np.roll(nudged, -1, axis=1) * np.conj(nudged)
    jump = np.angle(product)
    # Half a turn is the same both ways along a side; its sign is told from the start's half
    # plane, so that the two neighbours see opposite ones.
    half_turn = (product.imag == 0) & (product.real < 0)
    lower = (nudged.imag < 0) | ((nudged.imag == 0) & (nudged.real < 0))
    jump = np.where(half_turn, np.where(lower, np.pi, -np.pi), jump)
    index = 0.5 * np.rint(jump.sum(axis=1) / (2.0 * np.pi))
    rows = np.flatnonzero(index)
    t = deviator[rows]
    weight = (np.conj(np.roll(t, -1, axis=1)) * np.roll(t, -2, axis=1)).imag
    weight = np.maximum(weight * np.sign(index[rows])[:, None], 0.0)
    weight = np.where((t == 0).any(axis=1)[:, None], t == 0, weight)
    total = weight.sum(axis=1, keepdims=True)
    even = np.full_like(weight, 1.0 / 3.0)
    return rows, np.where(total > 0, weight / np.where(total > 0, total, 1.0), even), index[rows]


def vertex_maps(
    surface: Surface, normal: np.ndarray, unfolding: Unfolding
) -> tuple[np.ndarray, np.ndarray]:
    """The map of the surface to the plane at each chart vertex: the mean, weighted by area, of
    those of the triangles around it.

    Returns
    -------
    similarity, shear:
        (c,) complex128 p, q of z -> p z + q conj(z) from the tangent frame `tangents(normal)`,
        up to a positive factor that they share.
    """
    charts = unfolding.charts
    face_normal, area = surface.face_normal_area
    x, y = side_axes(surface)
    e1, _ = tangents(normal)
    similarity, shear = np.zeros((2, len(charts.vertex)), dtype=complex)
    for k in range(3):
        vertex, chart_vertex = surface.triangles[:, k], charts.corners[:, k]
        laid = carried(e1[vertex], normal[vertex], face_normal)
        unit = as_complex(laid, x, y)
        for total, part in (
            (similarity, area * unfolding.similarity * unit),
            (shear, area * unfolding.shear * unit.conj()),
        ):
            total += np.bincount(chart_vertex, part.real, minlength=len(total))
            total += 1j * np.bincount(chart_vertex, part.imag, minlength=len(total))
    return similarity, shear


def _vertex_scale(surface: Surface, unfolding: Unfolding) -> np.ndarray:
    """(n,) length in the plane per length on the surface: the root of the ratio of the areas
    around each vertex, over all charts that it belongs to."""
    n = len(surface.vertices)
    ratio = np.abs(np.abs(unfolding.similarity) ** 2 - np.abs(unfolding.shear) ** 2)
    area = surface.face_normal_area[1]
    corner = surface.triangles.ravel()
    plane = np.bincount(corner, np.repeat(area * ratio, 3), minlength=n)
    true = surface.vertex_area
    return np.sqrt(np.divide(plane, true, out=np.full(n, np.nan), where=true > 0))


def _distortion_warnings(unfolding: Unfolding) -> list[str]:
    similarity, shear = np.abs(unfolding.similarity), np.abs(unfolding.shear)
    known = similarity + shear > 0
    flipped = known & (shear > similarity)
    sheared = known & ~flipped & (similarity + shear > SHEARED * (similarity - shear))
    shrunken = known & (similarity < SHRUNKEN)
    warnings = []
    parts = [
        f"{np.count_nonzero(mask)} {word}"
        for mask, word in (
            (flipped, "flipped"),
            (sheared, f"sheared more than {SHEARED:g} times"),
            (shrunken, f"shrunk below {SHRUNKEN:g} of their chart's scale"),
        )
        if mask.any()
    ]
    if parts:
        warnings.append(
            f"Method C: of {len(similarity)} triangles in the unfolding {', '.join(parts)}; "
            "umbilics there may be missed or false. More seams, or method S, help."
        )
    return warnings
