"""Where the umbilics are and what their surroundings look like, row by row, before it is judged
which of them are real."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..base.progress import Progress
from ..base.settings import Settings
from ..curvature.estimate import Estimate
from ..curvature.fits.jets import DEGREE
from ..mesh.surface import Surface
from . import kind as cubic_form
from .methods.raw import RawUmbilics
from .methods.shape_operators import face_deviators
from .pairing.persistence import Tree, made_by_noise
from .refine import SLOPE_ERROR, NextOrder, next_order, refine
from .regions.region_map import RegionMap

# True errors of places over those that independent residuals tell of the fit that they are read
# off, where its bias is not looked at. On clean meshes errors are bias, of which residuals show a
# third: of random terms of the next degree they would show a half. Windows chosen for their small
# errors hold more than they tell. Those of one scale are measured (`Scale.factor`). Chosen on seeds
# 200, 201, 300, 301, 400 and 401 of benchmarks.people, confirmed on fields and metaballs of 500 and
# 501 and on 700 and 701.
BIAS_CLEAN, BIAS_WINDOWS = 3.0, 1.3
# Shares of errors in what higher degrees change, over which a mean is taken.
STEPS = 2000
# Variance that two degrees more add at least, in that of the lower fit: 3 to 5 times as much where
# samples are spread evenly and err by themselves.
NOISE = 0.25
# The diagonal of the unit box: where no error is smaller nothing is known of the place.
LARGEST = 2.0 * np.sqrt(3.0)
# Share of the error below which pairs are not looked at more finely.
DROWNED = 1.0 / 3.0
# What a finer fit tells of a place, under the names of `Refined`.
_REFINED = ("triangle", "barycentric", "normal", "x", "y", "p", "q", "curvature", "slope_error")


@dataclass(frozen=True)
class Analysed:
    """A surface of n vertices with what was fitted to it.

    Attributes
    ----------
    surface, fitted:
        The surface as it was looked at, its outliers laid onto it, and its shape operators.
    places:
        (n, 3) where its vertices are in the mesh, in its own coordinates.
    noise, radius:
        (n,) standard error of the gap and root mean square distance of the samples that it comes
        from.
    types:
        (n,) see `surface_types`.
    regions:
        Where no point is an umbilic of its own.
    """

    surface: Surface
    fitted: Estimate
    places: np.ndarray
    noise: np.ndarray
    radius: np.ndarray
    types: np.ndarray
    regions: RegionMap


@dataclass(frozen=True)
class Turning:
    """What the directions turn around, k raw outside regions, before it is located.

    Attributes
    ----------
    raw, triangle_index:
        The raw, and (m,) the index of every triangle, those in regions included.
    elliptic, persistence, partner:
        (k,) of the raw, see `Umbilics`; in the coordinates of the surface.
    of_form, form_radius:
        (k,) bool, those that the form of a surface with detail at every size has, and the radius of
        its widest fits; None and 0 of others.
    tree:
        Where the raw meet; None to find out.
    """

    raw: RawUmbilics
    triangle_index: np.ndarray
    elliptic: np.ndarray
    persistence: np.ndarray
    partner: np.ndarray
    of_form: np.ndarray | None = None
    form_radius: float = 0.0
    tree: Tree | None = None


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

    @property
    def error(self) -> np.ndarray:
        """(k,) float64 error of the deviator that the uncertainty comes from."""
        return np.asarray(self.uncertainty * np.abs(np.abs(self.p) - np.abs(self.q)))

    def position(self, surface: Surface) -> np.ndarray:
        """(k, 3) float64 places in the coordinates of the surface."""
        corners = surface.vertices[surface.triangles[self.triangle]]
        return np.asarray(np.einsum("rk,rkc->rc", self.barycentric, corners))


def locate(
    analysed: Analysed, turning: Turning, settings: Settings, progress: Progress
) -> Located:
    """The raw, refined where jets allow it."""
    found = _in_triangles(analysed, turning.raw, turning.elliptic, settings)
    as_found = settings.method == "I" or settings.triangles == "published"
    if analysed.fitted.neighbourhood is None or as_found:
        return found
    if turning.of_form is not None:
        # What wide fits show narrower ones would only move.
        none = np.zeros(len(found), bool)
        return replace(found, asked=none, seen=turning.of_form, clarity=none.astype(float))
    # Pairs that drown in the noise of the fit have no place to be looked for, and a scan has
    # hundreds of thousands of them.
    asked = ~made_by_noise(turning.persistence, turning.partner, DROWNED * found.noise)
    return _refined(analysed, found, asked, progress)


def _in_triangles(
    analysed: Analysed, raw: RawUmbilics, elliptic: np.ndarray, settings: Settings
) -> Located:
    """The raw where their triangles have them, by linear interpolation between the corners."""
    surface, fitted = analysed.surface, analysed.fitted
    corners = surface.triangles[raw.triangle]

    def between(values: np.ndarray) -> np.ndarray:
        return np.asarray(np.einsum("rk,rk...->r...", raw.barycentric, values[corners]))

    local = "projection" if settings.parametrization == "projection" else "conformal"
    deviators = face_deviators(surface, fitted.field, raw.triangle, local)
    p, q = cubic_form.in_triangles(
        surface.vertices[corners], deviators.values, deviators.x, deviators.y
    )
    error = noise = between(analysed.noise)
    if settings.curvature == "given":
        # What the user gives has no noise that could make pairs.
        noise = np.full(len(raw), np.nan)
    slope_error = np.zeros(len(raw))
    if fitted.neighbourhood is not None:
        # Corners of one triangle share most of their samples: the slopes between them err as those
        # of one fit do.
        reach = np.maximum(fitted.radius[corners].mean(axis=1), np.finfo(float).tiny)
        slope_error = SLOPE_ERROR[DEGREE] * noise / reach
    return Located(
        singular=raw.triangle,
        triangle=raw.triangle,
        barycentric=raw.barycentric,
        vertex=raw.vertex,
        index=raw.index,
        elliptic=elliptic,
        normal=between(fitted.field.normal),
        x=deviators.x,
        y=deviators.y,
        p=p,
        q=q,
        curvature=between(0.5 * (fitted.field.k1 + fitted.field.k2)),
        noise=noise,
        uncertainty=_uncertainty(error, p, q),
        slope_error=slope_error,
        clarity=np.full(len(raw), np.nan),
        asked=np.ones(len(raw), bool),
        seen=np.ones(len(raw), bool),
    )


def _refined(
    analysed: Analysed, found: Located, asked: np.ndarray, progress: Progress
) -> Located:
    """Those `asked` (k,) moved to where finer fits show them; elsewhere the triangle's own place is
    kept."""
    rows = np.flatnonzero(asked)
    places = refine(
        analysed.surface, found.triangle[rows], found.barycentric[rows], analysed.fitted, progress
    )
    agrees = places.agrees(found.index[rows])
    rows = rows[agrees]
    seen, uncertainty = np.zeros(len(found), bool), found.uncertainty.copy()
    seen[rows] = True
    values = {name: getattr(found, name).copy() for name in _REFINED}
    values["clarity"] = np.zeros(len(found))
    for name, value in values.items():
        value[rows] = getattr(places, name)[agrees]
    uncertainty[rows] = _uncertainty(places.error, places.p, places.q)[agrees]
    return replace(found, asked=asked, seen=seen, uncertainty=uncertainty, **values)


def _uncertainty(error: np.ndarray, p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """(k,) error of the place: that of the deviator over its least slope ||p|-|q||."""
    slope = np.abs(np.abs(p) - np.abs(q))
    largest = np.full(len(p), LARGEST)
    return np.fmin(np.divide(error, slope, out=largest, where=slope > 0), LARGEST)


def deviator_errors(
    surface: Surface,
    found: Located,
    kept: np.ndarray,
    fitted: Estimate,
    progress: Progress,
) -> np.ndarray:
    """(k,) standard errors of the deviators at located places, bias and all.

    Parameters
    ----------
    kept:
        (k,) bool, those that are looked at for the bias of the fit that their place is read off;
        of the others, and where there are too few samples, errors are as the fit tells them, times
        what they usually leave out.
    """
    error = found.error
    if fitted.neighbourhood is None:
        return error
    if fitted.neighbourhood.focused:
        return BIAS_CLEAN * error
    if fitted.rings is not None:
        error *= BIAS_WINDOWS
    rows = np.flatnonzero(kept & found.seen & np.isfinite(found.clarity) & np.isfinite(error))
    if not len(rows):
        return error
    beyond = next_order(surface, found.triangle[rows], found.barycentric[rows], fitted, progress)
    square = with_bias(beyond)
    known = np.isfinite(square)
    error[rows[known]] = np.sqrt(square[known])
    return error


def with_bias(beyond: NextOrder) -> np.ndarray:
    """(k,) mean square errors of deviators, the bias of their fits among it; NaN where terms of the
    next order are not known.

    Without bias the mean square of what these change is the difference of both variances (Hausman
    1978). The biases are taken for draws of one complex normal law, in units of that difference, of
    as much as all terms of the next order show in the residuals: they take x times as much from
    these as noise does. If nothing is known of it before (Jeffreys' prior, 1 / w), the share w of
    the noise in the changes has the density w^(n/2 - 1) exp(-w n x / 2) up to 1, for n terms of all
    places. Given w, a bias is 1 - w of the change, give or take 1 - w of the difference (Efron &
    Morris 1973, https://doi.org/10.1080/01621459.1973.10481350).

    Chosen on seeds 500, 800, 821 and 830 of benchmarks.people. On these and 200, 700, 701, 810,
    811, 820 and 831, where nothing was chosen, it takes the umbilics found within one, two and
    three standard errors from 43, 74 and 89 % to 54, 86 and 97 % under noise, and from 45, 80 and
    94 % to 56, 87 and 97 % on coarse, decimated and voxel meshes. In root mean square errors are
    .98 and .97 of what is stated, where they were 1.34 and 1.16.
    """
    known = np.isfinite(beyond.change)
    # Residuals that fall with the degree held bias themselves: then all but nothing is noise.
    added = np.maximum(beyond.larger - beyond.variance, NOISE * beyond.variance)
    half = 0.5 * float(beyond.terms[known].sum())
    taken = 0.5 * float((beyond.terms * beyond.explained)[known].sum())
    share = (np.arange(STEPS) + 0.5) / STEPS
    density = (half - 1.0) * np.log(share) - taken * share
    density = np.exp(density - density.max())
    density /= density.sum()
    one, two = density @ (1.0 - share), density @ np.square(1.0 - share)
    return np.asarray(beyond.variance + one * added + two * np.square(beyond.change))


def standard_errors(found: Located, error: np.ndarray | None = None) -> np.ndarray:
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
    error:
        (k,) as `deviator_errors` gives them; those that their places were found with if None.
    """
    least, most = np.abs(np.abs(found.p) - np.abs(found.q)), np.abs(found.p) + np.abs(found.q)
    if error is None:
        error = found.error
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        stated = 0.5 * error * np.hypot(1.0 / least, 1.0 / most)
    stated = np.fmin(np.nan_to_num(stated, nan=LARGEST), LARGEST)
    return np.where(np.isnan(found.p), found.uncertainty, stated)
