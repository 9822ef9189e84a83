"""How far the fits of third derivatives reach, chosen from what they say themselves.

As for the curvature (`scale`): from one ring to the next e changes by what the smaller fit was
wrong. Where errors of the points are averaged out that change falls from ring to ring, where the
surface's own shape is lost it rises; errors that neighbours share, of marching cubes and of
decimation, show in this trend and in no residual.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...base.progress import Progress
from ...mesh.neighbourhoods import Neighbourhood
from ...mesh.rings import adjacency
from ...mesh.surface import Surface
from .bend import ROUND, bending_of
from .nested import NestedFits
from .slopes import Fitting, Slopes, fit_slopes

# Degree four. Its bias (one part in twenty of e where the mesh is clean) grows with e and leaves
# ridges where they are; degree five, though nearer to e, needs two or three rings more under noise
# and shows several times the false length.
DEGREE = 4
# Near samples count more in the narrowest fit. In wider ones all count alike: they say as much as
# weighted ones with two rings more, in half the time.
FOCUS = 1.0
FEWEST_RINGS, MOST_RINGS = 3, 11
# Vertices that are fitted at every reach to choose one.
SAMPLED = 250
# A ridge's place is e over its slope: this error of it in edges, median over the mesh, is fine
# enough, and a wider fit would only add bias and time. Chosen on ellipsoids, tori and quartics of
# benchmarks.ridges, confirmed on x^8 + y^8 + z^8 = 1 and a stretched quartic.
FINE = 0.15
# The change falls where it is below this share of the change one ring before: the share that the
# curvature's scale takes, confirmed on the surfaces of benchmarks.ridges.
FALLING = 0.85
# Share of its variance that a fit is taken to lose to the next ring at least.
LEAST_FALL = 0.3
# Median of the size of a normal deviate.
MEDIAN = 0.6745
# Root mean square distance of the samples in radii of curvature, beyond which they stand more
# beside the tangent plane than over it.
MOST_TURN = 0.8


def choose_fitting(surface: Surface, axes: np.ndarray, progress: Progress) -> Fitting:
    """The narrowest fit that places ridges finely, or the widest that takes errors away.

    Parameters
    ----------
    axes:
        (3, 3, n) as for `fit_slopes`.
    """
    around = Neighbourhood(surface, adjacency(surface), rings=FEWEST_RINGS, focused=False)
    narrowest = Fitting(around, DEGREE, FOCUS)
    centres = _sample(surface)
    if not len(centres):
        return narrowest
    edge = surface.mean_side
    focused = fit_slopes(surface, axes, narrowest, Progress(), centres)
    if not focused.determined.any() or _misplaced(focused) <= FINE * edge:
        return narrowest
    fitting, _ = reaching(surface, axes, replace(narrowest, focus=None), MOST_RINGS, progress)
    return narrowest if fitting.neighbourhood.rings == FEWEST_RINGS else fitting


def reaching(
    surface: Surface, axes: np.ndarray, fitting: Fitting, most: int, progress: Progress
) -> tuple[Fitting, float]:
    """The fitting with as many rings, up to so many, as take errors away, and how much larger than
    independent errors make it the change of e is when it reaches one ring farther, at least 1.

    Parameters
    ----------
    axes:
        (3, 3, n) as for `fit_slopes`.
    """
    fewest = fitting.neighbourhood.rings
    nested = NestedFits(surface, axes, _sample(surface), fitting.degree, fewest)
    smaller, last = nested.slopes(), np.inf
    while True:
        rings = fitting.neighbourhood.rings
        progress.step((rings - fewest) / max(most - fewest, 1))
        nested.widen()
        larger = nested.slopes()
        change, expected = _change(smaller, larger)
        known = expected > 0.0 and np.isfinite(change)
        shared = max(change / expected, 1.0) if known else 1.0
        fine = shared * _misplaced(smaller) <= FINE * surface.mean_side
        if fine or change >= FALLING * last or _turn(larger) > MOST_TURN or rings >= most:
            return fitting, shared
        fitting, smaller, last = fitting.wider(1), larger, change


def _sample(surface: Surface) -> np.ndarray:
    """(c,) vertices that are fitted to choose by: some of those inside."""
    interior = np.flatnonzero(~surface.border)
    return interior[:: max(len(interior) // SAMPLED, 1)]


def _misplaced(slopes: Slopes) -> float:
    """Median error of e over the median slope of e: by how much ridges are misplaced.

    Where it has no slope, on tubes, that of the flattest ridge that counts as one.
    """
    known = slopes.determined
    flattest = bending_of(np.abs(slopes.k[:, known]), ROUND)
    slope = float(np.median(np.maximum(np.abs(slopes.bending[:, known]), flattest)))
    return float(np.median(slopes.error[:, known])) / max(slope, np.finfo(float).tiny)


def _turn(slopes: Slopes) -> float:
    """Median reach of the fits in radii of curvature."""
    return float(np.median(slopes.radius * np.abs(slopes.k).max(axis=0)))


def _change(smaller: Slopes, larger: Slopes) -> tuple[float, float]:
    """Median change of e from one fit to the next, and what it would be with independent errors:
    its variance is then the difference of both (Hausman 1978)."""
    both = smaller.determined & larger.determined
    if not both.any():
        return np.inf, 0.0
    turned = np.einsum("fnc,fnc->fn", smaller.d, larger.d)[:, both] < 0
    change = smaller.e[:, both] - np.where(turned, -larger.e[:, both], larger.e[:, both])
    variance = float(np.median(smaller.error[:, both] ** 2))
    fallen = variance - float(np.median(larger.error[:, both] ** 2))
    expected = MEDIAN * np.sqrt(max(fallen, LEAST_FALL * variance))
    return float(np.median(np.abs(change))), float(expected)
