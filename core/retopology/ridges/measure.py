"""Third derivatives that ridges are found from: one fit says whether they are there, another where.

A fit of degree four takes what varies with the fifth power across its window for a part of the
third derivative, and beside a crest whose sides differ the zero of that is moved. So where ridges
are found fits of a higher degree are made too. They err more from vertex to vertex and would show
many a false ridge; but along a ridge what the first fit lacks varies no faster than over its own
reach, and over that the difference of both is averaged.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import sparse

from ...base.factors import definite_factors
from ...base.progress import Progress
from ...base.subsets import places_in
from ...base.unit import unit
from ...curvature.field import CurvatureField
from ...mesh.half_edges import following
from ...mesh.rings import ring_around
from ...mesh.surface import Surface
from .crossings import edge_signs
from .find import CERTAIN, WEAK, find_ridges
from .reach import choose_fitting
from .slopes import Fitting, Slopes, fit_slopes
from .sought import sought_slopes

# Rings of fits from which on they are made near crests only: narrower ones cost less than to look.
WIDE = 5
# Degree of the fits that place ridges, and how many rings farther they reach than those that find
# them. Chosen on the stretched quartic of benchmarks.ridges, confirmed on its other surfaces.
PLACING, FARTHER = 6, 2
# Rings around the triangles of ridges in which e is corrected.
BESIDE = 1
# What the first fit lacks varies across a ridge: an edge counts for the average by this power of
# the squared cosine of its angle to the ridge, half at 33 degrees.
ALONG = 4


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
    chains = find_ridges(surface, slopes, crests_only=crests_only).chains
    corners = np.unique(surface.triangles[chains.triangle])
    rows = ring_around(surface, corners, BESIDE)
    rows = rows[slopes.determined[rows]]
    if not len(rows):
        return slopes
    placing = replace(fitting.wider(FARTHER), degree=PLACING, focus=None)
    found = fit_slopes(surface, axes, placing, progress, rows)
    # Their directions may point the other way.
    agree = np.where(np.einsum("frc,frc->fr", found.d, slopes.d[:, rows]) < 0.0, -1.0, 1.0)
    lacking = np.where(found.determined, agree * found.e - slopes.e[:, rows], 0.0)
    e = slopes.e.copy()
    e[:, rows] += _averaged(surface, slopes, rows, lacking, fitting.neighbourhood.rings)
    return replace(slopes, e=e)


def _averaged(
    surface: Surface, slopes: Slopes, rows: np.ndarray, values: np.ndarray, rings: int
) -> np.ndarray:
    """(2, r) what changes its sign with the directions of each family, averaged over so many edges
    along its ridges among the vertices (r,): least squares between the values and their
    differences over edges."""
    half = np.flatnonzero(np.arange(len(surface.twin)) > surface.twin)
    corners = surface.triangles.ravel()
    place = places_in(rows, len(surface.vertices))
    one, two = place[corners[half]], place[corners[following(half)]]
    inside = (one >= 0) & (two >= 0)
    one, two = one[inside], two[inside]
    sign = edge_signs(surface, slopes).sign[half[inside]]
    way = unit(surface.vertices[rows[two]] - surface.vertices[rows[one]])
    count, averaged = len(rows), np.empty_like(values)
    for family, d in enumerate(slopes.d):
        along = (1.0 - np.einsum("ec,ec->e", way, d[rows[one]]) ** 2) ** ALONG
        strength = rings**2 / 3.0 * along
        across = sparse.coo_array((sign * strength, (one, two)), shape=(count, count)).tocsr()
        degree = np.bincount(one, strength, count) + np.bincount(two, strength, count)
        matrix = sparse.diags_array(1.0 + degree) - (across + across.T)
        averaged[family] = definite_factors(matrix).solve(values[family])
    return averaged
