"""Third derivatives where crests may be, and nowhere else.

Wide fits are dear and change slowly from vertex to vertex. They are made at vertices spread so that
none is far from one of them; at all around those near which a crest stands out; and on from there
along it, until it has come to its end.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from ...base.progress import Progress
from ...base.subsets import spans
from ...mesh.surface import Surface
from .bend import ROUND, bend_of
from .slopes import Fitting, Slopes, fit_slopes, put, unknown

# Side of the cells of which one vertex each is fitted at first, and reach around those that a crest
# may be near, in radii of the fits.
CELL, AROUND = 0.8, 1.0
# A crest passes within so many cells of a vertex, or so many edges of one beside it, as its slope
# has it, where it may be followed on.
NEAR_CELLS, NEAR_EDGES = 1.0, 2.0
# Rings that are fitted on from where a crest is found.
ONWARD = 3
# Share of what is asked of a crest that is asked of a vertex near one.
SHARE = 0.5


def sought_slopes(
    surface: Surface,
    axes: np.ndarray,
    fitting: Fitting,
    asked: tuple[float, float],
    progress: Progress,
) -> Slopes:
    """Slopes at the n vertices; not determined where no crest is near.

    Parameters
    ----------
    axes, fitting:
        As for `fit_slopes`.
    asked:
        How far e must change over the radius of its fit, in its standard errors, all along a crest
        and somewhere on it.
    """
    weak, certain = asked
    fitted = np.zeros(len(surface.vertices), bool)
    slopes = unknown(len(fitted))

    def fit(rows: np.ndarray, part: Progress) -> None:
        put(fit_slopes(surface, axes, fitting, part, rows), rows, slopes)
        fitted[rows] = True

    # The radius is that of the fits, which a few of them tell.
    some = np.arange(0, len(fitted), max(len(fitted) // 64, 1))
    fit(some, progress.quiet())
    radius = float(np.median(slopes.radius[some]))
    cell = CELL * radius
    seeds = _spread(surface, axes[2], cell)
    fit(seeds[~fitted[seeds]], progress.part("Fitting third derivatives", 0.0, 0.3))
    seeds = np.flatnonzero(fitted)
    near = _near_crest(slopes, seeds, NEAR_CELLS * cell, SHARE * certain, SHARE)
    tree = cKDTree(surface.vertices)
    found = np.zeros(len(fitted), bool)
    for rows in np.array_split(seeds[near], max(int(near.sum()) // 64, 1)):
        for ball in tree.query_ball_point(surface.vertices[rows], AROUND * radius):
            found[ball] = True
    edge = surface.mean_side
    left = np.flatnonzero(found & ~fitted)
    part = progress.part("Fitting third derivatives", 0.3, 1.0)
    fit(left, part)
    # What is found may go on beyond: as many rounds as there are rings at most.
    new = np.flatnonzero(found)
    while len(new):
        progress.ask()
        on = new[_near_crest(slopes, new, NEAR_EDGES * edge, weak, 1.0)]
        around = _grown(surface, on, ONWARD)
        new = around[~fitted[around]]
        fit(new, progress.quiet())
    return slopes


def _near_crest(
    slopes: Slopes, rows: np.ndarray, reach: float, certain: float, share: float
) -> np.ndarray:
    """(r,) whether a crest passes within a reach of vertices (r,), by the slope of e there; its
    curvature is at least `share` of the other."""
    k, e, bending = slopes.k[:, rows], slopes.e[:, rows], slopes.bending[:, rows]
    outward = np.array([[1.0], [-1.0]])
    near = np.abs(e) <= reach * np.abs(bending)
    near &= np.abs(bending) * slopes.radius[rows] > certain * slopes.error[:, rows]
    near &= (k * outward > 0.0) & (bending * outward < 0.0) & (bend_of(k, bending) < ROUND)
    near &= np.abs(k) > share * np.abs(k[::-1])
    return np.asarray(near.any(axis=0) & slopes.determined[rows])


def _spread(surface: Surface, normal: np.ndarray, cell: float) -> np.ndarray:
    """One vertex of each cell of a grid, and of each side that the surface has there.

    Parameters
    ----------
    normal:
        (3, n) unit normals.
    """
    place = np.floor(surface.vertices / cell).astype(np.int64)
    place -= place.min(axis=0)
    count = place.max(axis=0) + 1
    number = (place[:, 0] * count[1] + place[:, 1]) * count[2] + place[:, 2]
    axis = np.abs(normal).argmax(axis=0)
    side = 2 * axis + (normal[axis, np.arange(len(axis))] > 0)
    return np.unique(6 * number + side, return_index=True)[1]


def _grown(surface: Surface, rows: np.ndarray, rings: int) -> np.ndarray:
    """Vertices within so many rings of others, those included."""
    start = surface.neighbour_start.astype(np.int64)
    reached = np.unique(rows)
    for _ in range(rings):
        ring = spans(start[reached], np.diff(start)[reached])
        reached = np.union1d(reached, surface.neighbours[ring])
    return reached
