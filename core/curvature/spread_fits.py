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
from ..base.unit import phase
from ..fields.frames import frame, principal_directions
from ..mesh.neighbourhoods import Neighbourhood
from ..mesh.rings import spread
from ..mesh.surface import Surface
from .fits.height_fit import HeightFit
from .fits.jets import DEGREE, Jets, fit_each, fit_jets
from .fits.monge import operator_at
from .scale import Scale

# Rings from which on fits at a twelfth of the vertices suffice instead of at a quarter: on noisy
# ellipsoids both leave less error than fits at all vertices do.
WIDE = 6
# Rounds of spreading, and how far fits reach whose mean is taken.
MEAN, WIDE_MEAN = (1, 2), (2, 3)
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


@dataclass(frozen=True)
class _Fits:
    """Height functions at c vertices.

    Attributes
    ----------
    centre:
        (c,) vertices.
    coefficients:
        (10, c) in the units of the radius, in the order of `terms`.
    terms:
        Exponents of the coefficients.
    axes:
        (3, 3, c) axes of the plane, and its normal.
    radius, noise, residual:
        (c,) as in `Jets`.
    """

    centre: np.ndarray
    coefficients: np.ndarray
    terms: list[tuple[int, int]]
    axes: np.ndarray
    radius: np.ndarray
    noise: np.ndarray
    residual: np.ndarray


def worth_spreading(scale: Scale) -> bool:
    """Whether fits at some vertices save time on this mesh, and lose nothing.

    Focused fits over two rings that follow errors of the points, as those of single precision on
    dense meshes, would follow them farther from their middles.
    """
    around = scale.neighbourhood
    return len(around.surface.vertices) >= FEWEST and (scale.clean or not around.focused)


def fit_spread(
    surface: Surface, normals: np.ndarray, neighbourhood: Neighbourhood, progress: Progress
) -> Jets:
    """Jets at all n vertices as from `fit_jets`, fitted at some of them.

    Clean meshes (`focused`) take every fit at the vertex itself, so that no less is known than
    the height functions say; others take the mean of the fits, moved to the vertex all
    together, in which their errors average out.

    Parameters
    ----------
    normals, neighbourhood:
        As for `fit_jets`.
    """
    fitting = progress.part("Fitting jets", 0.0, 0.7)
    graph = _open(neighbourhood)
    rounds, edges = (1, 1) if neighbourhood.focused else MEAN
    if neighbourhood.rings >= WIDE:
        rounds, edges = WIDE_MEAN
    centres, near = spread(graph, rounds, edges, progress.quiet())
    fits, determined = _fits_at(surface, normals, neighbourhood, fitting, centres)
    near = _known(normals, fits, near, determined)
    blending = progress.part("Fitting jets", 0.7, 1.0)
    jets = _blended(surface, fits, near, neighbourhood.focused, blending)
    alone = np.flatnonzero(np.diff(near.indptr) == 0)
    if len(alone):
        own = fit_jets(surface, normals, neighbourhood, progress.quiet(), alone)
        for name, values in vars(own).items():
            getattr(jets, name)[alone] = values
    return jets


def _open(neighbourhood: Neighbourhood) -> sparse.csr_array:
    """The one-ring graph without the edges at walls and at vertices in strips: these are fitted
    each for itself."""
    closed = neighbourhood.crease_vertices
    if neighbourhood.thinned is not None:
        crowded = neighbourhood.thinned.crowded
        closed = crowded if closed is None else crowded | closed
    if closed is None:
        return neighbourhood.graph
    free = sparse.diags_array((~closed).astype(np.int32), dtype=np.int32)
    graph = (free @ neighbourhood.graph @ free).tocsr()
    graph.eliminate_zeros()
    return graph


def _fits_at(
    surface: Surface,
    normals: np.ndarray,
    neighbourhood: Neighbourhood,
    progress: Progress,
    centres: np.ndarray,
) -> tuple[_Fits, np.ndarray]:
    """The fits at vertices (c,), and (c,) whether their samples determine them."""
    c = len(centres)
    terms = [(total - b, b) for total in range(DEGREE + 1) for b in range(total + 1)]
    fits = _Fits(
        centres,
        np.empty((len(terms), c)),
        terms,
        np.empty((3, 3, c)),
        *np.empty((3, c)),
    )
    determined = np.zeros(c, bool)

    def store(fit: HeightFit, radius: np.ndarray, axes: np.ndarray, slots: np.ndarray) -> None:
        for term, values in zip(terms, fits.coefficients, strict=True):
            values[slots] = fit.coefficients[term]
        fits.axes[:, :, slots] = axes
        fits.radius[slots] = radius
        fits.noise[slots] = fit.gap_error / radius
        fits.residual[slots] = fit.residual * radius
        determined[slots] = fit.determined

    fit_each(surface, normals, neighbourhood, progress, centres, DEGREE, store)
    return fits, determined


def _known(
    normals: np.ndarray,
    fits: _Fits,
    near: sparse.csr_array,
    determined: np.ndarray,
) -> sparse.csr_array:
    """`near` (n, c) without fits that are not determined or of a surface that faces elsewhere."""
    row = np.repeat(np.arange(near.shape[0]), np.diff(near.indptr))
    cosine = np.zeros(len(row))
    for axis, normal in zip(fits.axes[2], normals.T, strict=True):
        cosine += axis[near.indices] * normal[row]
    keep = determined[near.indices] & (cosine > ALIKE)
    if keep.all():
        return near
    start = np.append(0, np.cumsum(keep))[near.indptr]
    ones = np.ones(int(start[-1]), np.int32)
    return sparse.csr_array((ones, near.indices[keep], start), shape=near.shape)


def _blended(
    surface: Surface, fits: _Fits, near: sparse.csr_array, focused: bool, progress: Progress
) -> Jets:
    """Jets at n vertices from the fits that are `near` (n, c); not determined without any."""
    n = near.shape[0]
    jets = Jets(
        k1=np.zeros(n),
        k2=np.zeros(n),
        d1=np.zeros((n, 3)),
        d2=np.zeros((n, 3)),
        normal=np.zeros((n, 3)),
        noise=np.zeros(n),
        residual=np.zeros(n),
        radius=np.zeros(n),
        determined=np.diff(near.indptr) > 0,
    )
    rows = np.flatnonzero(jets.determined)
    starts = np.append(near.indptr[rows], near.indptr[-1])
    coordinates = np.ascontiguousarray(surface.vertices.T)
    cuts = np.searchsorted(starts, np.arange(0, starts[-1] + BLOCK, BLOCK))
    cuts = np.unique(np.clip(cuts, 0, len(rows)))

    def block(part: int) -> None:
        low, high = cuts[part], cuts[part + 1]
        first = starts[low]
        of = near.indices[first : starts[high]].astype(np.intp)
        begin = (starts[low:high] - first).astype(np.intp)
        _blend(coordinates, fits, rows[low:high], of, begin, focused, jets)

    run(block, range(len(cuts) - 1), progress)
    return jets


def _blend(
    coordinates: np.ndarray,
    fits: _Fits,
    rows: np.ndarray,
    of: np.ndarray,
    begin: np.ndarray,
    focused: bool,
    jets: Jets,
) -> None:
    """Blend pairs of the vertices `rows` (r,), each from `begin` (r,) on, with the fits `of`
    (p,) into `jets`."""
    count = np.diff(begin, append=len(of))

    def per_pair(values: np.ndarray) -> np.ndarray:
        return np.asarray(np.repeat(values, count, axis=-1))

    def summed(values: np.ndarray) -> np.ndarray:
        return np.asarray(np.add.reduceat(values, begin, axis=-1))

    unit = fits.radius.take(of)
    offset = per_pair(coordinates.take(rows, axis=1)) - coordinates.take(fits.centre.take(of), 1)
    if focused:
        weight = per_pair(1.0 / count)
    else:
        square = np.einsum("cp,cp->p", offset, offset) / (unit * unit)
        error = fits.noise.take(of)
        weight = (np.maximum(1.0 - square, 0.0) ** 2 + LEAST) / np.maximum(error, TINY) ** 2
        weight /= per_pair(summed(weight))
        # All fits are read as far from their middles as their mean is from the vertex.
        offset = per_pair(summed(weight * offset))
    axes = fits.axes.take(of, axis=2)
    x, y = np.einsum("cp,kcp->kp", offset, axes[:2]) / unit
    coefficients = dict(zip(fits.terms, fits.coefficients.take(of, axis=1), strict=True))
    operator = operator_at(coefficients, x, y)
    first, second = operator.tangent(1.0, 0.0, axes).T, operator.tangent(0.0, 1.0, axes).T
    normal = summed(weight * operator.normal(axes).T)
    normal /= np.sqrt(np.einsum("cr,cr->r", normal, normal))
    e1, e2 = frame(normal)
    # The frame of a fit, carried to the mean normal by the smallest rotation.
    turn = phase(np.einsum("cp,cp->p", first - 1j * second, per_pair(e1) + 1j * per_pair(e2)))
    scale = weight / unit
    mean = summed(scale * operator.mean)
    deviator = summed(scale * (operator.real + 1j * operator.imaginary) * turn**2)
    gap = np.abs(deviator)
    cosine, sine = principal_directions(deviator.real, deviator.imag, gap)
    jets.k1[rows], jets.k2[rows] = mean + 0.5 * gap, mean - 0.5 * gap
    jets.d1[rows] = (cosine * e1 + sine * e2).T
    jets.d2[rows] = (cosine * e2 - sine * e1).T
    jets.normal[rows] = normal.T
    for values, own in ((jets.noise, fits.noise), (jets.residual, fits.residual)):
        values[rows] = summed(weight * own.take(of))
    jets.radius[rows] = summed(weight * unit)
