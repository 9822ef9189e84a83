"""The scale at which a surface is looked at: how far the jets reach, chosen from the data.

A fit over few rings follows the errors of the points, one over many smooths the surface away.
From one ring to the next the deviator changes by what the smaller fit was wrong: where errors
of the points are averaged out the change falls from ring to ring, where the surface's own shape
is lost it rises. The rings grow while it falls. Errors that neighbours share, those of marching
cubes and of decimation, show in this trend; the residuals of a fit, which take them for shape,
do not tell them (Lepski 1991 compares scales by such standard errors). Errors as small as the
rounding of coordinates are independent: there the residuals tell them, and the rings also grow as
long as they make more of the change than the shape that is lost.

One scale serves the whole mesh: the medians need many vertices.
"""

from __future__ import annotations

import dataclasses
from itertools import pairwise

import numpy as np

from ..base.progress import Progress
from ..fields.frames import frame
from ..mesh.neighbourhoods import Neighbourhood
from ..mesh.normals import Smoothing, smooth_normals
from ..mesh.rings import Begun
from ..mesh.surface import Surface
from .fits.jets import DEGREE, SAMPLES_PER_BLOCK, Jets, fit_jets

# Vertices that are fitted at every scale to choose one; medians over them are steady.
SAMPLED = 500
# The change falls where it is below this share of the change one ring before. The true error of
# the scale chosen so is 1.00 to 1.17 times the least on average, at most 1.5 times, over clean,
# coarse, noisy, decimated and marching cubes meshes of 14 surfaces (seeds 0 to 2 of
# benchmarks.people); 0.75 to 0.9 hardly differ.
FALLING = 0.85
# Least share of its variance that a fit is taken to lose to the next ring.
LEAST_FALL = 0.3
# Errors that neighbours share make cubics on marching cubes and decimated meshes up to five times
# worse than independent ones, those of scans four to six times; what is more is creases and such.
# Of clean meshes the change is the surface's own shape, of which the next ring smooths more.
MOST_FACTOR, MOST_CLEAN = 6.0, 3.0
# How much larger the residuals over the next ring are, from which on neighbours share errors. Where
# each point errs by itself a fit over n of them is too wide as soon as it misses some root n th of
# an error in the heights, of which residuals tell next to nothing: under noise they grow 1.24 times
# at most, half of them less than 1.06 times. Errors that neighbours share are followed as shape is,
# and the residuals are what fits miss of it: out of marching cubes and decimated they grow 1.25 to
# 2.2 times (seeds 200, 500 and 800 of benchmarks.people; on 700 and 701, 1.24 in the only one below
# and 1.25 in the only one above of 60). The change is 1.0 to 2.7 and 1.5 to 4.7 times what
# independent errors make.
SHARED = 1.245
# Eight rings hold about 200 vertices; heavier noise than they average out hides the surface.
MOST_RINGS = 8
# Length over width of the rings around the median vertex above which the nearest samples stand
# for the rings. On noisy ellipsoids of stretched triangles this places umbilics to 0.2 to 0.6
# edges instead of 1 to 2.3, and x^4 + y^4 + z^4 = 1 shows its stars at all.
STRETCHED = 1.5
# Neighbourhoods of meshes more stretched than this would reach over them.
MOST_STRETCH = 16.0
# Residuals below this share of the radius tilt no normal that a fit starts from so far that it
# would matter: heights over a plane askew by t are wrong by t^2. They are those of rounding, and
# not of scans (0.5 % of an edge and more), marching cubes or decimation.
# Chosen on perturbed ellipsoids; on harmonics, a field and metaballs with errors of 1e-5 to 1e-2
# edges the curvatures are wrong by the same wherever it is set, to 3 % where triangles have equal
# sides and 3 % on average, either way, where they are four times as long as wide.
LEVEL = 1e-4
# Residuals below this share of the radius are round-off: there is no noise to average out.
ROUND_OFF = 1e-10


@dataclasses.dataclass(frozen=True)
class Scale:
    """How far fits reach, and what their standard errors leave out.

    Attributes
    ----------
    neighbourhood:
        What each jet is fitted to.
    tilted:
        Whether errors of the points tilt the normals that fits would start from so far that they
        are to be smoothed first; see `starting_normals`.
    factor:
        Error over the standard error that independent residuals give, at least 1.
    clean:
        Whether the standard errors of the next ring are no less than those of the first: what is
        left of the heights is what the fits miss of the surface, and not errors of the points.
    shared:
        Whether neighbours share errors, so that standard errors tell little of them.
    """

    neighbourhood: Neighbourhood
    tilted: bool = False
    factor: float = 1.0
    clean: bool = False
    shared: bool = False


def choose(
    surface: Surface, normals: np.ndarray, neighbourhood: Neighbourhood, progress: Progress
) -> Scale:
    """The scale that the errors of the surface ask for; from two rings on.

    Parameters
    ----------
    normals:
        (n, 3) float64 unit vertex normals, not smoothed.
    """
    focused = dataclasses.replace(neighbourhood, rings=2, focused=True, stretch=1.0)
    interior = np.flatnonzero(~surface.border)
    if not len(interior):
        return Scale(focused)
    centres = interior[:: max(len(interior) // SAMPLED, 1)]
    two = fit_jets(surface, normals, focused, progress, centres)
    if np.median(two.residual) <= ROUND_OFF * np.median(two.radius):
        return Scale(focused, clean=True)
    stretch = min(_stretch(focused, centres), MOST_STRETCH)
    wide = dataclasses.replace(
        focused, focused=False, stretch=stretch if stretch >= STRETCHED else 1.0
    )
    shapes = [wide]
    if wide.stretch > 1.0 and np.median(two.residual) <= LEVEL * np.median(two.radius):
        # Where there is little to average out, triangles that are long where the surface is
        # straight know better than discs.
        shapes = [dataclasses.replace(wide, stretch=1.0), wide]
    begun = Begun()
    scales = [
        _grown(
            normals,
            shape,
            centres,
            progress,
            DEGREE,
            MOST_RINGS,
            begun,
            SmoothedNormals(normals, shape, centres, progress.quiet()),
        )
        for shape in shapes
    ]
    grown = scales[0][0]
    if len(scales) > 1:
        # Where triangles are long only in places the median of the changes would not tell.
        axes = normals[centres]
        changes = [np.square(_changes(*pair, axes)).mean() for _, pair in scales]
        grown = scales[int(np.argmin(changes))][0]
    if grown.neighbourhood.rings == 2:
        return Scale(focused, clean=grown.clean)
    return grown


def grow_while_it_falls(
    normals: np.ndarray,
    neighbourhood: Neighbourhood,
    centres: np.ndarray,
    progress: Progress,
    degree: int = DEGREE,
    most: int = MOST_RINGS,
    smoothing: SmoothedNormals | None = None,
) -> Scale:
    """Rings, from those of the neighbourhood up to `most`, as long as the change falls.

    Parameters
    ----------
    normals:
        (n, 3) float64 unit normals that the first fits start from.
    centres:
        (c,) vertices whose fits are compared.
    degree:
        Degree of the fits.
    smoothing:
        What smooths the normals further with the rings; None where errors of the points do not
        tilt them, as those of fits.
    """
    begun = Begun()
    return _grown(normals, neighbourhood, centres, progress, degree, most, begun, smoothing)[0]


def _grown(
    normals: np.ndarray,
    neighbourhood: Neighbourhood,
    centres: np.ndarray,
    progress: Progress,
    degree: int,
    most: int,
    begun: Begun,
    smoothing: SmoothedNormals | None = None,
) -> tuple[Scale, tuple[Jets, Jets]]:
    """As `grow_while_it_falls`, with the fits at the scale and at the next."""

    def at(rings: int, start: np.ndarray) -> Jets:
        around = dataclasses.replace(neighbourhood, rings=rings, begun=begun)
        return fit_jets(around.surface, start, around, progress, centres, degree)

    axes = normals[centres]
    rings = neighbourhood.rings
    fits = [at(rings + more, normals) for more in range(3)]
    rough = bool(np.median(fits[0].residual) > LEVEL * np.median(fits[0].radius))
    clean = bool(np.median(fits[1].noise) >= np.median(fits[0].noise))
    changes = [float(np.median(_changes(*pair, axes))) for pair in pairwise(fits)]
    start = normals
    while rings < most and (
        changes[1] < FALLING * changes[0]
        or (not rough and _pays(fits[0], fits[1], changes[0], degree))
    ):
        rings += 1
        if rough and smoothing is not None:
            start = smoothing.further(rings)
        fits = [*fits[1:], at(rings + 2, start)]
        changes = [changes[1], float(np.median(_changes(fits[1], fits[2], axes)))]
    around = dataclasses.replace(neighbourhood, rings=rings)
    factor = _factor(fits[0], fits[1], changes[0], MOST_CLEAN if clean else MOST_FACTOR)
    # Detail as fine as noise is shared as well, and hides in residuals.
    shared = factor > MOST_CLEAN
    shared |= bool(np.median(fits[1].residual) > SHARED * np.median(fits[0].residual))
    return Scale(around, rough, factor, clean, shared), (fits[0], fits[1])


class SmoothedNormals:
    """Normals smoothed further and further, as far as `starting_normals` does for the rings.

    Around few of many vertices each is smoothed for itself, and from where patches stand for the
    vertices their normals do.

    Attributes
    ----------
    normals, passes:
        (n, 3) float64 unit normals, and how often they were smoothed.
    """

    def __init__(
        self,
        normals: np.ndarray,
        neighbourhood: Neighbourhood,
        centres: np.ndarray,
        progress: Progress,
        passes: int = 0,
    ) -> None:
        self.normals, self.passes = normals, passes
        self.neighbourhood, self.centres, self.progress = neighbourhood, centres, progress

    def further(self, rings: int) -> np.ndarray:
        """(n, 3) normals for scales of so many rings, right at the centres; their windows have two
        more."""
        patches = dataclasses.replace(self.neighbourhood, rings=rings + 2).patches
        if patches is not None:
            return patches.normals
        smoothing = Smoothing(self.neighbourhood.surface)
        if self.neighbourhood.patching is not None:
            return smoothing.smoothed_at(self.normals, rings, self.centres)
        self.normals = smoothing.smoothed(self.normals, rings - self.passes, self.progress)
        self.passes = rings
        return self.normals


def starting_normals(
    surface: Surface, normals: np.ndarray, neighbourhood: Neighbourhood, progress: Progress
) -> np.ndarray:
    """(n, 3) normals to start the fits from: noise that asks for more than two rings also tilts
    the normals of small triangles, so they are smoothed as far as the rings reach."""
    if neighbourhood.rings == 2:
        return normals
    return smooth_normals(surface, normals, neighbourhood.rings, progress)


def _stretch(neighbourhood: Neighbourhood, centres: np.ndarray) -> float:
    """Median length over width of the rings around some vertices."""
    points = neighbourhood.surface.vertices
    stretch = np.ones(len(centres))
    for rows, members, held in neighbourhood.blocks(centres, SAMPLES_PER_BLOCK):
        there = (np.arange(len(members))[:, None] < held)[:, :, None]
        middle = np.where(there, points[members], 0.0).sum(axis=0) / held[:, None]
        offset = np.where(there, points[members] - middle, 0.0)
        _, width, length = np.linalg.eigvalsh(np.einsum("sbi,sbj->bij", offset, offset)).T
        # A width of less is round-off of the length.
        width = np.maximum(width, np.finfo(float).eps * length)
        stretch[rows] = np.sqrt(length / np.maximum(width, np.finfo(float).tiny))
    return float(np.median(stretch))


def _changes(smaller: Jets, larger: Jets, normals: np.ndarray) -> np.ndarray:
    """(k,) changes of the deviator from one scale to the next where both are determined; infinite
    where none is."""
    both = smaller.determined & larger.determined
    if not both.any():
        return np.array([np.inf])
    e1, e2 = frame(normals.T)
    return np.abs(_deviator(smaller, e1, e2) - _deviator(larger, e1, e2))[both]


def _factor(smaller: Jets, larger: Jets, change: float, most: float) -> float:
    """How much larger the change to the next scale is than standard errors expect, at `most`.

    Were the residuals independent, the variance of the change would be the difference of the
    variances of both fits (Hausman 1978), and the median of its length sqrt(log 2) of its root.
    """
    both = smaller.determined & larger.determined
    if not both.any() or not np.isfinite(change):
        return 1.0
    variance = np.median(smaller.noise[both] ** 2)
    # Clean surfaces leave larger residuals in larger fits.
    fallen = max(variance - np.median(larger.noise[both] ** 2), LEAST_FALL * variance)
    expected = np.sqrt(np.log(2.0) * fallen)
    return min(max(change / expected, 1.0), most) if expected > 0.0 else 1.0


def _pays(smaller: Jets, larger: Jets, change: float, degree: int) -> bool:
    """Whether independent errors alone ask for the next scale: it loses more variance than it gains
    in squared bias.

    The square of the change is the variance lost (Hausman 1978) and the square of the bias gained.
    Bias grows with the radius to the power degree - 1, so that what is gained tells how much
    there was: from b to g b it is (g - 1) b, its square grows by (g + 1) / (g - 1) times that
    squared.
    """
    both = smaller.determined & larger.determined
    if not both.any() or not np.isfinite(change):
        return False
    lost = np.log(2.0) * np.median(smaller.noise[both] ** 2 - larger.noise[both] ** 2)
    grown = np.median(larger.radius[both] / smaller.radius[both]) ** (degree - 1)
    gained = (change**2 - lost) * (grown + 1.0) / max(grown - 1.0, np.finfo(float).tiny)
    return bool(gained < lost)


def _deviator(jets: Jets, e1: np.ndarray, e2: np.ndarray) -> np.ndarray:
    direction = np.einsum("nc,cn->n", jets.d1, e1) + 1j * np.einsum("nc,cn->n", jets.d1, e2)
    return (jets.k1 - jets.k2) * direction**2
