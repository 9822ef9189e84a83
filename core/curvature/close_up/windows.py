"""Fits of degree four around places, over as many samples as the surface there allows.

Noise asks for wide windows, detail of the surface for narrow ones, and both differ from place to
place. Of a ladder of windows around a place each is compared with all narrower ones: what two
differ by beyond their variances is the bias of the wider one (Goldenshluger & Lepski 2011,
https://doi.org/10.1214/10-AOS883). The window with the least sum of variance and squared bias
stays, and that sum is the error.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from ...base.progress import Progress
from ...base.unit import unit
from ...fields.frames import frame
from ...mesh.surface import Surface
from ..fits.height_fit import fit_heights
from ..fits.monge import deviator_at
from ..scale import Scale

DEGREE = 4
# Each window over the one before, and how many.
STEP, STEPS = 1.4, 5
MOST_RINGS = 20
# Samples for each coefficient, below which a fit swings between them.
SAMPLES_PER_TERM = 1.5
# A change between windows that share no bias exceeds so many times its variance in 5 % of places:
# the mean of some three squares of a complex Gaussian. 4 does no worse (seeds 0 to 2 of
# benchmarks.people), 1 loses one umbilic in twenty under noise.
CHANCE = 2.1
# Where windows are compared: the middle and points on a circle, in radii of the narrowest.
CIRCLE, ROUND = 0.7, 6
BLOCK = 1 << 15


@dataclass(frozen=True)
class Fits:
    """Height functions over the tangent planes of k places.

    Attributes
    ----------
    centre:
        (k, 3) float64 places.
    axes:
        (3, 3, k) float64 the plane's axes and its normal there.
    coefficients:
        {(a, b): (k,)} as in `HeightFit`, in units of the radius.
    radius:
        (k,) float64 root mean square distance of the samples in the plane.
    error:
        (k,) float64 standard error of the deviator, in 1 / length: variance and squared bias.
    rings:
        (k,) int64 rings of the samples; 0 where nothing is determined.
    narrow:
        (k,) float64 radius of the narrowest window that was compared.
    """

    centre: np.ndarray
    axes: np.ndarray
    coefficients: dict[tuple[int, int], np.ndarray]
    radius: np.ndarray
    error: np.ndarray
    rings: np.ndarray
    narrow: np.ndarray


def ladder(rings: int) -> list[int]:
    """Rings of the windows that are compared where cubics take so many."""
    return sorted({min(max(round(rings * STEP**k), 3), MOST_RINGS) for k in range(STEPS)})


def best_fits(surface: Surface, scale: Scale, triangles: np.ndarray, progress: Progress) -> Fits:
    """The best of the ladder's fits around the middles of triangles (k,)."""
    corners = surface.triangles[triangles]
    centre = surface.vertices[corners].mean(axis=1)
    normal = unit(scale.normals[corners].sum(axis=1))
    axes = np.stack([*frame(normal.T), normal.T])
    steps = [
        _window(surface, scale, corners, centre, axes, rings, progress)
        for rings in ladder(scale.neighbourhood.rings)
    ]
    known = np.stack([np.where(step.rings > 0, step.radius, np.inf) for step in steps])
    narrow = np.where(np.isfinite(known.min(axis=0)), known.min(axis=0), 1.0)
    best, error = _least_error(steps, narrow)
    some = np.arange(len(best))

    def chosen(values: list[np.ndarray]) -> np.ndarray:
        return np.stack(values)[best, some]

    coefficients = {
        term: chosen([step.coefficients[term] for step in steps]) for term in steps[0].coefficients
    }
    return Fits(
        centre,
        axes,
        coefficients,
        chosen([step.radius for step in steps]),
        error,
        chosen([step.rings for step in steps]),
        narrow,
    )


def _window(
    surface: Surface,
    scale: Scale,
    corners: np.ndarray,
    centre: np.ndarray,
    axes: np.ndarray,
    rings: int,
    progress: Progress,
) -> Fits:
    k = len(corners)
    terms = [(total - b, b) for total in range(DEGREE + 1) for b in range(total + 1)]
    found = Fits(
        centre,
        axes,
        {term: np.zeros(k) for term in terms},
        np.ones(k),
        np.full(k, np.inf),
        np.zeros(k, np.int64),
        np.ones(k),
    )
    around = dataclasses.replace(scale.neighbourhood, rings=rings)
    for rows, members in around.around_triangles(corners, rings, BLOCK, progress):
        if len(members) < SAMPLES_PER_TERM * len(terms):
            continue
        offset = surface.vertices[members] - centre[rows]
        x, y, z = np.einsum("sbc,kcb->ksb", offset, axes[:, :, rows])
        radius = np.maximum(np.sqrt((x * x + y * y).mean(axis=0)), np.finfo(float).tiny)
        fit = fit_heights(x / radius, y / radius, z / radius, None, DEGREE)
        for term, values in fit.coefficients.items():
            found.coefficients[term][rows] = values
        found.radius[rows] = radius
        error = scale.factor * fit.gap_error / radius
        found.error[rows] = np.where(fit.determined, error, np.inf)
        found.rings[rows] = np.where(fit.determined, rings, 0)
    return found


def _least_error(steps: list[Fits], narrow: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(k,) which of the windows has the least error, and that error, from how they differ within
    the narrowest."""
    angle = 2.0 * np.pi * np.arange(ROUND) / ROUND
    reach = CIRCLE * narrow
    x = np.append(0.0, np.cos(angle))[:, None] * reach
    y = np.append(0.0, np.sin(angle))[:, None] * reach
    values = [_deviators(step, x, y) for step in steps]
    total = []
    for value, step in zip(values, steps, strict=True):
        variance, bias = step.error**2, np.zeros(len(reach))
        for other, smaller in zip(values, steps, strict=True):
            change = (np.abs(value - other) ** 2).mean(axis=0)
            with np.errstate(invalid="ignore"):
                more = smaller.error**2 - variance
                excess = np.where(more > 0, change - CHANCE * more, 0.0)
            # A window without a fit tells nothing.
            bias = np.fmax(bias, np.where(np.isfinite(excess), excess, 0.0))
        total.append(variance + bias)
    error = np.stack(total)
    best = error.argmin(axis=0)
    return best, np.sqrt(error.min(axis=0))


def _deviators(fits: Fits, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """(s, k) deviators at points (s, k) of the planes, in 1 / length."""
    return deviator_at(fits.coefficients, x / fits.radius, y / fits.radius) / fits.radius
