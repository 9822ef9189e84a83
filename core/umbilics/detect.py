"""The one pipeline: from arrays and settings to a `Detection`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ..base.arguments import vertex_pairs
from ..base.blas import one_blas_thread
from ..base.options import AUTO
from ..base.parallel import Begin, beside
from ..base.progress import Clock, Progress
from ..base.settings import Settings
from ..base.words import counted
from ..curvature.elliptic_part import lies_within, opened_elliptic_part
from ..curvature.estimate import Estimate, estimate
from ..curvature.field import CurvatureField
from ..curvature.form import Level, form_of, levels_of
from ..curvature.noise import field_noise
from ..curvature.outliers import without_outliers
from ..curvature.surface_types import surface_types, typical_curvature
from ..curvature.tolerances import CURVE, CURVE_MISS
from ..curvature.wider import WIDER, can_widen, wider_ratio
from ..mesh.mending.repair import clean
from ..mesh.normals import vertex_normals
from ..mesh.surface import Surface
from ..mesh.tessellated import Tessellation, tessellation
from .assembly import InputMesh, assemble
from .located import Analysed, Turning
from .methods.choice import found_by_method
from .methods.raw import RawUmbilics
from .pairing.by_form import FormUmbilics, paired_by_form, umbilics_of_form
from .pairing.persistence import Tree, measure_persistence, meeting
from .regions.drowned import drowned_share, drowned_words
from .regions.find import find_regions
from .regions.region_map import RegionMap, with_curves, with_faces, without
from .regions.round_shapes import resolved_by_wider_fits, standing_off
from .regions.unresolved import UnresolvedSets, low_vertices, unresolved_sets
from .result import Detection
from .shown_curves import without_shown

# Erosions and dilations that the paper uses throughout.
USUAL_OPENING = 2


@one_blas_thread()
def detect(
    vertices: np.ndarray,
    triangles: np.ndarray,
    settings: Settings | None = None,
    progress: Progress | None = None,
    *,
    given: CurvatureField | None = None,
    seams: np.ndarray | None = None,
    uv: np.ndarray | None = None,
    sharp: np.ndarray | None = None,
) -> Detection:
    """Find the umbilical points of a triangle mesh.

    Parameters
    ----------
    vertices:
        (n, 3) real positions; vertices without a triangle keep their place in the results.
    triangles:
        (m, 3) integer corners, wound outwards.
    settings:
        What to do; the defaults if None.
    progress:
        Told how far the work is, and asked whether to stop.
    given:
        Shape operators at the vertices, for `Settings.curvature` "given": k1, k2 in 1 / length
        and unit d1, d2; normal and noise are not read.
    seams, sharp:
        (s, 2) vertex pairs of the edges marked as seams (method C) and as sharp.
    uv:
        (m, 3, 2) UV coordinates of the corners, for charts "islands" or "uv" and for the
        parametrization "uv".

    Raises
    ------
    InvalidMeshError, ChartError, CancelledError
        With a sentence for the user.

    Examples
    --------
    An ellipsoid of three axes has four umbilics, all of them lemons, here as the hull of random
    points; how the hull winds its triangles does not matter.

    >>> import numpy as np
    >>> from scipy.spatial import ConvexHull
    >>> points = np.random.default_rng(0).normal(size=(2000, 3))
    >>> points /= np.linalg.norm(points, axis=1, keepdims=True)
    >>> triangles = ConvexHull(points).simplices
    >>> detection = core.detect(points * (3.0, 2.0, 1.0), triangles)
    >>> detection.umbilics.counts()["lemon"], detection.index_sum
    (4, 2.0)
    >>> x = 3.0 * np.sqrt((3.0**2 - 2.0**2) / (3.0**2 - 1.0**2))
    >>> bool(np.allclose(np.abs(detection.umbilics.position[:, 0]), x, atol=0.02))
    True
    """
    with beside() as begin:
        asked = _Asked(vertices, triangles, settings or Settings(), given, seams, uv, sharp)
        return _detected(asked, progress or Progress(), begin)


@dataclass(frozen=True)
class _Asked:
    """The arguments of `detect`."""

    vertices: np.ndarray
    triangles: np.ndarray
    settings: Settings
    given: CurvatureField | None
    seams: np.ndarray | None
    uv: np.ndarray | None
    sharp: np.ndarray | None


class _Ahead:
    """What is begun beside the fits as soon as these tell that it is needed.

    Parameters
    ----------
    begin:
        As from `beside`.
    cad:
        The exact faces of a tessellated part, or None.
    """

    def __init__(
        self,
        begin: Begin,
        surface: Surface,
        normals: np.ndarray,
        settings: Settings,
        cad: Tessellation | None,
        progress: Progress,
    ) -> None:
        self._begin, self._progress = begin, progress
        self._surface, self._normals = surface, normals
        self._settings, self._cad = settings, cad
        self._levels: Callable[[], list[Level]] | None = None
        self._sets: Callable[[], UnresolvedSets | None] | None = None

    def wide_windows(self) -> None:
        """Errors of the points ask for wide windows: the form may be what there is."""
        if self._levels is None and _form_wanted(self._settings, self._cad):
            work = partial(levels_of, self._surface, self._normals, self._progress)
            self._levels = self._begin(work)

    def fitted(self, found: Estimate) -> None:
        """Jets at one scale are there, before umbilics are looked at more closely."""
        if found.rough:
            self.wide_windows()
        # A curve is as long and as narrow everywhere, where windows of their own would make the
        # field patchy.
        self._sets = self._begin(partial(self._curves, found, found.field.noise, found.radius))

    def levels(self) -> list[Level]:
        """Those of the form, none where it was not asked for."""
        return [] if self._levels is None else self._levels()

    def sets(self, found: Estimate, noise: np.ndarray, radius: np.ndarray) -> UnresolvedSets | None:
        """What could be curves of umbilics, by jets at one scale where there are any, else by what
        was `found`, with (n,) standard errors of its gap and their radii."""
        return self._curves(found, noise, radius) if self._sets is None else self._sets()

    def _curves(
        self, found: Estimate, noise: np.ndarray, radius: np.ndarray
    ) -> UnresolvedSets | None:
        return _curves(
            self._surface, found, noise, radius, self._settings, self._cad, self._progress
        )


def _detected(asked: _Asked, progress: Progress, begin: Begin) -> Detection:
    """As `detect`; `begin` as from `beside`."""
    clock, settings = Clock(), asked.settings
    vertices, triangles = asked.vertices, asked.triangles
    with clock.stage("cleaning"):
        progress.part("Reading the surface", 0.0, 0.1)
        # Seams that charts are cut along may be borders already, and stay so.
        join = settings.join_borders and not (settings.unfolds and settings.charts == "seams")
        surface, warnings = clean(vertices, triangles, join)
        seams = vertex_pairs(asked.seams, len(vertices), "seams")
        sharp = vertex_pairs(asked.sharp, len(vertices), "sharp edges")
    with clock.stage("faces"):
        cad = _tessellated(surface, settings)
        if cad is not None:
            warnings.append(cad.sentence())
    with clock.stage("curvature"):
        part = progress.part("Fitting curvature", 0.1, 0.7)
        places, normals = surface.vertices, vertex_normals(surface)
        if cad is None and settings.curvature == "jets":
            surface, normals, outlying = without_outliers(surface, normals, part.quiet())
            if len(outlying):
                warnings.append(
                    f"Vertices that stick out of the surface around them: {len(outlying)}. They "
                    "are looked at as if they lay on it. Smooth or remesh there to be rid of them."
                )
        ahead = _Ahead(begin, surface, normals, settings, cad, part.quiet())
        told = ahead.wide_windows, ahead.fitted
        fitted = estimate(surface, normals, settings, asked.given, sharp, part, cad, *told)
    with clock.stage("form"):
        # Regions are what the surface's own fits do not tell apart: the form's errors hold its
        # detail.
        own, part = fitted, part.quiet()
        errors = _noise(surface, own)
        regions = _regions(surface, own, *errors, _rings(own), settings, cad, part)
        sets = ahead.sets(own, *errors)
        shown: FormUmbilics | None = None
        # Where finest fits do not follow anything but the shape, it has a size.
        wide = ahead.levels() if own.rough else []
        if wide:
            form = form_of(surface, wide, own.field, own.radius, part)
            shown = umbilics_of_form(surface, own, form, part)
            fitted = shown.fitted
            warnings.append(
                "The surface has detail at every size, as scans have: the umbilics shown are "
                "those of its form, and none of them is certain. Choose a scale to see those "
                "of finer detail."
            )
    shape = fitted.field
    noise, radius = _noise(surface, fitted)
    with clock.stage("index"):
        part = progress.part("Turning around", 0.7, 0.8)
        found = found_by_method(surface, fitted, settings, triangles, seams, asked.uv, part)
        warnings += found.raw.warnings
    with clock.stage("regions"):
        progress.part("Finding regions", 0.8, 0.85)
        if sets is not None:
            regions = with_curves(surface, regions, sets, found.triangle_index)
            regions = without_shown(surface, fitted, found.raw, regions, progress.quiet())
            if regions.curves:
                curves = counted(regions.curves, "curve")
                warnings.append(
                    f"Along {curves} both principal curvatures are equal within their error, as on "
                    "circles of surfaces of revolution: reported as regions, because no point of "
                    "them is an umbilic of its own."
                )
        drowned: Callable[[], float] = float
        if settings.regions and settings.certified and settings.curvature != "given":
            label = regions.label
            drowned = begin(lambda: drowned_share(surface, shape.gap, noise, radius, label >= 0))
        outside = regions.label[found.raw.triangle] < 0
        raw = found.raw.select(outside)
    typed = begin(lambda: _types(surface, shape, settings))
    with clock.stage("persistence"):
        progress.part("Pairing umbilics", 0.85, 0.9)
        of_form, tree = None, None
        if shown is None:
            tree = meeting(surface, shape.gap, raw.triangle, raw.index, regions.rows())
            persistence, partner = _paired(surface, shape, settings, raw, tree)
        else:
            persistence, partner, of_form = paired_by_form(surface, shape.gap, raw, shown)
    with clock.stage("surface types"):
        if share := drowned():
            warnings.append(drowned_words(share))
        types, inside = typed()
        elliptic = lies_within(surface, inside, raw.triangle, raw.barycentric)
    with clock.stage("location"):
        part = progress.part("Locating umbilics", 0.9, 1.0)
        detection = assemble(
            Analysed(surface, fitted, places, noise, radius, types, regions),
            Turning(
                raw,
                found.triangle_index,
                elliptic,
                persistence,
                partner,
                of_form,
                0.0 if shown is None else shown.widest,
                tree,
            ),
            InputMesh(len(vertices), len(triangles), join, tuple(warnings)),
            settings,
            part,
        )
    progress.step(1.0)
    detection.timings.update(clock.seconds)
    return replace(detection, crease_angle=_crease_angle(settings, cad))


def _noise(surface: Surface, fitted: Estimate) -> tuple[np.ndarray, np.ndarray]:
    """(n,) standard error of the gap and (n,) radius that it belongs to.

    Jets know theirs; of operators from elsewhere it is estimated from their neighbours.
    """
    field = fitted.field
    known = np.isfinite(field.noise)
    if known.all():
        return field.noise, fitted.radius
    noise, radius = field_noise(surface, field.k1, field.k2, field.d1, field.normal)
    return np.where(known, field.noise, noise), np.where(known, fitted.radius, radius)


def _rings(fitted: Estimate) -> int:
    """Rings of the mesh as far as fits reach."""
    around = fitted.neighbourhood
    if around is None:
        return 1
    # On stretched meshes more across short edges and fewer across long ones; in between the two.
    return round(around.rings * around.stretch**0.25)


def _regions(
    surface: Surface,
    fitted: Estimate,
    noise: np.ndarray,
    radius: np.ndarray,
    rings: int,
    settings: Settings,
    cad: Tessellation | None,
    progress: Progress,
) -> RegionMap:
    if not settings.regions or not settings.certified:
        return RegionMap.none(surface)
    shape = fitted.field
    mean = 0.5 * (shape.k1 + shape.k2)
    gap = shape.gap if cad is None else np.where(cad.exact_vertices(surface), np.nan, shape.gap)
    regions = find_regions(surface, gap, noise, radius, rings, mean)
    if regions.count and can_widen(fitted):

        def ratio(vertices: np.ndarray) -> np.ndarray:
            return wider_ratio(surface, fitted, vertices, progress)

        rows = regions.rows()
        dropped = np.array(resolved_by_wider_fits(surface, rows, WIDER * rings, ratio), bool)
        dropped |= standing_off(surface, rows, rings, _scatter(fitted, noise, radius))
        regions = without(regions, dropped)
    if cad is not None:
        return with_faces(cad, regions)
    return regions


def _curves(
    surface: Surface,
    fitted: Estimate,
    noise: np.ndarray,
    radius: np.ndarray,
    settings: Settings,
    cad: Tessellation | None,
    progress: Progress,
) -> UnresolvedSets | None:
    """What could be curves of umbilics, in the field of one scale: a curve is as long and as narrow
    everywhere, where windows of their own make its field patchy. None where none are asked for."""
    if not settings.regions or not settings.certified or cad is not None:
        return None
    shape = fitted.field
    low = low_vertices(surface, shape.gap)
    return unresolved_sets(surface, shape, noise, radius, CURVE, low, progress, CURVE_MISS)


def _scatter(fitted: Estimate, noise: np.ndarray, radius: np.ndarray) -> np.ndarray:
    """(n,) standard deviation of the points about fits, in length: the errors of curvatures go with
    it over the square of the radius."""
    size = noise * np.square(radius)
    known = size[np.isfinite(size) & (size > 0.0)]
    if not len(known):
        return np.full(len(size), np.nan)
    return np.asarray(fitted.residual * size / np.median(known))


def _crease_angle(settings: Settings, cad: Tessellation | None) -> float:
    """Degrees from which edges are not fitted across."""
    if settings.curvature == "given":
        return 180.0
    if settings.crease_angle == AUTO:
        return 180.0 if cad is None else cad.crease_angle
    return float(settings.crease_angle)


def _tessellated(surface: Surface, settings: Settings) -> Tessellation | None:
    """The exact faces of the mesh, if it is a tessellated part and they may be regions."""
    if settings.method != "S" or not settings.regions or settings.curvature == "given":
        return None
    if settings.crease_angle == AUTO:
        return tessellation(surface)
    angle = float(settings.crease_angle)
    return tessellation(surface, angle) if angle < 180.0 else None


def _form_wanted(settings: Settings, cad: Tessellation | None) -> bool:
    """Whether the scale is to be chosen and what is found by the index is judged: on a surface
    whose finest fits follow something else than its shape, the form may be what there is."""
    chosen = settings.curvature == "jets" and not settings.normal_smoothing
    chosen &= settings.scale == AUTO and cad is None
    return chosen and settings.method == "S" and settings.certified


def _types(
    surface: Surface, shape: CurvatureField, settings: Settings
) -> tuple[np.ndarray, np.ndarray]:
    """Surface types and whether vertices lie in the opened elliptic part (n,)."""
    tolerance = settings.flatness * typical_curvature(surface, shape.k1, shape.k2)
    types = surface_types(shape.k1, shape.k2, tolerance)
    # Also where the opening is off, so that it can be turned on without a new detection.
    return types, opened_elliptic_part(surface, types, settings.opening or USUAL_OPENING)


def _paired(
    surface: Surface,
    shape: CurvatureField,
    settings: Settings,
    raw: RawUmbilics,
    tree: Tree,
) -> tuple[np.ndarray, np.ndarray]:
    """Persistence and partner, where the indices balance over the surface."""
    if not settings.certified:
        return np.full(len(raw), np.nan), np.full(len(raw), -1)
    return measure_persistence(surface, shape.gap, raw.triangle, raw.index, tree=tree)
