"""Weighted least squares of height functions, many small fits at a time.

A block of b fits with s samples each is held as (s, b) arrays, one per coordinate, so that
every operation runs along b. The normal equations are assembled from the moments of the
samples and eliminated in place, all fits together (Cazals & Pouget 2005 fit the same jets by
one SVD each; the scaled coordinates keep the normal equations well conditioned here).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np

from ...base.buffers import Workspace

# A pivot this far below its diagonal entry means that the samples do not determine the term:
# the moments carry about 1e-16 of relative error, so smaller ones are round-off.
RANK_TOLERANCE = 1e-11
# The last terms to be eliminated: their Schur complement is the inverse of their covariance.
Terms = tuple[tuple[int, int], ...]
QUADRATIC: Terms = ((2, 0), (1, 1), (0, 2))


@dataclass(frozen=True)
class HeightFit:
    """Polynomial heights z(x, y) = sum c_ab x^a y^b over b fits.

    Attributes
    ----------
    coefficients:
        {(a, b): (b,) float64} for a + b <= degree, in the units of the samples.
    residual:
        (b,) float64 weighted standard deviation of the residuals, same unit as z.
    covariance:
        (3, 3, b) float64 covariance that the residual leaves in the three terms named last.
    determined:
        (b,) bool, False where the samples do not determine every coefficient.
    """

    coefficients: dict[tuple[int, int], np.ndarray]
    residual: np.ndarray
    covariance: np.ndarray
    determined: np.ndarray

    @property
    def gap_error(self) -> np.ndarray:
        """(b,) root mean square error of the deviator 2 (c20 - c02) + 2i c11, of fits whose last
        terms are the quadratic ones."""
        c = self.covariance
        return 2 * np.sqrt(np.maximum(c[0, 0] + c[2, 2] - 2 * c[0, 2] + c[1, 1], 0))


@cache
def _monomials(degree: int) -> list[tuple[int, int]]:
    """Exponents (a, b) of x^a y^b, degree after degree."""
    return [(total - b, b) for total in range(degree + 1) for b in range(total + 1)]


def _terms(degree: int, last: Terms) -> list[tuple[int, int]]:
    """Exponents with the three terms `last` at the end."""
    return [term for term in _monomials(degree) if term not in last] + list(last)


def heights_at(
    coefficients: Mapping[tuple[int, int], np.ndarray], x: np.ndarray, y: np.ndarray
) -> np.ndarray:
    """(..., b) the polynomials sum c_ab x^a y^b of (b,) coefficients at places (..., b)."""
    heights = np.zeros(np.broadcast_shapes(np.shape(x), np.shape(y)))
    powers = [powers_to(max(ab[k] for ab in coefficients), (x, y)[k]) for k in range(2)]
    for (a, b), value in coefficients.items():
        heights += value * powers[0][a] * powers[1][b]
    return heights


def powers_to(most: int, x: np.ndarray) -> list[np.ndarray]:
    """Powers of x from 0 on, several times faster than one by one."""
    powers = [np.ones(np.shape(x))]
    for _ in range(most):
        powers.append(powers[-1] * x)
    return powers


def sum_count(degree: int) -> int:
    """Rows of the sums that a fit of this degree needs, see `sum_samples`."""
    return len(_monomials(2 * degree)) + len(_monomials(degree)) + 1


def _moments(degree: int) -> list[tuple[int, int]]:
    """Exponents (a, b) of the sums of x^a y^b in the order of `sum_samples`: all by 1, the highest
    by powers of x, the rest by y^degree."""
    low, steps = _monomials(degree), range(1, degree + 1)
    moments = low + [(degree + k - b, b) for k in steps for b in range(degree)]
    return moments + [(a, degree + b) for a, b in low[1:]]


@cache
def sum_degrees(degree: int) -> np.ndarray:
    """(r,) the power of the unit of length that each of the sums grows with, see `sum_samples`."""
    lifted = [(a, b + 1) for a, b in _monomials(degree)]
    return np.array([a + b for a, b in _moments(degree) + lifted] + [2])


def lower_sums(sums: np.ndarray, degree: int, lower: int) -> np.ndarray:
    """The sums (r, b) of a lower degree of those of a degree, see `sum_samples`."""
    return sums[_lower_rows(degree, lower)]


@cache
def _lower_rows(degree: int, lower: int) -> np.ndarray:
    lifted = len(_moments(degree))
    row = {exponents: number for number, exponents in enumerate(_moments(degree))}
    moments = [row[exponents] for exponents in _moments(lower)]
    # Heights times x^a y^b are in the order of the degrees, their squares last.
    heights = list(range(lifted, lifted + len(_monomials(lower))))
    return np.array([*moments, *heights, sum_count(degree) - 1])


@cache
def _system_rows(degree: int, last: Terms) -> np.ndarray:
    """(t, t + 1) rows of the sums that make up the normal equations of the t terms."""
    low, moments = _monomials(degree), _moments(degree)
    moment = {exponents: row for row, exponents in enumerate(moments)}
    lifted = {exponents: row for row, exponents in enumerate(low, len(moments))}
    terms = _terms(degree, last)
    return np.array(
        [[moment[a + c, b + d] for c, d in terms] + [lifted[a, b]] for a, b in terms], np.int32
    )


def sum_samples(
    x: np.ndarray,
    y: np.ndarray,
    z: np.ndarray,
    weights: np.ndarray | None,
    degree: int,
    sums: np.ndarray,
    workspace: Workspace,
    held: np.ndarray | None = None,
) -> None:
    """What fits of a degree need to know of their samples.

    Parameters
    ----------
    x, y, z:
        (s, b) float64 samples; x and y should be of order 1.
    weights:
        (s, b) float64 weight of each sample, or None for equal ones.
    degree:
        Degree of the polynomial, at least 2.
    sums:
        (r, b) float64 takes the weighted sums of x^a y^b for a + b <= 2 degree, of z x^a y^b
        for a + b <= degree, and of z^2, in the order of `_system_rows`. r is `sum_count`.
    workspace:
        Buffers to work in, for calls in a loop.
    held:
        (b,) how many samples of equal weights there are, where others at the origin fill them up;
        None for all.
    """
    monomials = workspace.array("monomials", len(_monomials(degree)), *x.shape)
    monomials[0] = 1.0
    pure, end = [], 1  # rows of the powers of x
    for total in range(1, degree + 1):
        pure.append(end)
        np.multiply(monomials[end - total : end], x, out=monomials[end : end + total])
        np.multiply(monomials[end - 1], y, out=monomials[end + total])
        end += total + 1
    highest = monomials[-degree - 1 :]
    # Few products with many sums each: threads meet at the interpreter lock between calls.
    products = [(monomials[0], monomials)]
    products += [(monomials[row], highest[:-1]) for row in pure]
    products += [(highest[-1], monomials[1:]), (z, monomials)]
    begin = 0
    for left, right in products:
        if weights is not None:
            left = np.multiply(weights, left, out=workspace.array("left", *x.shape))
        np.einsum("sb,qsb->qb", left, right, out=sums[begin : begin + len(right)])
        begin += len(right)
    np.einsum("sb,sb->b", left, z, out=sums[begin])
    if held is not None and weights is None:
        # What lies at the origin counts nowhere else.
        sums[0] = held


def solve_heights(
    sums: np.ndarray,
    samples: np.ndarray,
    degree: int,
    workspace: Workspace,
    last: Terms = QUADRATIC,
) -> HeightFit:
    """The fits of a degree from `sums` (r, b) over their `samples` (b,), see `sum_samples`, and
    the covariance of the three terms `last`."""
    terms = _terms(degree, last)
    size, first = len(terms), len(terms) - 3
    diagonal = np.arange(size)
    with np.errstate(all="ignore"):  # undetermined columns may overflow; they are zeroed below
        system, pivots, floor = _eliminated(sums, degree, last, workspace)
        covariance, determined = _inverse_of_last(system[first:, first:size], floor[first:])
        determined &= (system[diagonal[:first], diagonal[:first]] > floor[:first]).all(axis=0)
        determined &= samples >= size
        solution = np.empty((size, sums.shape[1]))
        right = system[:, size]
        np.einsum("ijb,jb->ib", covariance, right[first:], out=solution[first:])
        explained = np.einsum("ib,ib->b", right[first:], solution[first:])
        explained += np.einsum("ib,ib,ib->b", right[:first], right[:first], 1.0 / pivots)
        for row in range(first - 1, -1, -1):
            known = np.einsum("jb,jb->b", system[row, row + 1 : size], solution[row + 1 :])
            np.divide(right[row] - known, pivots[row], out=solution[row])

        # Round-off leaves about 1e-16 of the squared heights; below that nothing is known.
        total, square = sums[0], sums[-1]
        freedom = np.maximum(samples - size, 1) / samples
        variance = np.maximum(square - explained, 1e-16 * square) / (total * freedom)
        covariance *= variance * total / samples
    if not determined.all():
        for values in (solution, variance, covariance):
            values[..., ~determined] = 0.0
    return HeightFit(
        {term: solution[row] for row, term in enumerate(terms)},
        np.sqrt(variance),
        covariance,
        determined,
    )


def _eliminated(
    sums: np.ndarray, degree: int, last: Terms, workspace: Workspace
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Normal equations of t terms with all but the last three unknowns eliminated.

    Returns
    -------
    system:
        (t, t + 1, b), the result in the upper triangles.
    pivots:
        (t - 3, b), at least the floor: weak ones must not divide by zero.
    floor:
        (t, b) what a pivot must exceed.
    """
    rows = _system_rows(degree, last)
    size, first, fits = len(rows), len(rows) - 3, sums.shape[1]
    system = workspace.array("system", size, size + 1, fits)
    pivots, floor = np.empty((first, fits)), np.empty((size, fits))
    # Row by row, each with all rows above it in one call: fewer passes than pivot by pivot.
    for row, above in enumerate(min(row, first) for row in range(size)):
        upper, factor = system[row, row:], system[row, :above]
        np.take(sums, rows[row, row:], axis=0, out=upper, mode="clip")
        np.maximum(RANK_TOLERANCE * upper[0], np.finfo(float).tiny, out=floor[row])
        np.divide(system[:above, row], pivots[:above], out=factor)
        change = workspace.array("change", len(upper), fits)
        upper -= np.einsum("rb,rqb->qb", factor, system[:above, row:], out=change)
        if row < first:
            np.maximum(upper[0], floor[row], out=pivots[row])
    return system, pivots, floor


def _inverse_of_last(q: np.ndarray, floor: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Inverse (3, 3, b) of the Schur complements q (3, 3, b) of the three last terms, and
    (b,) whether they have one; only the upper triangles are read."""
    cofactor = {
        (0, 0): q[1, 1] * q[2, 2] - q[1, 2] ** 2,
        (0, 1): q[0, 2] * q[1, 2] - q[0, 1] * q[2, 2],
        (0, 2): q[0, 1] * q[1, 2] - q[0, 2] * q[1, 1],
        (1, 1): q[0, 0] * q[2, 2] - q[0, 2] ** 2,
        (1, 2): q[0, 1] * q[0, 2] - q[0, 0] * q[1, 2],
        (2, 2): q[0, 0] * q[1, 1] - q[0, 1] ** 2,
    }
    determinant = q[0, 0] * cofactor[0, 0] + q[0, 1] * cofactor[0, 1] + q[0, 2] * cofactor[0, 2]
    regular = determinant > floor[0] * floor[1] * floor[2]
    for k in range(3):
        regular &= q[k, k] > floor[k]
    inverse = np.empty(q.shape)
    for (i, j), value in cofactor.items():
        np.divide(value, determinant, out=inverse[i, j])
        inverse[j, i] = inverse[i, j]
    return inverse, regular
