"""Third derivatives that ridges are found from: one fit says whether they are there, another where.

A fit of degree four takes what varies with the fifth power across its window for a part of the
third derivative, and beside a crest whose sides differ the zero of that is moved. A fit of degree
six is not misled so, but follows the errors of the points more. Both are nested models: without
bias their difference has the difference of their variances (Hausman 1978). So along each ridge the
difference that is more than this counts, and the part of it that errors make does not (the
positive part of James & Stein 1961). Errors that neighbours share, of marching cubes and of
decimation, are seen as in `reach`, by how fits of degree six change from ring to ring; how far
these reach is chosen by the same trend, since what they average out is other than at degree four.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
from scipy.spatial import cKDTree

from ...base.progress import Progress
from ...base.subsets import places_in
from ...curvature.field import CurvatureField
from ...mesh.rings import ring_around
from ...mesh.surface import Surface
from .find import CERTAIN, WEAK, Chains, find_ridges
from .reach import MEDIAN, choose_fitting, reaching
from .slopes import Fitting, Slopes, fit_slopes
from .sought import sought_slopes

# Rings of fits from which on they are made near crests only: narrower ones cost less than to look.
WIDE = 5
# Degree of the fits that place ridges, of 5 to 8 the best on the stretched quartic of
# benchmarks.ridges; and how many rings they reach at most, two more than those that find them.
PLACING, FARTHEST = 6, 13
# Rings around the triangles of ridges in which e is corrected.
BESIDE = 2


def measure_slopes(
    surface: Surface, field: CurvatureField, progress: Progress, crests_only: bool = True
) -> Slopes:
    """What ridges are found from, at the n vertices.

    Parameters
    ----------
    field:
        Shape operators at the n vertices; the fits start from their directions.
    crests_only:
        Crests are looked for alone: fits that are wide are then made near these only.
    """
    axes = np.stack([field.d1.T, field.d2.T, field.normal.T])
    fitting = choose_fitting(surface, axes, progress.part("Choosing the scale of ridges", 0, 0.2))
    part = progress.part("Fitting third derivatives", 0.2, 0.7)
    if fitting.neighbourhood.rings < WIDE or not crests_only:
        slopes = fit_slopes(surface, axes, fitting, part)
    else:
        slopes = sought_slopes(surface, axes, fitting, (WEAK, CERTAIN), part)
    part = progress.part("Fitting third derivatives", 0.7, 1.0)
    return placed_slopes(surface, axes, fitting, slopes, crests_only, part)


def placed_slopes(
    surface: Surface,
    axes: np.ndarray,
    fitting: Fitting,
    slopes: Slopes,
    crests_only: bool,
    progress: Progress,
) -> Slopes:
    """The slopes, their e beside the ridges found from them corrected by fits of a higher degree.

    Parameters
    ----------
    axes, fitting:
        As for `fit_slopes`, those that the slopes are of.
    """
    quiet = progress.quiet()
    chains = find_ridges(surface, slopes, crests_only=crests_only, progress=quiet).chains
    if not len(chains):
        return slopes
    rows = ring_around(surface, np.unique(surface.triangles[chains.triangle]), BESIDE)
    rows = rows[slopes.determined[rows]]
    placing = replace(fitting, degree=PLACING, focus=None)
    placing, shared = reaching(surface, axes, placing, FARTHEST, quiet)
    found = fit_slopes(surface, axes, placing, progress, rows)
    e, shown = slopes.e.copy(), slopes.shown.copy()
    ridge = np.repeat(np.arange(len(chains)), np.diff(chains.start))
    for family in range(2):
        points = np.flatnonzero(chains.family[ridge] == family)
        if not len(points):
            continue
        first, second = (
            _at_points(surface, chains, points, family, *some)
            for some in ((slopes, np.arange(len(surface.vertices))), (found, rows))
        )
        lacking = second[0] - first[0]
        variance = shared**2 * np.maximum(second[1] ** 2 - first[1] ** 2, 0.0)
        lacking *= _shares(lacking, variance, ridge[points])
        # Across a ridge e errs in proportion to itself, which leaves it where it is: all vertices
        # beside it are corrected by what e lacks on it.
        corners = np.unique(surface.triangles[chains.triangle[points]])
        beside = np.intersect1d(rows, ring_around(surface, corners, BESIDE), assume_unique=True)
        _, nearest = cKDTree(chains.position[points]).query(surface.vertices[beside])
        along = np.einsum("bc,bc->b", slopes.d[family, beside], chains.d[points[nearest]])
        shown[family, beside] = True
        e[family, beside] += np.where(along < 0.0, -lacking[nearest], lacking[nearest])
    return replace(slopes, e=e, shown=shown)


def _at_points(
    surface: Surface,
    chains: Chains,
    points: np.ndarray,
    family: int,
    slopes: Slopes,
    rows: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """e along the directions of the points (q,) of ridges, and its error, interpolated between the
    vertices `rows` that slopes are of; NaN beside one that is not determined."""
    corner = places_in(rows, len(surface.vertices))[surface.triangles[chains.triangle[points]]]
    known = (corner >= 0) & slopes.determined[corner]
    weight = chains.barycentric[points]
    weight = np.where(known | (weight == 0.0), weight, np.nan)
    along = np.einsum("qkc,qc->qk", slopes.d[family][corner], chains.d[points])
    e = np.where(along < 0.0, -slopes.e[family][corner], slopes.e[family][corner])
    return (weight * e).sum(axis=1), (weight * slopes.error[family][corner]).sum(axis=1)


def _shares(lacking: np.ndarray, variance: np.ndarray, ridge: np.ndarray) -> np.ndarray:
    """(q,) which share of what the first fit lacks at points of ridges is no error, the same along
    each ridge (q,), whose points are in one piece; 0 where it is not known."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = lacking**2 / variance
    share = np.zeros(len(ridge))
    ends = np.flatnonzero(np.diff(ridge, append=-1)) + 1
    for begin, end in pairwise([0, *ends]):
        known = ratio[begin:end][~np.isnan(ratio[begin:end])]
        if len(known):
            middle = max(float(np.median(known)), np.finfo(float).tiny)
            share[begin:end] = max(1.0 - MEDIAN**2 / middle, 0.0)
    share[np.isnan(lacking)] = 0.0
    return share
