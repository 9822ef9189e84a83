"""From what was found on the `Surface` to a `Detection` in the input's rows and units."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base.progress import Progress
from ..base.settings import Settings
from ..curvature.estimate import Estimate
from ..curvature.field import CurvatureField
from ..mesh.borders import distance_to_border
from ..mesh.input_map import at_vertices, places_in_input, sums_at_triangles
from ..mesh.surface import Surface
from . import kind as cubic_form
from .filters import filtered
from .methods.raw import RawUmbilics
from .methods.shape_operators import face_deviators
from .pairing.persistence import made_by_noise, measure_persistence, significant, trust_ratio
from .refine import refine
from .regions import RegionMap, describe_regions
from .result import Detection, Umbilics

# Standard error of a place, in radii of the fit, above which a border may have made it: the
# spurious ones along the border of the test patch have 0.1 and more, most true ones 0.05.
VAGUE = 0.1
# Standard errors that an umbilic must be clear of to be believed where a pair may have lost its
# other half over the border.
BORDER_CLEAR = 2.0
# Share of the error below which pairs are not looked at more finely.
DROWNED = 1.0 / 3.0
# Chance that noise alone makes a pair that passes for present, or one that passes for certain.
PRESENT = 1e-2
CERTAIN = 1e-8
# Distance of a pair, in radii of the jets, that the finer fit at one of the two spans.
PAIR_REACH = 2.0
# Rings from a border within which a place must be better than that: what three rings of samples
# and one more for the place reach, and the triangle itself.
BORDER_RINGS = 5


@dataclass(frozen=True)
class Parts:
    """Everything that the stages before have found; see `core.pipeline`.

    Arrays over hits have k rows, over vertices and triangles those of the surface.
    """

    surface: Surface
    fitted: Estimate
    noise: np.ndarray
    radius: np.ndarray
    hits: RawUmbilics
    triangle_index: np.ndarray
    regions: RegionMap
    persistence: np.ndarray
    partner: np.ndarray
    types: np.ndarray
    elliptic: np.ndarray
    warnings: list[str]
    borders_joined: bool
    vertex_count: int
    triangle_count: int


def assemble(parts: Parts, settings: Settings, progress: Progress) -> Detection:
    """Locate and name the umbilics, and carry everything back to the input mesh."""
    surface, field = parts.surface, parts.fitted.field
    candidates = _umbilics(parts, settings, progress)
    regions = describe_regions(
        surface,
        parts.regions,
        0.5 * (field.k1 + field.k2),
        parts.noise,
        parts.radius,
        parts.triangle_index,
    )
    closed = bool(surface.closed.all())
    characteristic = int(surface.euler_characteristic.sum())
    curvature = _on_input_vertices(field, surface, parts.vertex_count)
    detection = Detection(
        umbilics=candidates,
        candidates=candidates,
        curvature=curvature,
        regions=regions,
        triangle_index=sums_at_triangles(surface, parts.triangle_index, parts.triangle_count),
        surface_type=at_vertices(surface, parts.types, parts.vertex_count, -1),
        conformal_scale=at_vertices(
            surface, parts.hits.conformal_scale, parts.vertex_count, np.nan
        ),
        euler_characteristic=characteristic,
        index_sum=float(candidates.index.sum()),
        expected_index_sum=float(characteristic) if closed else float("nan"),
        persistence_level=0.0,
        trust_ratio=trust_ratio(field.noise, field.gap),
        noise=parts.fitted.residual * surface.unit,
        scale=float(np.median(parts.fitted.radius)) * surface.unit,
        borders_joined=parts.borders_joined,
        warnings=tuple(parts.warnings),
    )
    return filtered(detection, settings)


def _umbilics(parts: Parts, settings: Settings, progress: Progress) -> Umbilics:
    """All umbilics in the input's coordinates, refined where jets allow it."""
    surface, fitted, hits = parts.surface, parts.fitted, parts.hits
    triangle, barycentric = hits.triangle.copy(), hits.barycentric.copy()
    corners = surface.triangles[triangle]
    local = "projection" if settings.parametrization == "projection" else "conformal"
    deviators = face_deviators(surface, fitted.field, triangle, local)
    p, q = cubic_form.in_triangles(
        surface.vertices[corners], deviators.values, deviators.x, deviators.y
    )
    x, y = deviators.x, deviators.y
    normal = _interpolated(fitted.field.normal[corners], barycentric)
    mean = 0.5 * (fitted.field.k1 + fitted.field.k2)
    curvature = np.einsum("rk,rk->r", mean[corners], barycentric)
    noise = np.einsum("rk,rk->r", parts.noise[corners], barycentric)
    error = noise.copy()
    exact = settings.curvature == "given"
    if exact:
        # What the user gives has no noise that could make pairs.
        noise = np.full(len(hits), np.nan)
    located, clarity = np.ones(len(hits), bool), np.full(len(hits), np.nan)
    slope_error = np.zeros(len(hits))
    # Pairs that drown in the noise of the fit have no place to be looked for, and a scan has
    # hundreds of thousands of them.
    clear = np.flatnonzero(~made_by_noise(parts.persistence, parts.partner, DROWNED * noise))
    as_found = settings.method == "I" or settings.triangles == "published"
    if fitted.neighbourhood is not None and not as_found:
        places = refine(
            surface,
            triangle[clear],
            barycentric[clear],
            fitted,
            progress,
        )
        # What contradicts the winding is another zero: the triangle's own is kept then.
        seen = places.found & (
            cubic_form.index(places.p, places.q) == np.sign(hits.index[clear]) / 2
        )
        located, clarity = np.zeros(len(hits), bool), np.zeros(len(hits))
        found = clear[seen]
        located[found], clarity[found] = True, places.clarity[seen]
        slope_error[found] = places.slope_error[seen]
        triangle[found], barycentric[found] = places.triangle[seen], places.barycentric[seen]
        normal[found] = places.normal[seen]
        x[found], y[found] = places.x[seen], places.y[seen]
        p[found], q[found] = places.p[seen], places.q[seen]
        curvature[found], error[found] = places.curvature[seen], places.error[seen]
        corners = surface.triangles[triangle]
    uncertainty = _uncertainty(error, p, q)
    # A fit whose place is this vague within its own radius would not show a one-sided error.
    vague = ~located | (uncertainty > VAGUE * parts.radius[corners].mean(axis=1))
    persistence, partner = parts.persistence, parts.partner
    if settings.certified and fitted.neighbourhood is not None and vague[clear].any():
        # Of two that could cancel a third, the one that the finer fit shows stays.
        persistence, partner = measure_persistence(
            surface, fitted.field.gap, hits.triangle, hits.index, parts.regions.rows(), ~vague
        )
    fits = _independent_fits(surface, parts.radius)
    present = clarity >= significant(fits, PRESENT)
    at_border = _at_border(surface, triangle, partner, vague, clarity < BORDER_CLEAR, exact)
    position = np.einsum("rk,rkc->rc", barycentric, surface.vertices[corners])
    unseen = _unseen_pairs(position, partner, located | at_border, parts.radius[corners])
    if not exact:
        # A border has errors of its own: it makes places vague without making pairs.
        inner = ~at_border & ~(at_border[partner] & (partner >= 0))
        unseen |= inner & _within_errors(position, partner, uncertainty)
    # What a finer fit does not show is noise up to where it cancels, what it shows clearly none.
    above = np.where(unseen, np.fmax(noise, persistence), noise)
    above = np.where(_both(present, partner), 0.0, above)
    resolved = ~made_by_noise(persistence, partner, above)
    certain = located & fitted.determined[corners].all(axis=1) & ~at_border
    certain &= ~(clarity < significant(fits, CERTAIN)) & resolved
    if not exact:
        # What a border cuts off from a fit its error does not tell.
        certain &= ~surface.near_border(BORDER_RINGS)[corners].any(axis=1)
    input_triangle, input_barycentric = places_in_input(surface, triangle, barycentric)
    return Umbilics(
        position=position * surface.unit + surface.origin,
        normal=_unit_or(normal, surface.face_normal_area[0][triangle]),
        triangle=input_triangle,
        barycentric=input_barycentric,
        vertex=np.where(hits.vertex >= 0, surface.source_vertex[hits.vertex], -1),
        index=hits.index,
        kind=cubic_form.kinds(p, q, hits.index, slope_error),
        curvature=curvature / surface.unit,
        persistence=persistence / surface.unit,
        partner=partner,
        uncertainty=uncertainty * surface.unit,
        noise=noise / surface.unit,
        separatrix=_rays(p, q, x, y),
        at_border=at_border,
        certain=certain,
        resolved=resolved,
        elliptic=parts.elliptic,
    )


def _at_border(
    surface: Surface,
    triangle: np.ndarray,
    partner: np.ndarray,
    vague: np.ndarray,
    unclear: np.ndarray,
    exact: bool,
) -> np.ndarray:
    """(k,) bool, umbilics that a border may have made by its slivers and one-sided fits.

    Those within one ring of it; unless the operators are `exact`, as far in as fits reach,
    those whose place is `vague`, twice as far in if they are `unclear` too; and within two or
    three rings those that cancel with one of these: the two come and go together.
    """
    if surface.closed.all():
        return np.zeros(len(triangle), bool)
    corners = surface.triangles[triangle]
    # Rings alone are blind where the border has few vertices, as the hull of scattered points.
    edge = float(np.sqrt(np.median(surface.side_squares)))
    points = surface.vertices[corners.ravel()]
    distance = distance_to_border(surface, points, edge, BORDER_RINGS * edge)
    distance = distance.reshape(-1, 3).min(axis=1)

    def within(rings: int) -> np.ndarray:
        return surface.near_border(rings)[corners].any(axis=1) | (distance <= rings * edge)

    doubtful = within(1)
    if not exact:
        doubtful |= within(BORDER_RINGS) & vague
        doubtful |= within(2 * BORDER_RINGS) & vague & unclear
    return doubtful | (within(2 if exact else 3) & (partner >= 0) & doubtful[partner])


def _unseen_pairs(
    position: np.ndarray, partner: np.ndarray, located: np.ndarray, radius: np.ndarray
) -> np.ndarray:
    """(k,) bool, umbilics of pairs that the finer fit does not show: neither of them or, of a
    close pair, not both.

    A fit that reaches over both would have two zeros or none: the error of the gap is then at
    least what parts them. `radius` (k, 3) are those of the fits at the corners.
    """
    paired = partner >= 0
    apart = np.linalg.norm(position - position[partner], axis=1)
    close = apart <= PAIR_REACH * radius.mean(axis=1)
    both, either = located & located[partner], located | located[partner]
    return paired & ~(both | (either & ~close))


def _within_errors(
    position: np.ndarray, partner: np.ndarray, uncertainty: np.ndarray
) -> np.ndarray:
    """(k,) bool, umbilics that stand no further from the one they cancel with than the errors
    of both places may reach: the same errors could bring them together."""
    apart = np.linalg.norm(position - position[partner], axis=1)
    reach = significant(1.0, PRESENT) * np.hypot(uncertainty, uncertainty[partner])
    return (partner >= 0) & (apart < reach)


def _both(there: np.ndarray, partner: np.ndarray) -> np.ndarray:
    """(k,) bool, umbilics that are there together with the one they cancel with."""
    return there & (partner >= 0) & there[partner]


def _independent_fits(surface: Surface, radius: np.ndarray) -> float:
    """How many fits of a surface share no samples: its area over that of their discs."""
    _, area = surface.face_normal_area
    known = radius[np.isfinite(radius) & (radius > 0)]
    if len(known) == 0:
        return 1.0
    # Points spread over a disc are 1 / sqrt(2) of its radius away from its middle.
    return max(float(area.sum() / (2.0 * np.pi * np.median(known) ** 2)), 1.0)


def _uncertainty(error: np.ndarray, p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """(k,) standard error of the place: that of the deviator over its least slope ||p|-|q||.

    No more than the diagonal of the unit box: nothing is known of the place then.
    """
    slope = np.abs(np.abs(p) - np.abs(q))
    size = 2.0 * np.sqrt(3.0)
    return np.fmin(np.divide(error, slope, out=np.full(len(p), size), where=slope > 0), size)


def _rays(p: np.ndarray, q: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """(k, 3, 3) unit tangents along the separatrices, NaN-filled."""
    angle = cubic_form.separatrix_angles(p, q)
    return np.cos(angle)[..., None] * x[:, None] + np.sin(angle)[..., None] * y[:, None]


def _interpolated(corners: np.ndarray, weights: np.ndarray) -> np.ndarray:
    return np.einsum("rk,rkc->rc", weights, corners)


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
