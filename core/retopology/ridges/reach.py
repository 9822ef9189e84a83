"""How far the fits of third derivatives reach, chosen from what they say themselves."""

from __future__ import annotations

import numpy as np

from ...base.progress import Progress
from ...mesh.neighbourhoods import Neighbourhood, adjacency
from ...mesh.surface import Surface
from .bend import ROUND, bending_of
from .slopes import Fitting, Slopes, fit_slopes

# Degree four with near samples counting more. Its bias (one part in twenty of e where the mesh is
# clean) grows with e and leaves ridges where they are; degree five, though nearer to e, needs two
# or three rings more under noise and shows several times the false length.
DEGREE, FOCUS = 4, 1.0
FEWEST_RINGS, MOST_RINGS = 3, 11
# Vertices that are fitted at every reach to choose one.
SAMPLED = 1000
# A ridge's place is e over its slope: this error of it in edges, median over the mesh, is fine
# enough, and a wider fit would only add bias.
FINE = 0.05
# Median change of e by one more ring, in its standard errors, above which the shape is lost: by
# noise alone it measures 0.4 to 0.6. Errors of marching cubes are not white and begin higher, but
# fall from ring to ring, which no loss of shape does. Chosen on ellipsoids, a skewed one and
# x^6 + y^6 + z^6 = 1 (icosphere, random, marching cubes, decimated, 0 to 5 % noise), confirmed on
# x^4 + y^4 + z^4 = 1 and tori.
AGREEMENT = 0.9
# Root mean square distance of the samples in radii of curvature, beyond which they stand more
# beside the tangent plane than over it.
MOST_TURN = 0.8


def choose_fitting(surface: Surface, axes: np.ndarray, progress: Progress) -> Fitting:
    """The narrowest fit that places ridges finely, or the widest that noise alone explains.

    Parameters
    ----------
    axes:
        (3, 3, n) as for `fit_slopes`.
    """
    around = Neighbourhood(surface, adjacency(surface), rings=FEWEST_RINGS, focused=False)
    fitting = Fitting(around, DEGREE, FOCUS)
    interior = np.flatnonzero(~surface.border)
    centres = interior[:: max(len(interior) // SAMPLED, 1)]
    if not len(centres):
        return fitting
    edge = _edge_length(surface)
    smaller = fit_slopes(surface, axes, fitting, Progress(), centres)
    last = np.inf
    for step in range(FEWEST_RINGS, MOST_RINGS):
        progress.step((step - FEWEST_RINGS) / (MOST_RINGS - FEWEST_RINGS))
        if not smaller.determined.any() or _misplaced(smaller) <= FINE * edge:
            break
        wider = fitting.wider(1)
        larger = fit_slopes(surface, axes, wider, Progress(), centres)
        change = _disagreement(smaller, larger)
        lost = change > AGREEMENT and change >= last
        if lost or _turn(larger) > MOST_TURN:
            break
        fitting, smaller, last = wider, larger, change
    return fitting


def _edge_length(surface: Surface) -> float:
    return float(np.sqrt(surface.side_squares).mean())


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


def _disagreement(smaller: Slopes, larger: Slopes) -> float:
    """Median change of e in standard errors of the smaller fit."""
    both = smaller.determined & larger.determined
    if not both.any():
        return np.inf
    turned = np.einsum("fnc,fnc->fn", smaller.d, larger.d)[:, both] < 0
    change = smaller.e[:, both] - np.where(turned, -larger.e[:, both], larger.e[:, both])
    error = np.maximum(smaller.error[:, both], np.finfo(float).tiny)
    return float(np.median(np.abs(change) / error))
