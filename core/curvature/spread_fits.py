"""Jets at all vertices from fits at vertices spread among them.

What a fit tells varies slowly over its window, so that fits at every vertex of a dense mesh say
the same over and over. They are made at some vertices only, and what they say is blended in
between: a partition of unity of local polynomials (Shepard 1968; Ohtake et al. 2003, "Multi-level
partition of unity implicits", https://doi.org/10.1145/882262.882293).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from ..base.parallel import run
from ..base.progress import Progress
from ..mesh.neighbourhoods import WIDE, Neighbourhood
from ..mesh.patches import REACH, smoothed
from ..mesh.rings import spread
from ..mesh.surface import Surface
from .fits.height_fit import HeightFit
from .fits.implicit import (
    GRADIENT,
    HESSIAN,
    derivatives,
    expanded,
    moved,
    offset_powers,
    shape_operator,
)
from .fits.jets import DEGREE, Jets, fit_each, fit_jets
from .scale import Scale

# Rings up to which fits are taken one edge away at most: what is farther has little weight, 15 %
# together at three rings. Directions of the ellipsoid of docs/speed.md in single precision are so
# wrong by .0077 instead of .0070 degrees, those of five other surfaces (two of harmonics, a field,
# two of metaballs) by .0244, .0250, .0250, .0197, .0207 for .0266, .0299, .0250, .0183, .0205.
NARROW = 3
# Vertices below which all are fitted at: there is little time to save, and windows are wide beside
# the surface's own detail, so that blending costs more than it averages out (98 umbilics found for
# 107 on one set of noisy meshes of some thousand vertices, 132 for 129 on another).
FEWEST = 50_000
# Cosine between the normals of a fit and of a vertex below which it is not taken there.
ALIKE = 0.5
# Pairs of a vertex and a fit that are blended together.
BLOCK = 1 << 15
# Weight of a fit at the rim of its window over that in the middle, and the least error.
LEAST, TINY = 1e-6, 1e-100


# Columns of the table of fits: the derivatives of `implicit.derivatives`; noise, residual and
# radius as in `Jets`; the place.
LOW, THIRD, OWN, CENTRE = slice(0, 9), slice(9, 19), slice(19, 22), slice(22, 25)
COLUMNS = 25


@dataclass(frozen=True)
class Fits:
    """Fits at c vertices.

    Attributes
    ----------
    there:
        (c, 9) what pairs are weighed by, in rows, as to gather is most of the work: the place; the
        normal of the fit's plane, zero where the samples do not determine the fit; noise, residual
        and radius as in `Jets`.
    values:
        (c, k, m) arrays of what is added up: the two of `implicit.expanded` where fits are taken
        at the vertex itself, each for itself, else one of `COLUMNS`.
    """

    there: np.ndarray
    values: tuple[np.ndarray, ...]

    @property
    def each(self) -> bool:
        """Whether fits are taken at the vertex itself."""
        return len(self.values) > 1


def worth_spreading(scale: Scale) -> bool:
    """Whether fits at some vertices save time on this mesh, and lose nothing.

    Focused fits over two rings that follow errors of the points, as those of single precision on
    dense meshes, would follow them farther from their middles.
    """
    around = scale.neighbourhood
    return len(around.surface.vertices) >= FEWEST and (scale.clean or not around.focused)


def fit_spread(
    surface: Surface,
    normals: np.ndarray,
    neighbourhood: Neighbourhood,
    progress: Progress,
    tilted: bool = False,
) -> Jets:
    """Jets at all n vertices as from `fit_jets`, fitted at some of them.

    Clean meshes (`focused`) take every fit at the vertex itself, so that no less is known than
    the height functions say; others take the mean of the fits, moved to the vertex all
    together, in which their errors average out.

    Parameters
    ----------
    normals, neighbourhood:
        As for `fit_jets`.
    tilted:
        Whether errors of the points tilt the normals.
    """
    fitting = progress.part("Fitting jets", 0.0, 0.7)
    patches = neighbourhood.patches
    if patches is not None:
        over = patches.over
    else:
        rounds, edges = 1, 1 if neighbourhood.rings <= NARROW else 2
        if neighbourhood.rings >= WIDE:
            rounds, edges = 2, REACH
        over = spread(_open(neighbourhood), rounds, edges, progress.quiet())
    if tilted:
        normals = smoothed(surface, normals, over.near) if patches is None else patches.normals
    fits = _fits_at(surface, normals, neighbourhood, fitting, over.nodes)
    blending = progress.part("Fitting jets", 0.7, 1.0)
    jets = blended(surface.vertices, normals, fits, over.near, blending)
    alone = np.flatnonzero(~jets.determined)
    if len(alone):
        own = fit_jets(surface, normals, neighbourhood, progress.quiet(), alone)
        for name, values in vars(own).items():
            getattr(jets, name)[alone] = values
    return jets


def _open(neighbourhood: Neighbourhood) -> sparse.csr_array:
    """The one-ring graph without the edges at creases and at vertices in strips: these are fitted
    each for itself."""
    closed = neighbourhood.crease_vertices
    if neighbourhood.thinned is not None:
        crowded = neighbourhood.thinned.crowded
        closed = crowded if closed is None else crowded | closed
    if closed is None:
        return neighbourhood.graph
    free = sparse.diags_array(~closed, dtype=bool)
    graph = (free @ neighbourhood.graph @ free).tocsr()
    graph.eliminate_zeros()
    return graph


def _fits_at(
    surface: Surface,
    normals: np.ndarray,
    neighbourhood: Neighbourhood,
    progress: Progress,
    centres: np.ndarray,
) -> Fits:
    """The fits at vertices (c,)."""
    c = len(centres)
    shapes = [(4, 9), (6, 3)] if neighbourhood.focused else [(1, COLUMNS)]
    fits = Fits(np.empty((c, 9)), tuple(np.empty((c, *shape)) for shape in shapes))

    def store(fit: HeightFit, radius: np.ndarray, axes: np.ndarray, slots: np.ndarray) -> None:
        there, values = rows_of(fit, radius, axes, surface.vertices[centres[slots]])
        fits.there[slots] = there
        if fits.each:
            both = expanded(values[:, LOW], values[:, THIRD])
            fits.values[0][slots], fits.values[1][slots] = both
        else:
            fits.values[0][slots, 0] = values

    fit_each(surface, normals, neighbourhood, progress, centres, DEGREE, store)
    return fits


def rows_of(
    fit: HeightFit, radius: np.ndarray, axes: np.ndarray, place: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(b, 9) and (b, `COLUMNS`) the two tables of `Fits` of fits at places (b, 3)."""
    low, third = derivatives(fit.coefficients, radius, axes)
    own = np.stack([fit.gap_error / radius, fit.residual * radius, radius], axis=1)
    plane = np.where(fit.determined, axes[2], 0.0).T
    values = np.concatenate([low, third, own, place], axis=1)
    return np.concatenate([place, plane, own], axis=1), values


def blended(
    points: np.ndarray,
    normals: np.ndarray,
    fits: Fits,
    near: sparse.csr_array,
    progress: Progress,
) -> Jets:
    """Jets at n points, with their normals (n, 3), from the fits that are `near` (n, c); not
    determined without any."""
    return _Blend(points, normals, fits).all(near, progress)


class _Blend:
    """Fits at c of n vertices, blended at all.

    Parameters
    ----------
    points, normals:
        (n, 3) the vertices and their normals.
    fits:
        As from `_fits_at`.
    """

    def __init__(self, points: np.ndarray, normals: np.ndarray, fits: Fits) -> None:
        self.points, self.normals, self.fits = points, normals, fits

    def all(self, near: sparse.csr_array, progress: Progress) -> Jets:
        """Jets at n vertices from the fits that are `near` (n, c); not determined without any."""
        n = near.shape[0]
        jets = Jets.none(n)
        starts = near.indptr
        cuts = np.searchsorted(starts, np.arange(0, starts[-1] + BLOCK, BLOCK))
        cuts = np.unique(np.clip(cuts, 0, n))

        def block(part: int) -> None:
            low, high = cuts[part], cuts[part + 1]
            of = near.indices[starts[low] : starts[high]]
            self._at(np.arange(low, high), of, starts[low : high + 1] - starts[low], jets)

        run(block, range(len(cuts) - 1), progress)
        return jets

    def _at(self, rows: np.ndarray, of: np.ndarray, begin: np.ndarray, jets: Jets) -> None:
        """Blend the fits `of` (p,) at the vertices `rows` (r,), those of each from `begin` (r + 1,)
        on, into `jets`; without those that are not determined or of a surface that faces
        elsewhere."""
        count = np.diff(begin)
        at: np.ndarray | slice = slice(rows[0], rows[-1] + 1)
        here = np.concatenate([self.points[at], self.normals[at]], axis=1)
        here = _columns(np.repeat(here, count, axis=0))
        there = _columns(self.fits.there.take(of, axis=0, mode="clip"))
        alike = np.einsum("cp,cp->p", here[3:], there[3:6]) > ALIKE
        if not alike.all() or not count.all():
            begin = np.append(0, np.cumsum(alike))[begin]
            at, of = rows[np.diff(begin) > 0], of[alike]
            here, there = here[:, alike], there[:, alike]
            begin = np.append(0, begin[1:][np.diff(begin) > 0])
        if not len(of):
            return
        count = np.diff(begin)
        offset = here[:3] - there[:3]
        if self.fits.each:
            weight = np.repeat(1.0 / count, count)
            low, change = (
                _sums(weight * powers, of, begin, values)
                for powers, values in zip(offset_powers(offset), self.fits.values, strict=True)
            )
            gradient, hessian = low[GRADIENT] + change, low[HESSIAN]
            own = np.add.reduceat(weight * there[6:], begin[:-1], axis=1)
        else:
            noise, _, radius = there[6:]
            square = np.einsum("cp,cp->p", offset, offset) / (radius * radius)
            weight = (np.maximum(1.0 - square, 0.0) ** 2 + LEAST) / np.maximum(noise, TINY) ** 2
            weight /= np.repeat(np.add.reduceat(weight, begin[:-1]), count)
            mean = _sums(weight[None], of, begin, self.fits.values[0])
            # All fits are read as far from their middles as their mean is from the vertex.
            away = self.points[at].T - mean[CENTRE]
            gradient, hessian = moved(mean[LOW], mean[THIRD], away)
            own = mean[OWN]
        k1, k2, d1, d2, normal = shape_operator(gradient, hessian)
        jets.k1[at], jets.k2[at] = k1, k2
        jets.d1[at], jets.d2[at], jets.normal[at] = d1.T, d2.T, normal.T
        jets.noise[at], jets.residual[at], jets.radius[at] = own
        jets.determined[at] = True


def _columns(rows: np.ndarray) -> np.ndarray:
    """(k, p) of (p, k): NumPy calculates several times faster along the long side."""
    return np.ascontiguousarray(rows.T)


def _sums(weights: np.ndarray, of: np.ndarray, begin: np.ndarray, values: np.ndarray) -> np.ndarray:
    """(m, r) sums of values (c, k, m) with weights (k, p) over the rows `of` (p,) from each of
    `begin` (r + 1,) on."""
    c, k, m = values.shape
    columns = (of * np.int32(k) + np.arange(k, dtype=np.int32)[:, None]).T.ravel()
    shape = len(begin) - 1, c * k
    pairs = sparse.csr_array((weights.T.ravel(), columns, k * begin), shape=shape)
    return _columns(pairs @ values.reshape(c * k, m))
