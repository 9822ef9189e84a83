"""The place of an umbilic to less than an edge: a higher jet around it and Newton's method.

Linear interpolation inside a triangle carries the errors of three separate fits. One fit of
higher degree around the triangle gives the deviator as a smooth function; its zero is the place.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..base.parallel import run
from ..base.progress import Progress
from ..base.unit import unit
from ..curvature.estimate import Estimate
from ..curvature.fits.flattened import FlatFit, fit_flattened, round_operator
from ..fields.frames import frame
from ..mesh.neighbourhoods import Neighbourhood
from ..mesh.surface import Surface
from .fitted_zero import clear_of_zero, slope_change, slopes, zero
from .kind import from_gradient
from .kind import index as index_of

# Degree and rings beyond the jets' own. On clean meshes degree five over one more ring places
# the umbilics of random ellipsoids to 0.012 edges, degree four to 0.032; under noise degree four
# over two more rings does best (measured on the test surfaces).
CLEAN = (5, 1)
NOISY = (4, 2)
# Weights 1 / (1 + d^2 / FOCUS)^3 of the squared distance (mean 1) on clean meshes; wider than
# those of the jets, for the higher degree.
FOCUS = 1.0
# Samples for each coefficient, below which a fit swings between them.
SAMPLES_PER_TERM = 1.5
# The zero may leave the triangle that the winding names, but not its neighbourhood: beyond this
# many edges the fit has found another zero or none.
FARTHEST = 1.5
BLOCK = 4096
# Standard error of p and q over that of the deviator and the root mean square distance of the
# samples, by degree, for samples spread evenly over a disc.
SLOPE_ERROR = {3: 2.6, 4: 0.6, 5: 3.1}
# That is for independent residuals; those of clean meshes are smooth, and on coarse ones (640 and
# 1,500 vertices of the surfaces of benchmarks.people, seeds 0 to 2) it called nine right kinds
# uncertain for two wrong ones.
SMOOTH_ERROR = 0.6
# Triangles that the walk to the refined place may cross before it is given up.
WALK = 16
# Among long thin triangles there are as many more in the way.
THIN_WALK = 64


@dataclass(frozen=True)
class Refined:
    """Refined umbilics of a `Surface`, in its own coordinates, one row each.

    Attributes
    ----------
    triangle, barycentric:
        (k,) int64 and (k, 3) float64 place on the surface.
    normal:
        (k, 3) float64 unit normal of the fit there.
    curvature:
        (k,) float64 mean curvature there.
    p, q:
        (k,) complex128 linear form of the deviator in the frame x, y.
    x, y:
        (k, 3) float64 orthonormal tangents.
    error:
        (k,) float64 standard error that the residuals of the fit leave in the deviator.
    slope_error:
        (k,) float64 standard error of p and of q.
    clarity:
        (k,) float64 how far the deviator rises above its error on a circle around the place on
        which it turns by the index: the least |D| on the best such circle, in standard errors.
    found:
        (k,) bool, False where Newton's method did not settle nearby; such rows keep the
        triangle and weights they came with, and nothing else in them is meant.
    """

    triangle: np.ndarray
    barycentric: np.ndarray
    normal: np.ndarray
    curvature: np.ndarray
    p: np.ndarray
    q: np.ndarray
    x: np.ndarray
    y: np.ndarray
    error: np.ndarray
    slope_error: np.ndarray
    clarity: np.ndarray
    found: np.ndarray

    def agrees(self, index: np.ndarray) -> np.ndarray:
        """(k,) bool, places where the fit turns as the winding (k,) does that they were refined
        for: what contradicts it is another zero."""
        return self.found & (index_of(self.p, self.q) == np.sign(index) / 2)


def refine(
    surface: Surface,
    triangle: np.ndarray,
    barycentric: np.ndarray,
    fitted: Estimate,
    progress: Progress,
) -> Refined:
    """Refine umbilics in the triangles (k,) from their weights (k, 3).

    Parameters
    ----------
    surface:
        The surface; n vertices.
    fitted:
        The jets, whose neighbourhoods around the corners of each triangle are fitted.
    """
    k = len(triangle)
    places = Refined(
        triangle=triangle.copy(),
        barycentric=barycentric.copy(),
        normal=np.zeros((k, 3)),
        curvature=np.zeros(k),
        p=np.zeros(k, np.complex128),
        q=np.zeros(k, np.complex128),
        x=np.zeros((k, 3)),
        y=np.zeros((k, 3)),
        error=np.full(k, np.nan),
        slope_error=np.full(k, np.nan),
        clarity=np.zeros(k),
        found=np.zeros(k, bool),
    )
    if fitted.neighbourhood is None:  # nothing was fitted
        return places
    normals = fitted.field.normal
    neighbourhood, windows = _windows(surface, triangle, fitted)
    factor = 1.0 if fitted.closer is None else fitted.closer.factor
    focused = neighbourhood.focused
    ask = progress.quiet()
    walk = WALK if neighbourhood.thinned is None else THIN_WALK

    def block(first: int) -> None:
        rows = np.arange(first, min(first + BLOCK, k))
        for window in np.unique(windows[:, rows], axis=1).T:
            same = rows[(window == windows[:, rows].T).all(axis=1)]
            corners = surface.triangles[triangle[same]]
            so_many, degree = map(int, window)
            # Each has samples of its own number, and all are looked for at once.
            fits: dict[int, list[_Fit]] = {}
            around = neighbourhood.around_triangles(corners, so_many, 1 << 15, ask)
            for some, members, held in around:
                ask.ask()
                samples = members, held
                for fit in _fitted(surface, normals, same[some], samples, degree, focused, places):
                    fits.setdefault(fit.degree, []).append(fit)
            for own, found in fits.items():
                exact = focused and own == CLEAN[0]
                _look_for_zeros(surface, _Fit.joined(found), exact, factor, walk, places)

    run(block, range(0, k, BLOCK), progress)
    return places


def _windows(
    surface: Surface, triangle: np.ndarray, fitted: Estimate
) -> tuple[Neighbourhood, np.ndarray]:
    """What is fitted around triangles (k,), and (2, k) the rings and degree of each fit: where
    windows differ from place to place the narrowest at the corners, or the rings of cubics and as
    many more as the degree asks for."""
    around, closer = fitted.neighbourhood, fitted.closer
    assert around is not None
    k = len(triangle)
    if closer is None:
        degree, more_rings = CLEAN if around.focused else NOISY
        return around, np.tile([[around.rings + more_rings], [degree]], k)
    around = closer.neighbourhood
    if fitted.rings is None or fitted.degrees is None:
        return around, np.tile([[around.rings], [fitted.degree]], k)
    corners = surface.triangles[triangle]
    rings = np.where(fitted.rings > 0, fitted.rings, np.iinfo(np.int64).max)[corners]
    narrowest = corners[np.arange(k), rings.argmin(axis=1)]
    known = np.stack([fitted.rings[narrowest], fitted.degrees[narrowest]])
    others = np.array([[around.rings + NOISY[1]], [NOISY[0]]])
    return around, np.where(known[0] > 0, known, others)


@dataclass(frozen=True)
class _Fit:
    """Fits around umbilics, the `rows` (r,) of all: places (r, 3) in the middle of them, axes
    (3, 3, r) there, how many samples each has (r,), and what was fitted to these."""

    rows: np.ndarray
    centre: np.ndarray
    axes: np.ndarray
    samples: np.ndarray
    flat: FlatFit
    degree: int

    @classmethod
    def joined(cls, fits: list[_Fit]) -> _Fit:
        """All of one degree as one."""
        return cls(
            np.concatenate([fit.rows for fit in fits]),
            np.concatenate([fit.centre for fit in fits]),
            np.concatenate([fit.axes for fit in fits], axis=2),
            np.concatenate([fit.samples for fit in fits]),
            FlatFit.joined([fit.flat for fit in fits]),
            fits[0].degree,
        )


def _fitted(
    surface: Surface,
    normals: np.ndarray,
    rows: np.ndarray,
    samples: tuple[np.ndarray, np.ndarray],
    degree: int,
    focused: bool,
    places: Refined,
) -> Iterator[_Fit]:
    """Fits of a degree, or of what they can hold, to `samples`, (s, r) members of which the (r,)
    first are meant, around the umbilics `rows`."""
    members, held = samples
    centre, axes, (x, y, z) = _seen_from(
        surface, normals, places.triangle[rows], places.barycentric[rows], members
    )
    # Where a small piece or a border leaves few samples, the degree that they can hold.
    degrees = np.full(len(rows), degree)
    for high in range(degree, 3, -1):
        degrees[held < SAMPLES_PER_TERM * (high + 1) * (high + 2) / 2] = high - 1
    for own in np.unique(degrees).tolist():
        some = np.flatnonzero(degrees == own)
        focus = FOCUS if focused and own == CLEAN[0] else None
        columns = x[:, some], y[:, some], z[:, some]
        (flat,) = fit_flattened(*columns, [own], focus, held=held[some])
        yield _Fit(rows[some], centre[some], axes[:, :, some], held[some], flat, own)


def _seen_from(
    surface: Surface,
    normals: np.ndarray,
    triangle: np.ndarray,
    weights: np.ndarray,
    members: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Places (r, 3) by triangles (r,) and weights (r, 3), axes (3, 3, r) there, the normal last,
    and samples (s, r) along them: (3, s, r)."""
    corners = surface.triangles[triangle]
    centre = np.einsum("rk,rkc->rc", weights, surface.vertices[corners])
    normal = np.einsum("rk,rkc->rc", weights, normals[corners])
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    normal = np.where(length > 1e-3, unit(normal), normals[corners[:, 0]])
    axes = np.stack([*frame(normal.T), normal.T])
    offset = surface.vertices[members] - centre
    return centre, axes, np.stack([np.einsum("sbc,cb->sb", offset, axis) for axis in axes])


@dataclass(frozen=True)
class NextOrder:
    """What fits of two degrees more, to the same samples, change at k places; all NaN where these
    are too few for them.

    Attributes
    ----------
    change:
        (k,) length of the change of the deviator.
    variance, larger:
        (k,) squared standard errors that the residuals leave in both, if each point errs by itself.
    terms, explained:
        (k,) how many terms were added, and how much each takes from the squares of the residuals on
        average, over what one does where there is nothing but noise.
    """

    change: np.ndarray
    variance: np.ndarray
    larger: np.ndarray
    terms: np.ndarray
    explained: np.ndarray


def next_order(
    surface: Surface,
    triangle: np.ndarray,
    barycentric: np.ndarray,
    fitted: Estimate,
    progress: Progress,
) -> NextOrder:
    """What terms of the next order change at places by triangles (k,) and weights (k, 3), in the
    fits that `refine` makes there.

    A deviator is made of second derivatives, to which by symmetry the terms of the next even
    degree add the most.
    """
    found = NextOrder(*np.full((5, len(triangle)), np.nan))
    around, windows = _windows(surface, triangle, fitted)
    normals = fitted.field.normal
    for rings, degree in np.unique(windows, axis=1).T.tolist():
        same = np.flatnonzero((windows == [[rings], [degree]]).all(axis=0))
        corners = surface.triangles[triangle[same]]
        both = degree, degree + 2
        few, many = ((d + 1) * (d + 2) / 2 for d in both)
        for some, members, held in around.around_triangles(corners, rings, 1 << 15, progress):
            enough = held >= SAMPLES_PER_TERM * many
            if not enough.any():
                continue
            rows, members, held = same[some][enough], members[:, enough], held[enough]
            _, _, (x, y, z) = _seen_from(
                surface, normals, triangle[rows], barycentric[rows], members
            )
            one, two = fit_flattened(x, y, z, both, held=held)
            middle = np.zeros(len(rows))
            lower, higher = (
                round_operator(flat.heights.coefficients, flat.radius, flat.bend, middle, middle)
                for flat in (one, two)
            )
            known = one.heights.determined & two.heights.determined & (two.residual > 0.0)
            left, noise = np.square(one.residual), np.where(known, np.square(two.residual), 1.0)
            taken = left / noise * (held - few) - (held - many)
            values = (
                np.abs(higher.deviator - lower.deviator),
                np.square(one.heights.gap_error / one.radius),
                np.square(two.heights.gap_error / two.radius),
                np.full(len(rows), many - few),
                np.maximum(taken / (many - few), 0.0),
            )
            for kept, value in zip(vars(found).values(), values, strict=True):
                kept[rows[known]] = value[known]
    return found


def _look_for_zeros(
    surface: Surface, found: _Fit, focused: bool, factor: float, walk: int, places: Refined
) -> None:
    """Refine the places that fits were made around to where these have their zeros."""
    rows, axes, flat, degree = found.rows, found.axes, found.flat, found.degree
    fit, radius = flat.heights, flat.radius
    edge = surface.mean_sides(places.triangle[rows])
    # Edges of the triangle itself or, where that is a small one, of as many vertices spread
    # evenly over the disc of the samples.
    spread = np.sqrt(4 * np.pi / (np.sqrt(3) * found.samples))
    u, v, settled = zero(fit, FARTHEST * np.maximum(edge / radius, spread))
    operator = round_operator(fit.coefficients, radius, flat.bend, u, v)
    along_u, along_v = slopes(fit, u, v)
    # From the parameters u, v to lengths along the tangents x, y of the fitted surface.
    a, b, d = operator.root
    p, q = from_gradient(a * along_u + b * along_v, b * along_u + d * along_v)
    # Lengths of the surface are `unit` times those of the fit.
    unit = radius / operator.scale

    target = operator.place[:2].T
    start = places.triangle[rows]
    e1, e2, _ = np.ascontiguousarray(axes.transpose(0, 2, 1))
    around, inside, landed = _landing(surface, start, target, found.centre, e1, e2, walk)
    kept = settled & fit.determined & landed
    chosen = rows[kept]
    places.triangle[chosen], places.barycentric[chosen] = around[kept], inside[kept]
    places.normal[chosen] = operator.normal(axes)[kept]
    places.x[chosen] = operator.tangent(1.0, 0.0, axes)[kept]
    places.y[chosen] = operator.tangent(0.0, 1.0, axes)[kept]
    places.curvature[chosen] = operator.mean[kept]
    places.p[chosen], places.q[chosen] = (p / unit**2)[kept], (q / unit**2)[kept]
    places.error[chosen] = (factor * fit.gap_error / unit)[kept]
    error = np.maximum(factor * fit.gap_error, np.finfo(float).tiny)
    slope_error = (SMOOTH_ERROR if focused else SLOPE_ERROR[degree]) * error
    if not focused:
        # On clean meshes the error is bias, which moves the place and the form read there alike.
        slope_error = np.hypot(slope_error, slope_change(fit, u, v, error))
    places.slope_error[chosen] = (slope_error / unit**2)[kept]
    places.clarity[chosen] = (clear_of_zero(fit, u, v, p, q) / error)[kept]
    places.found[chosen] = True


def _landing(
    surface: Surface,
    triangle: np.ndarray,
    target: np.ndarray,
    centre: np.ndarray,
    e1: np.ndarray,
    e2: np.ndarray,
    walk: int,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Walk from each triangle to the one over the point `target` (r, 2) of the plane e1, e2.

    Returns the triangles (r,), weights (r, 3) and whether the walk arrived (a border, or a
    fold in the surface, can end it).
    """
    triangle = triangle.copy()
    for _ in range(walk):
        offset = surface.vertices[surface.triangles[triangle]] - centre[:, None]
        plane = np.stack(
            [np.einsum("rkc,rc->rk", offset, e1), np.einsum("rkc,rc->rk", offset, e2)], axis=2
        )
        plane -= target[:, None]
        after, before = np.roll(plane, -1, axis=1), np.roll(plane, -2, axis=1)
        area = after[..., 0] * before[..., 1] - after[..., 1] * before[..., 0]
        total = area.sum(axis=1)
        weights = area / np.where(total > 0, total, np.inf)[:, None]
        worst = weights.argmin(axis=1)
        outside = (weights.min(axis=1) < 0) & (total > 0)
        twin = surface.twin[3 * triangle + (worst + 1) % 3]
        move = outside & (twin >= 0)
        if not move.any():
            break
        triangle[move] = twin[move] // 3
    return triangle, weights, (weights >= 0).all(axis=1) & (total > 0)
