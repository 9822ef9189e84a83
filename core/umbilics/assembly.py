"""From what was found on the `Surface` to a `Detection` in the input's rows and units."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..base.progress import Progress
from ..base.settings import Settings
from ..curvature.field import CurvatureField
from ..mesh.input_map import at_vertices, places_in_input, sums_at_triangles
from ..mesh.surface import Surface
from . import kind as cubic_form
from .compounds import merged, other_places, settled, unresolved_groups
from .filters import filtered
from .judged import Evidence, judge
from .located import Analysed, Turning, deviator_errors, locate, standard_errors
from .pairing.persistence import importance, trust_ratio
from .regions.report import describe_regions
from .regions.too_few import too_few_words, untold_pieces, with_pieces
from .regions.waves import words_on_waves
from .result import Detection, Umbilics


@dataclass(frozen=True)
class InputMesh:
    """The mesh that a surface was made of: what it counts, whether its borders were joined, and
    what is to be said of it."""

    vertex_count: int
    triangle_count: int
    borders_joined: bool
    warnings: tuple[str, ...]


def assemble(
    analysed: Analysed,
    turning: Turning,
    mesh: InputMesh,
    settings: Settings,
    progress: Progress,
) -> Detection:
    """Locate and name the umbilics, and carry everything back to the input mesh."""
    surface, field = analysed.surface, analysed.fitted.field
    candidates, component = _umbilics(analysed, turning, settings, progress)
    labels, warnings = analysed.regions, mesh.warnings
    if settings.regions and settings.certified:
        told = component[candidates.resolved & ~candidates.at_border]
        untold = untold_pieces(surface, labels, told)
        if untold.any():
            labels = with_pieces(surface, labels, untold)
            candidates = _left(candidates, ~untold[component])
            warnings += (too_few_words(labels.few, surface.component_count),)
    regions = describe_regions(
        surface,
        labels,
        0.5 * (field.k1 + field.k2),
        analysed.noise,
        analysed.radius,
        turning.triangle_index,
    )
    closed = bool(surface.closed.all())
    characteristic = int(surface.euler_characteristic.sum())
    curvature = _on_input_vertices(field, surface, mesh.vertex_count)
    jets = analysed.fitted.neighbourhood is not None
    waves = words_on_waves(candidates, len(surface.vertices)) if jets else ()
    detection = Detection(
        umbilics=candidates,
        candidates=candidates,
        curvature=curvature,
        regions=regions,
        triangle_index=sums_at_triangles(surface, turning.triangle_index, mesh.triangle_count),
        surface_type=at_vertices(surface, analysed.types, mesh.vertex_count, -1),
        conformal_scale=at_vertices(
            surface, turning.raw.conformal_scale, mesh.vertex_count, np.nan
        ),
        euler_characteristic=characteristic,
        index_sum=float(candidates.index.sum()),
        expected_index_sum=float(characteristic) if closed else float("nan"),
        persistence_level=0.0,
        trust_ratio=trust_ratio(field.noise, field.gap),
        noise=analysed.fitted.residual * surface.unit,
        scale=float(np.median(analysed.fitted.radius)) * surface.unit,
        borders_joined=mesh.borders_joined,
        warnings=warnings + waves,
    )
    return filtered(detection, settings)


def _left(umbilics: Umbilics, kept: np.ndarray) -> Umbilics:
    """The umbilics that are `kept` (k,), of which the partners are."""
    number = np.append(np.where(kept, np.cumsum(kept) - 1, -1), -1)
    left = umbilics.select(kept)
    return replace(left, partner=number[left.partner])


def _umbilics(
    analysed: Analysed, turning: Turning, settings: Settings, progress: Progress
) -> tuple[Umbilics, np.ndarray]:
    """All umbilics in the input's coordinates, refined where jets allow it, those that are not
    told from each other made one; and the (k,) components that they lie on."""
    surface, fitted = analysed.surface, analysed.fitted
    persistence, partner = turning.persistence, turning.partner
    jets = fitted.neighbourhood is not None
    evidence = Evidence(
        gap=fitted.field.gap,
        noise=analysed.noise,
        radius=analysed.radius,
        determined=fitted.determined,
        regions=analysed.regions.rows(),
        jets=jets,
        certified=settings.certified,
        exact=settings.curvature == "given",
        form_radius=turning.form_radius,
        tree=turning.tree,
    )
    found = locate(analysed, turning, settings, progress)
    verdict = judge(surface, found, evidence, persistence, partner, turning.of_form)
    clean = fitted.neighbourhood is not None and fitted.neighbourhood.focused
    if jets and settings.certified and not clean and turning.of_form is None:
        found = settled(surface, found, verdict, analysed.radius)
    if settings.certified and settings.merge and turning.of_form is None:
        group = unresolved_groups(
            surface, fitted.field, analysed.noise, analysed.radius, found, verdict
        )
        if group.max(initial=-1) >= 0:
            found, verdict = merged(surface, fitted.field, found, verdict, group, evidence)
    off, kept = np.zeros(len(found)), np.zeros(len(found), bool)
    if turning.of_form is None:
        if jets and settings.certified:
            off = other_places(surface, found, verdict, analysed.radius)
        kept = verdict.resolved & ~verdict.at_border
    error = deviator_errors(surface, found, kept, fitted, progress.quiet())
    if turning.of_form is not None:
        # Errors of a form hold the detail that it leaves out.
        error = np.where(turning.of_form, found.error, error)
    input_triangle, input_barycentric = places_in_input(surface, found.triangle, found.barycentric)
    places = analysed.places[surface.triangles[found.triangle]]
    umbilics = Umbilics(
        position=np.einsum("rk,rkc->rc", found.barycentric, places) * surface.unit + surface.origin,
        normal=_unit_or(found.normal, surface.face_normal_area[0][found.triangle]),
        triangle=input_triangle,
        barycentric=input_barycentric,
        vertex=np.where(found.vertex >= 0, surface.source_vertex[found.vertex], -1),
        index=found.index,
        kind=cubic_form.kinds(found.p, found.q, found.index, found.slope_error),
        curvature=found.curvature / surface.unit,
        persistence=verdict.persistence / surface.unit,
        partner=verdict.partner,
        uncertainty=np.hypot(standard_errors(found, error), off) * surface.unit,
        noise=found.noise / surface.unit,
        separatrix=_rays(found.p, found.q, found.x, found.y),
        at_border=verdict.at_border,
        certain=verdict.certain,
        resolved=verdict.resolved,
        importance=importance(verdict.persistence, verdict.partner, found.noise, evidence.gap),
        elliptic=found.elliptic,
    )
    return umbilics, surface.component[surface.triangles[found.triangle, 0]]


def _rays(p: np.ndarray, q: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """(k, 3, 3) unit tangents along the separatrices, NaN-filled."""
    angle = cubic_form.separatrix_angles(p, q)
    return np.cos(angle)[..., None] * x[:, None] + np.sin(angle)[..., None] * y[:, None]


def _unit_or(vectors: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Vectors (k, 3) made unit; `other` where there is nothing to scale."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.where(length > 1e-12, vectors / np.where(length > 1e-12, length, 1.0), other)


def _on_input_vertices(field: CurvatureField, surface: Surface, count: int) -> CurvatureField:
    per_length = {name: getattr(field, name) / surface.unit for name in ("k1", "k2", "noise")}
    return CurvatureField(
        **{
            name: at_vertices(surface, value, count, np.nan)
            for name, value in (vars(field) | per_length).items()
        }
    )
