"""Weighted least squares of height functions, many small fits at a time.

A block of b fits with s samples each is held as (s, b) arrays, one per coordinate, so that
every operation runs along b. The normal equations are assembled from the moments of the
samples and eliminated in place, all fits together (Cazals & Pouget 2005 fit the same jets by
one SVD each; the scaled coordinates keep the normal equations well conditioned here).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from .workspace import Workspace

# A pivot this far below its diagonal entry means that the samples do not determine the term:
# the moments carry about 1e-16 of relative error, so smaller ones are round-off.
RANK_TOLERANCE = 1e-11


@dataclass(frozen=True)
class HeightFit:
    """Polynomial heights z(x, y) = sum c_ab x^a y^b over b fits.

    Attributes
    ----------
    coefficients:
        {(a, b): (b,) float64} for a + b <= degree, in the units of the samples.
    residual:
        (b,) float64 weighted standard deviation of the residuals, same unit as z.
    gap_error:
        (b,) float64 root mean square error that the residual leaves in the deviator
        2 (c20 - c02) + 2i c11.
    determined:
        (b,) bool, False where the samples do not determine every coefficient.
    """

    coefficients: dict[tuple[int, int], np.ndarray]
    residual: np.ndarray
    gap_error: np.ndarray
    determined: np.ndarray


@cache
def _terms(degree: int) -> list[tuple[int, int]]:
    """Exponents with the quadratic terms last: their Schur complement is their covariance."""
    quadratic = [(2, 0), (1, 1), (0, 2)]
    every = [(total - b, b) for total in range(degree + 1) for b in range(total + 1)]
    return [term for term in every if term not in quadratic] + quadratic


def _by_rising_powers(degree: int) -> list[tuple[int, int]]:
    return [(a, b) for a in range(degree + 1) for b in range(degree + 1 - a)]


def sum_count(degree: int) -> int:
    """Rows of the sums that a fit of this degree needs, see `sum_samples`."""
    return len(_by_rising_powers(2 * degree)) + len(_by_rising_powers(degree)) + 1


@cache
def _system_rows(degree: int) -> np.ndarray:
    """(t, t + 1) rows of the sums that make up the normal equations of the t terms."""
    moments = _by_rising_powers(2 * degree)
    moment = {exponents: row for row, exponents in enumerate(moments)}
    lifted = {
        exponents: row for row, exponents in enumerate(_by_rising_powers(degree), len(moments))
    }
    terms = _terms(degree)
    return np.array(
        [[moment[a + c, b + d] for c, d in terms] + [lifted[a, b]] for a, b in terms], np.int32
    )


def fit_heights(
    x: np.ndarray, y: np.ndarray, z: np.ndarray, weights: np.ndarray | None, degree: int
) -> HeightFit:
    """Fit z as a polynomial of the given degree (>= 2) to each column of samples (s, b).

    The parameters are those of `sum_samples`.
    """
    samples, fits = x.shape
    sums, workspace = np.empty((sum_count(degree), fits)), Workspace()
    sum_samples(x, y, z, weights, degree, sums, workspace)
    return solve_heights(sums, np.full(fits, samples), degree, workspace)


def sum_samples(
    x: np.ndarray,
    y: np.ndarray,
    z: np.ndarray,
    weights: np.ndarray | None,
    degree: int,
    sums: np.ndarray,
    workspace: Workspace,
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
        (r, b) float64 takes the weighted sums: of x^a y^b for a + b <= 2 degree, of z x^a y^b
        for a + b <= degree, both by rising a, then b; and of z^2. r is `sum_count`.
    workspace:
        Buffers to work in, for calls in a loop.
    """
    most = 2 * degree
    along_x = _powers("powers of x", weights, x, most, workspace)
    along_y = _powers("powers of y", None, y, most, workspace)
    lifted = workspace.array("lifted", degree + 1, *x.shape)
    np.multiply(along_x[: degree + 1], z, out=lifted)
    # All sums with one power of x in one call: threads meet at the interpreter lock between them.
    counts = [(left, most + 1 - a) for a, left in enumerate(along_x)]
    counts += [(left, degree + 1 - a) for a, left in enumerate(lifted)]
    begin = 0
    for left, count in counts:
        np.einsum("sb,qsb->qb", left, along_y[:count], out=sums[begin : begin + count])
        begin += count
    np.einsum("sb,sb->b", lifted[0], z, out=sums[begin])


def _powers(
    name: str, first: np.ndarray | None, base: np.ndarray, most: int, workspace: Workspace
) -> np.ndarray:
    """(most + 1, s, b): `first` (ones if None) times base^0, base^1, ... base^most."""
    powers = workspace.array(name, most + 1, *base.shape)
    powers[0] = 1.0 if first is None else first
    for k in range(1, most + 1):
        np.multiply(powers[k - 1], base, out=powers[k])
    return powers


def solve_heights(
    sums: np.ndarray, samples: np.ndarray, degree: int, workspace: Workspace
) -> HeightFit:
    """The fits of a degree from `sums` (r, b) over their `samples` (b,), see `sum_samples`."""
    terms = _terms(degree)
    size, first = len(terms), len(terms) - 3
    system = workspace.array("system", size, size + 1, sums.shape[1])
    np.take(sums, _system_rows(degree), axis=0, out=system, mode="clip")
    diagonal = np.arange(size)
    floor = np.maximum(RANK_TOLERANCE * system[diagonal, diagonal], np.finfo(float).tiny)
    with np.errstate(all="ignore"):  # undetermined columns may overflow; they are zeroed below
        pivots = _eliminate(system, floor[:first], workspace)
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
        spread = covariance[0, 0] + covariance[2, 2] - 2 * covariance[0, 2] + covariance[1, 1]
        gap_error = 2 * np.sqrt(np.maximum(spread, 0) * variance * total / samples)
    if not determined.all():
        for values in (solution, variance, gap_error):
            values[..., ~determined] = 0.0
    return HeightFit(
        {term: solution[row] for row, term in enumerate(terms)},
        np.sqrt(variance),
        gap_error,
        determined,
    )


def _eliminate(system: np.ndarray, floor: np.ndarray, workspace: Workspace) -> np.ndarray:
    """Eliminate the first p unknowns from the upper triangles of systems (t, t + 1, b) in place.

    Returns their pivots (p, b), at least `floor` (p, b): weak ones must not divide by zero.
    """
    size, _, fits = system.shape
    pivots = np.empty(floor.shape)
    for pivot, lowest in enumerate(floor):
        np.maximum(system[pivot, pivot], lowest, out=pivots[pivot])
        factor = workspace.array("factor", size - pivot - 1, fits)
        np.divide(system[pivot, pivot + 1 : size], pivots[pivot], out=factor)
        for row, times in enumerate(factor, pivot + 1):
            change = workspace.array("change", size + 1 - row, fits)
            np.multiply(times, system[pivot, row:], out=change)
            system[row, row:] -= change
    return pivots


def _inverse_of_last(q: np.ndarray, floor: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Inverse (3, 3, b) of the Schur complements q (3, 3, b) of the three quadratic terms, and
    (b,) whether they have one; only the upper triangles are read."""
    cofactor = {
        (0, 0): q[1, 1] * q[2, 2] - q[1, 2] ** 2,
        (0, 1): q[0, 2] * q[1, 2] - q[0, 1] * q[2, 2],
        (0, 2): q[0, 1] * q[1, 2] - q[0, 2] * q[1, 1],
        (1, 1): q[0, 0] * q[2, 2] - q[0, 2] ** 2,
        (1, 2): q[0, 1] * q[0, 2] - q[0, 0] * q[1, 2],
        (2, 2): q[0, 0] * q[1, 1] - q[0, 1] ** 2,
    }
    determinant = (
        q[0, 0] * cofactor[0, 0] + q[0, 1] * cofactor[0, 1] + q[0, 2] * cofactor[0, 2]
    )
    regular = determinant > floor[0] * floor[1] * floor[2]
    for k in range(3):
        regular &= q[k, k] > floor[k]
    inverse = np.empty(q.shape)
    for (i, j), value in cofactor.items():
        np.divide(value, determinant, out=inverse[i, j])
        inverse[j, i] = inverse[i, j]
    return inverse, regular
