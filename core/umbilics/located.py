"""Where the umbilics are and what their surroundings look like, row by row, before it is judged
which of them are real."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base.progress import Progress
from ..base.settings import Settings
from ..curvature.estimate import Estimate
from ..curvature.fits.jets import DEGREE
from ..mesh.surface import Surface
from . import kind as cubic_form
from .methods.raw import RawUmbilics
from .methods.shape_operators import face_deviators
from .pairing.persistence import made_by_noise
from .refine import SLOPE_ERROR, refine

# True errors of places over those that independent residuals tell of the fit that they are read
# off. On clean meshes errors are bias, of which residuals show a third: of random terms of the next
# degree they would show a half. Windows chosen for their small errors hold more than they tell.
# Those of one scale are measured (`Scale.factor`). Chosen on seeds 200, 201, 300, 301, 400 and 401
# of benchmarks.people, confirmed on fields and metaballs of 500 and 501 and on 700 and 701.
BIAS_CLEAN, BIAS_WINDOWS = 3.0, 1.3
# The diagonal of the unit box: where no error is smaller nothing is known of the place.
LARGEST = 2.0 * np.sqrt(3.0)
# Share of the error below which pairs are not looked at more finely.
DROWNED = 1.0 / 3.0


@dataclass(frozen=True)
class Located:
    """Candidates of a `Surface`, in its own coordinates, one row each.

    Attributes
    ----------
    singular:
        (k,) int64 triangle that the directions turn around, wherever the place is.
    triangle, barycentric:
        (k,) int64 and (k, 3) float64 place.
    vertex, index, elliptic:
        As in `RawUmbilics` and `Umbilics`.
    normal, x, y:
        (k, 3) float64 unit normal and orthonormal tangents.
    p, q:
        (k,) complex128 linear form of the deviator in the frame x, y.
    curvature, noise:
        (k,) float64 mean curvature and standard error of the gap.
    uncertainty:
        (k,) float64 how far the place moves by an error of the deviator in the direction in which
        it is known least.
    slope_error, clarity:
        As in `Refined`; NaN for the clarity where nothing was refined.
    asked, seen:
        (k,) bool, those that a finer fit was made for; False for those that it does not show, or
        that it was not made for.
    """

    singular: np.ndarray
    triangle: np.ndarray
    barycentric: np.ndarray
    vertex: np.ndarray
    index: np.ndarray
    elliptic: np.ndarray
    normal: np.ndarray
    x: np.ndarray
    y: np.ndarray
    p: np.ndarray
    q: np.ndarray
    curvature: np.ndarray
    noise: np.ndarray
    uncertainty: np.ndarray
    slope_error: np.ndarray
    clarity: np.ndarray
    asked: np.ndarray
    seen: np.ndarray

    def __len__(self) -> int:
        return len(self.index)

    def position(self, surface: Surface) -> np.ndarray:
        """(k, 3) float64 places in the coordinates of the surface."""
        corners = surface.vertices[surface.triangles[self.triangle]]
        return np.asarray(np.einsum("rk,rkc->rc", self.barycentric, corners))


def locate(
    surface: Surface,
    fitted: Estimate,
    vertex_noise: np.ndarray,
    raw: RawUmbilics,
    elliptic: np.ndarray,
    persistence: np.ndarray,
    partner: np.ndarray,
    settings: Settings,
    progress: Progress,
    of_form: np.ndarray | None = None,
) -> Located:
    """The raw, refined where jets allow it.

    Parameters
    ----------
    vertex_noise:
        (n,) standard error of the gap at the vertices.
    elliptic, persistence, partner:
        (k,) of the raw; see `Umbilics`.
    of_form:
        (k,) bool, those that wide fits show and narrower ones would only move; None for none.
    """
    triangle, barycentric = raw.triangle.copy(), raw.barycentric.copy()
    corners = surface.triangles[triangle]
    local = "projection" if settings.parametrization == "projection" else "conformal"
    deviators = face_deviators(surface, fitted.field, triangle, local)
    p, q = cubic_form.in_triangles(
        surface.vertices[corners], deviators.values, deviators.x, deviators.y
    )
    x, y = deviators.x, deviators.y
    normal = np.einsum("rk,rkc->rc", barycentric, fitted.field.normal[corners])
    mean = 0.5 * (fitted.field.k1 + fitted.field.k2)
    curvature = np.einsum("rk,rk->r", mean[corners], barycentric)
    noise = np.einsum("rk,rk->r", vertex_noise[corners], barycentric)
    error = noise.copy()
    if settings.curvature == "given":
        # What the user gives has no noise that could make pairs.
        noise = np.full(len(raw), np.nan)
    seen, clarity = np.ones(len(raw), bool), np.full(len(raw), np.nan)
    slope_error, asked = np.zeros(len(raw)), np.ones(len(raw), bool)
    if fitted.neighbourhood is not None:
        # Corners of one triangle share most of their samples: the slopes between them err as those
        # of one fit do.
        reach = np.maximum(fitted.radius[corners].mean(axis=1), np.finfo(float).tiny)
        slope_error = SLOPE_ERROR[DEGREE] * noise / reach
    as_found = settings.method == "I" or settings.triangles == "published"
    if fitted.neighbourhood is not None and not as_found:
        # Pairs that drown in the noise of the fit have no place to be looked for, and a scan has
        # hundreds of thousands of them.
        asked = ~made_by_noise(persistence, partner, DROWNED * noise)
        if of_form is not None:
            asked = np.zeros(len(raw), bool)
        clear = np.flatnonzero(asked)
        places = refine(surface, triangle[clear], barycentric[clear], fitted, progress)
        # Elsewhere the triangle's own place is kept.
        agrees = places.agrees(raw.index[clear])
        seen, clarity = np.zeros(len(raw), bool), np.zeros(len(raw))
        found = clear[agrees]
        seen[found], clarity[found] = True, places.clarity[agrees]
        slope_error[found] = places.slope_error[agrees]
        triangle[found], barycentric[found] = places.triangle[agrees], places.barycentric[agrees]
        normal[found] = places.normal[agrees]
        x[found], y[found] = places.x[agrees], places.y[agrees]
        p[found], q[found] = places.p[agrees], places.q[agrees]
        curvature[found], error[found] = places.curvature[agrees], places.error[agrees]
        if of_form is not None:
            seen[of_form] = True
    return Located(
        singular=raw.triangle,
        triangle=triangle,
        barycentric=barycentric,
        vertex=raw.vertex,
        index=raw.index,
        elliptic=elliptic,
        normal=normal,
        x=x,
        y=y,
        p=p,
        q=q,
        curvature=curvature,
        noise=noise,
        uncertainty=_uncertainty(error, p, q),
        slope_error=slope_error,
        clarity=clarity,
        asked=asked,
        seen=seen,
    )


def _uncertainty(error: np.ndarray, p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """(k,) error of the place: that of the deviator over its least slope ||p|-|q||."""
    slope = np.abs(np.abs(p) - np.abs(q))
    largest = np.full(len(p), LARGEST)
    return np.fmin(np.divide(error, slope, out=largest, where=slope > 0), LARGEST)


def bias_of(fitted: Estimate) -> float:
    """Errors of places over those that the fits tell."""
    if fitted.neighbourhood is None:
        return 1.0
    if fitted.neighbourhood.focused:
        return BIAS_CLEAN
    return 1.0 if fitted.rings is None else BIAS_WINDOWS


def standard_errors(found: Located, bias: float | np.ndarray = 1.0) -> np.ndarray:
    """(k,) standard error of the places along the surface, per axis.

    An error e of the deviator D = p z + q conj(z), a complex Gaussian, moves its zero along two
    axes by parts of e over |p| - |q| and |p| + |q|: each part has half the variance of e, and the
    mean of both is that per axis. It is that of the fit which the place is read off: what the field
    errs by in the corners around says nothing of it. Compounds state how far their parts lie from
    them.

    Parameters
    ----------
    found:
        Located umbilics, k of them.
    bias:
        As `bias_of` gives it, of all or of each (k,).
    """
    least, most = np.abs(np.abs(found.p) - np.abs(found.q)), np.abs(found.p) + np.abs(found.q)
    error = bias * found.uncertainty * least
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        stated = 0.5 * error * np.hypot(1.0 / least, 1.0 / most)
    stated = np.fmin(np.nan_to_num(stated, nan=LARGEST), LARGEST)
    return np.where(np.isnan(found.p), found.uncertainty, stated)
