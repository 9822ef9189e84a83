"""Fits of degree four or five around places, over as many samples as the surface there allows.

Noise asks for wide windows and low degrees, detail of the surface for the opposite, and both differ
from place to place. Of a ladder of windows around a place, each fitted by both degrees, each fit is
compared with all of larger variance: what two differ by beyond their variances is the bias of the
steadier one (Goldenshluger & Lepski 2011, https://doi.org/10.1214/10-AOS883). The fit with the
least sum of variance and squared bias stays.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from ...base.progress import Progress
from ...base.unit import unit
from ...fields.frames import frame
from ...mesh.rings import Begun
from ...mesh.surface import Surface
from ..fits.error_growth import error_growth
from ..fits.flattened import fit_flattened, flattened, round_operator
from ..scale import Scale

DEGREES = (4, 5)
# Each window over the one before, and how many.
STEP, STEPS = 1.4, 5
MOST_RINGS = 20
# Samples for each coefficient, below which a fit swings between them.
SAMPLES_PER_TERM = 1.5
# By so many times its variance one of the nine changes to a fit of larger variance exceeds it in
# 5 % of places, each in 0.6 %: the mean of some three squares of a complex Gaussian. Under noise
# (seeds 200, 201, 300 and 301 of benchmarks.people) 2.1, which each exceeds in 5 %, places three
# umbilics fewer of 276 within two edges, of fields and metaballs of 500 and 501 three of 107.
CHANCE = 3.0
# Where fits are compared: the middle and points on a circle, in radii of the narrowest window.
CIRCLE, ROUND = 0.7, 6
BLOCK = 1 << 15


@dataclass(frozen=True)
class Fits:
    """Heights over spheres that touch the tangent planes of k places.

    Attributes
    ----------
    centre:
        (k, 3) float64 places.
    axes:
        (3, 3, k) float64 the plane's axes and its normal there.
    coefficients:
        {(a, b): (k,)} as in `HeightFit`, in units of the radius.
    radius, bend:
        (k,) float64 as in `FlatFit`.
    error, bias:
        (k,) float64 standard error of the deviator in the middle and what is known of its bias, in
        1 / length.
    rings, degree:
        (k,) int64 rings of the samples, 0 where nothing is determined, and degree.
    narrow:
        (k,) float64 radius of the narrowest window that was compared.
    """

    centre: np.ndarray
    axes: np.ndarray
    coefficients: dict[tuple[int, int], np.ndarray]
    radius: np.ndarray
    bend: np.ndarray
    error: np.ndarray
    bias: np.ndarray
    rings: np.ndarray
    degree: np.ndarray
    narrow: np.ndarray


def ladder(rings: int) -> list[int]:
    """Rings of the windows that are compared where cubics take so many."""
    return sorted({min(max(round(rings * STEP**k), 3), MOST_RINGS) for k in range(STEPS)})


def best_fits(
    surface: Surface,
    normals: np.ndarray,
    scale: Scale,
    triangles: np.ndarray,
    progress: Progress,
) -> Fits:
    """The best of the ladder's fits around the middles of triangles (k,), over planes across the
    normals (n, 3) of vertices."""
    corners = surface.triangles[triangles]
    centre = surface.vertices[corners].mean(axis=1)
    normal = unit(normals[corners].sum(axis=1))
    axes = np.stack([*frame(normal.T), normal.T])
    *others, widest = ladder(scale.neighbourhood.rings)
    around = dataclasses.replace(scale.neighbourhood, begun=Begun())
    scale = dataclasses.replace(scale, neighbourhood=around)
    # Whether the surface is nearer to a sphere or to a plane shows the most in the widest window.
    last = _window(surface, scale, corners, centre, axes, widest, None, progress)
    planar = (last[-1].rings > 0) & (last[-1].bend == 0.0)
    steps = [
        step
        for rings in others
        for step in _window(surface, scale, corners, centre, axes, rings, planar, progress)
    ]
    steps += last
    known = np.stack([np.where(step.rings > 0, step.radius, np.inf) for step in steps])
    narrow = np.where(np.isfinite(known.min(axis=0)), known.min(axis=0), 1.0)
    best, bias = _least_error(steps, narrow)
    some = np.arange(len(best))

    def chosen(values: list[np.ndarray]) -> np.ndarray:
        return np.stack(values)[best, some]

    return Fits(
        centre=centre,
        axes=axes,
        coefficients={
            term: chosen([step.coefficients[term] for step in steps])
            for term in steps[0].coefficients
        },
        radius=chosen([step.radius for step in steps]),
        bend=chosen([step.bend for step in steps]),
        error=chosen([step.error for step in steps]),
        bias=bias,
        rings=chosen([step.rings for step in steps]),
        degree=chosen([step.degree for step in steps]),
        narrow=narrow,
    )


def _window(
    surface: Surface,
    scale: Scale,
    corners: np.ndarray,
    centre: np.ndarray,
    axes: np.ndarray,
    rings: int,
    planar: np.ndarray | None,
    progress: Progress,
) -> list[Fits]:
    """The fits over so many rings, of each degree, over planes where `planar` (k,) says so; None as
    for `fit_flattened`."""
    k = len(corners)
    most = max(DEGREES)
    terms = [(total - b, b) for total in range(most + 1) for b in range(total + 1)]
    found = [
        Fits(
            centre=centre,
            axes=axes,
            coefficients={term: np.zeros(k) for term in terms},
            radius=np.ones(k),
            bend=np.zeros(k),
            error=np.full(k, np.inf),
            bias=np.zeros(k),
            rings=np.zeros(k, np.int64),
            degree=np.full(k, degree),
            narrow=np.ones(k),
        )
        for degree in DEGREES
    ]
    around = dataclasses.replace(scale.neighbourhood, rings=rings)
    for rows, members, held in around.around_triangles(corners, rings, BLOCK, progress):
        offset = surface.vertices[members] - centre[rows]
        x, y, z = np.einsum("sbc,kcb->ksb", offset, axes[:, :, rows])
        over = None if planar is None else planar[rows]
        fits = fit_flattened(x, y, z, DEGREES, planar=over, held=held)
        for flat, step, degree in zip(fits, found, DEGREES, strict=True):
            fit = flat.heights
            known = fit.determined & (held >= SAMPLES_PER_TERM * (degree + 1) * (degree + 2) / 2)
            for term, values in fit.coefficients.items():
                step.coefficients[term][rows] = values
            step.radius[rows], step.bend[rows] = flat.radius, flat.bend
            error = scale.factor * fit.gap_error / flat.radius
            step.error[rows] = np.where(known, error, np.inf)
            step.rings[rows] = np.where(known, rings, 0)
    return found


def _least_error(steps: list[Fits], narrow: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(k,) which of the fits has the least error, and its bias, from how they differ within the
    narrowest window."""
    angle = 2.0 * np.pi * np.arange(ROUND) / ROUND
    reach = CIRCLE * narrow
    x = np.append(0.0, np.cos(angle))[:, None] * reach
    y = np.append(0.0, np.sin(angle))[:, None] * reach
    values = [_deviators(step, x, y) for step in steps]
    variances = [_variance(step, reach) for step in steps]
    total, biases = [], []
    for one, (value, variance) in enumerate(zip(values, variances, strict=True)):
        bias = np.zeros(len(reach))
        for two, (other, larger) in enumerate(zip(values, variances, strict=True)):
            change = (np.abs(value - other) ** 2).mean(axis=0)
            with np.errstate(invalid="ignore"):
                expected = variance + larger - 2.0 * variances[_steadiest(one, two)]
                excess = np.where(larger > variance, change - CHANCE * expected, 0.0)
            # A window without a fit tells nothing.
            bias = np.fmax(bias, np.where(np.isfinite(excess), excess, 0.0))
        total.append(variance + bias)
        biases.append(bias)
    best = np.stack(total).argmin(axis=0)
    return best, np.sqrt(np.stack(biases)[best, np.arange(len(best))])


def _steadiest(one: int, two: int) -> int:
    """Of the steps, rung by rung in each degree, the one with the wider window and the lower degree
    of two: as long as there is no bias what both differ from it by is independent of it
    (Hausman 1978), and so is nearly the one from the other."""
    count = len(DEGREES)
    return max(one // count, two // count) * count + min(one % count, two % count)


def _variance(fits: Fits, reach: np.ndarray) -> np.ndarray:
    """(k,) variance of the deviators on average over the places that they are compared at."""
    growth = growth_of(fits.degree, reach / fits.radius)
    return np.asarray(fits.error**2 * (1.0 + ROUND * growth) / (1.0 + ROUND))


def growth_of(degree: np.ndarray, away: np.ndarray) -> np.ndarray:
    """(k,) as `error_growth`, of fits of degrees (k,)."""
    growth = np.ones(len(away))
    for own in DEGREES:
        rows = degree == own
        growth[rows] = error_growth(own, away[rows])
    return growth


def _deviators(fits: Fits, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """(s, k) deviators over points (s, k) of the planes, in 1 / length."""
    u, v, _, _ = flattened(x, y, 0.5 * fits.bend * (x * x + y * y), fits.bend)
    # All at once: places are few, and each call costs more than they do.
    coefficients = {term: np.tile(value, len(x)) for term, value in fits.coefficients.items()}
    radius, bend = np.tile(fits.radius, len(x)), np.tile(fits.bend, len(x))
    operator = round_operator(coefficients, radius, bend, u.ravel() / radius, v.ravel() / radius)
    return operator.deviator.reshape(x.shape)
