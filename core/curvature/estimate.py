"""Shape operators at the vertices, from whichever source the settings name."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from ..base.arguments import numbers
from ..base.errors import InvalidMeshError
from ..base.options import AUTO
from ..base.progress import Progress
from ..base.settings import Settings
from ..base.unit import unit
from ..fields.winding import Winding
from ..mesh.creases import bent_half_edges, marked_half_edges
from ..mesh.half_edges import ends_of
from ..mesh.neighbourhoods import MOST_RINGS, Neighbourhood
from ..mesh.normals import smooth_normals
from ..mesh.patches import Patches
from ..mesh.rings import adjacency, rings_across
from ..mesh.surface import Surface
from ..mesh.tessellated import Tessellation
from ..mesh.thinning import thinned
from .close_up.closer import look_closer
from .exact_faces import on_faces
from .field import CurvatureField
from .fits.jets import fit_jets
from .fitted_normals import fitted_normals
from .from_normals import curvature_from_normals
from .scale import Scale, choose, starting_normals
from .spread_fits import FEWEST, fit_spread, worth_spreading


@dataclass(frozen=True)
class Estimate:
    """Shape operators of a `Surface`, in its own coordinates.

    Attributes
    ----------
    field:
        Curvatures, directions, normals and noise at its n vertices.
    radius:
        (n,) float64 root mean square distance of what each was fitted to.
    determined:
        (n,) bool, False where the jet was not determined and normals had to do.
    neighbourhood:
        What the jets were fitted to; None for curvature "normals" and "given".
    residual:
        Median standard deviation of the heights about the fits, in length; NaN without jets.
    factor:
        Of the standard errors, as in `Scale`.
    rough:
        Whether fits tell of errors of the points, or of detail as small: see `Scale.clean`.
    closer, degree:
        What the jets around umbilics were fitted to, and their degree; None and 0 without.
    rings, degrees:
        As in `Closer`.
    winding:
        Of the field, where it was asked for on the way; else None.
    """

    field: CurvatureField
    radius: np.ndarray
    determined: np.ndarray
    neighbourhood: Neighbourhood | None
    residual: float
    factor: float = 1.0
    rough: bool = False
    closer: Scale | None = None
    degree: int = 0
    rings: np.ndarray | None = None
    degrees: np.ndarray | None = None
    winding: Winding | None = None


def estimate(
    surface: Surface,
    normals: np.ndarray,
    settings: Settings,
    given: CurvatureField | None,
    sharp: np.ndarray | None,
    progress: Progress,
    part: Tessellation | None = None,
    wide: Callable[[], None] | None = None,
    begun: Callable[[Estimate], None] | None = None,
) -> Estimate:
    """Shape operators by `settings.curvature`.

    Parameters
    ----------
    surface, normals:
        The surface and its (n, 3) unit normals; n vertices.
    given:
        The user's own operators at the input's vertices, for curvature "given"; its `normal`
        and `noise` are not read.
    sharp:
        (s, 2) pairs of input vertices whose edges are not fitted across, or None.
    part:
        The exact faces of a tessellated part, on which nothing is fitted, or None.
    wide:
        Called where errors of the points ask for wide windows, before these are made; None to tell
        nobody.
    begun:
        Told what jets at the scale that was chosen give, before umbilics are looked at more
        closely; None to tell nobody.

    Raises
    ------
    InvalidMeshError
        Curvature "given" without operators, or with ones that do not fit the mesh.
    """
    if settings.curvature == "given":
        return _given(surface, normals, given)
    if settings.curvature == "normals" or settings.normal_smoothing:
        passes = settings.normal_smoothing
        smoothed = fitted_normals if settings.normal_filter == "fit" else smooth_normals
        return _from_normals(surface, smoothed(surface, normals, passes, progress))
    return _from_jets(surface, normals, settings, sharp, progress, part, wide, begun)


def _from_normals(surface: Surface, normals: np.ndarray) -> Estimate:
    field = curvature_from_normals(surface, normals)
    return Estimate(field, _edge_length(surface), np.ones(len(normals), bool), None, float("nan"))


def _from_jets(
    surface: Surface,
    normals: np.ndarray,
    settings: Settings,
    sharp: np.ndarray | None,
    progress: Progress,
    part: Tessellation | None,
    wide: Callable[[], None] | None,
    begun: Callable[[Estimate], None] | None,
) -> Estimate:
    centres, exact = None, None
    if part is not None:
        exact = part.exact_vertices(surface)
        centres = np.flatnonzero(~exact)
        if not len(centres):
            field = on_faces(surface, normals, part)
            known = np.ones(len(normals), bool)
            return Estimate(field, _edge_length(surface), known, None, float("nan"))
    crease_vertices = _crease_vertices(surface, settings, sharp, part)
    cells = thinned(surface, normals, crease_vertices, progress)
    graph = adjacency(surface)

    def patches() -> Patches:
        if wide is not None:
            wide()
        return Patches(surface, normals, graph, progress.quiet())

    patching = None
    if crease_vertices is None and cells is None and len(normals) >= FEWEST:
        patching = cache(patches)
    neighbourhood = Neighbourhood(
        surface, graph, crease_vertices, thinned=cells, patching=patching
    )
    choosing = progress.part("Choosing the scale", 0, 0.1)
    automatic = settings.scale == AUTO
    if automatic:
        scale = choose(surface, normals, neighbourhood, choosing.quiet())
    else:
        neighbourhood = _scaled(neighbourhood, surface, settings)
        scale = Scale(neighbourhood, tilted=True)

    @cache
    def start() -> np.ndarray:
        return _started_from(surface, normals, scale, progress.quiet())

    whole = _at_scale(surface, normals, scale, start, centres, part, progress)
    if not automatic:
        return whole
    if begun is not None:
        begun(whole)
    looking = progress.part("Looking closer", 0.9, 1)
    begin = start() if scale.neighbourhood.patching is None else None
    closer = look_closer(surface, whole.field, whole.radius, scale, looking, exact, begin)
    return replace(
        whole,
        field=closer.field,
        radius=closer.radius,
        closer=closer.scale,
        degree=closer.degree if closer.scale else 0,
        rings=closer.rings,
        degrees=closer.degrees,
        winding=closer.winding,
    )


def _at_scale(
    surface: Surface,
    normals: np.ndarray,
    scale: Scale,
    start: Callable[[], np.ndarray],
    centres: np.ndarray | None,
    part: Tessellation | None,
    progress: Progress,
) -> Estimate:
    """Jets at one scale, from the normals of `start`, at all vertices or at `centres` (c,); where
    these are none or do not tell, what faces and normals say."""
    fitting = progress.part("Fitting jets", 0.1, 0.9)
    if centres is None and worth_spreading(scale):
        jets = fit_spread(surface, normals, scale.neighbourhood, fitting, scale.tilted)
    else:
        jets = fit_jets(surface, start(), scale.neighbourhood, fitting, centres)
    noise = scale.factor * jets.noise
    field = CurvatureField(jets.k1, jets.k2, jets.d1, jets.d2, jets.normal, noise)
    radius, determined = jets.radius, jets.determined
    if centres is not None:
        field, radius, determined = _among_others(surface, field, radius, determined, centres)
    if not determined.all():
        if part is None:
            others = curvature_from_normals(surface, normals)
        else:
            others = on_faces(surface, normals, part)
        field = _filled(field, others, determined)
    return Estimate(
        field,
        radius,
        determined,
        scale.neighbourhood,
        float(np.median(jets.residual)),
        scale.factor,
        not scale.clean,
    )


def _started_from(
    surface: Surface, normals: np.ndarray, scale: Scale, progress: Progress
) -> np.ndarray:
    """(n, 3) unit normals that fits at this scale start from."""
    if not scale.tilted:
        return normals
    return starting_normals(surface, normals, scale.neighbourhood, progress)


def _among_others(
    surface: Surface,
    field: CurvatureField,
    radius: np.ndarray,
    determined: np.ndarray,
    centres: np.ndarray,
) -> tuple[CurvatureField, np.ndarray, np.ndarray]:
    """Field, radius and whether it is determined of all n vertices, from those of `centres`."""
    n = len(surface.vertices)
    values = {}
    for name, value in vars(field).items():
        values[name] = np.zeros((n, *value.shape[1:]))
        values[name][centres] = value
    radii, known = _edge_length(surface), np.zeros(n, bool)
    radii[centres], known[centres] = radius, determined
    return CurvatureField(**values), radii, known


def _scaled(neighbourhood: Neighbourhood, surface: Surface, settings: Settings) -> Neighbourhood:
    if settings.scale_unit == "length":
        length = float(settings.scale) / surface.unit
        edges = _edge_length(surface)
        # Doubles leave edges without a length, which say nothing of how far a ring reaches.
        edge = float(np.median(edges[edges > 0])) if edges.any() else 1.0
        rings = round(min(max(length / edge, 2.0), MOST_RINGS))
        return dataclasses.replace(neighbourhood, rings=rings, reach=length, focused=False)
    rings = max(2, round(float(settings.scale)))
    if rings > MOST_RINGS:
        # Beyond the mesh there is only the mesh.
        rings = min(rings, max(rings_across(surface), 2))
    return dataclasses.replace(neighbourhood, rings=rings, focused=rings == 2)


def _crease_vertices(
    surface: Surface, settings: Settings, sharp: np.ndarray | None, part: Tessellation | None
) -> np.ndarray | None:
    """(n,) bool, vertices on creases by angle or by mark; None where there are none."""
    found = []
    if settings.crease_angle == AUTO:
        angle = 180.0 if part is None else part.crease_angle
    else:
        angle = float(settings.crease_angle)
    if angle < 180.0:
        found.append(bent_half_edges(surface, angle))
    if settings.crease_marks:
        found.append(marked_half_edges(surface, sharp))
    creased = np.concatenate(found) if found else np.zeros(0, np.int64)
    crease_vertices = np.zeros(len(surface.vertices), bool)
    for end in ends_of(surface.triangles, creased):
        crease_vertices[end] = True
    return crease_vertices if crease_vertices.any() else None


def _given(surface: Surface, surface_normal: np.ndarray, given: CurvatureField | None) -> Estimate:
    if given is None:
        raise InvalidMeshError(
            "Curvature 'given' needs principal curvatures and directions at the vertices: "
            "store them as attributes, or choose jets."
        )
    n = int(surface.source_vertex.max()) + 1
    arrays = {}
    for name, width in (("k1", 1), ("k2", 1), ("d1", 3), ("d2", 3)):
        array = numbers(getattr(given, name), f"The given {name} must be numbers.")
        if not array.ndim or len(array) < n or array.size != len(array) * width:
            raise InvalidMeshError(
                f"The given {name} must have {width} number{'s' * (width > 1)} for each vertex."
            )
        arrays[name] = array[surface.source_vertex]
        if not np.isfinite(arrays[name]).all():
            raise InvalidMeshError(f"The given {name} holds values that are not finite.")
    k1, k2 = (arrays[name].ravel() * surface.unit for name in ("k1", "k2"))
    d1, d2 = unit(arrays["d1"]), arrays["d2"]
    normal = np.cross(d1, d2)
    size = np.linalg.norm(normal, axis=1)
    # Directions come without a sign; the frame must agree with the surface's outward side.
    inward = np.einsum("nc,nc->n", normal, surface_normal) < 0
    normal = np.where(inward[:, None], -normal, normal)
    vague = size < 1e-6
    normal = np.where(vague[:, None], surface_normal, normal / np.where(vague, 1, size)[:, None])
    d1 = unit(d1 - np.einsum("nc,nc->n", d1, normal)[:, None] * normal)
    swapped = k2 > k1
    d2 = np.cross(normal, d1)
    d1 = np.where(swapped[:, None], d2, d1)
    field = CurvatureField(
        np.maximum(k1, k2),
        np.minimum(k1, k2),
        d1,
        np.cross(normal, d1),
        normal,
        np.full(len(k1), np.nan),
    )
    return Estimate(field, _edge_length(surface), ~vague, None, float("nan"))


def _filled(field: CurvatureField, other: CurvatureField, keep: np.ndarray) -> CurvatureField:
    """`field` where `keep` (n,), else `other`."""
    merged = {
        name: np.where(keep[:, None] if value.ndim == 2 else keep, value, getattr(other, name))
        for name, value in vars(field).items()
    }
    return CurvatureField(**merged)


def _edge_length(surface: Surface) -> np.ndarray:
    """(n,) mean length of the edges at each vertex."""
    valence = np.diff(surface.neighbour_start)
    return np.bincount(surface.owner, weights=surface.ring_lengths) / valence
