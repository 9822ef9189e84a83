"""Weighted least squares of height functions, many small fits at a time.

A block of b fits with s samples each is held as (s, b) arrays, one per coordinate, so that
every operation runs along b. The normal equations are assembled from the moments of the
samples and eliminated in place over the whole block (Cazals & Pouget 2005 fit the same jets
by one SVD each; the scaled coordinates keep the normal equations well conditioned here).
"""

from __future__ import annotations

from dataclasses import dataclass

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


def _terms(degree: int) -> list[tuple[int, int]]:
    """Exponents with the quadratic terms last: their Schur complement is their covariance."""
    quadratic = [(2, 0), (1, 1), (0, 2)]
    every = [(total - b, b) for total in range(degree + 1) for b in range(total + 1)]
    return [term for term in every if term not in quadratic] + quadratic


def fit_heights(
    x: np.ndarray,
    y: np.ndarray,
    z: np.ndarray,
    root: np.ndarray | None,
    degree: int,
    workspace: Workspace | None = None,
) -> HeightFit:
    """Fit z as a polynomial of the given degree (>= 2) to each column of samples.

    Parameters
    ----------
    x, y, z:
        (s, b) float64 samples; x and y should be of order 1.
    root:
        (s, b) float64 square root of the weight of each sample, or None for equal ones.
    degree:
        Degree of the polynomial, at least 2.
    workspace:
        Buffers to work in, for calls in a loop.
    """
    samples, fits = x.shape
    terms = _terms(degree)
    size = len(terms)
    # The root of the weight in every factor puts the weight into every product of two.
    workspace = workspace or Workspace()
    monomials = _monomials(x, y, root, degree, workspace)
    heights = z
    if root is not None:
        heights = np.multiply(z, root, out=workspace.array("heights", samples, fits))
    system = workspace.array("system", size, size + 1, fits)
    moments: dict[tuple[int, int], np.ndarray] = {}
    for row, (a, b) in enumerate(terms):
        left = monomials[a, b]
        for column in range(row, size):
            c, d = terms[column]
            exponents = (a + c, b + d)
            if exponents not in moments:
                moments[exponents] = np.einsum("sb,sb->b", left, monomials[c, d])
            system[row, column] = moments[exponents]
        np.einsum("sb,sb->b", left, heights, out=system[row, size])
    square = np.einsum("sb,sb->b", heights, heights)

    floor = RANK_TOLERANCE * system[np.arange(size), np.arange(size)]
    determined = np.ones(fits, bool)
    explained = np.zeros(fits)
    for pivot in range(size - 3):
        _eliminate(system, pivot, floor, determined)
        explained += system[pivot, size] ** 2 / system[pivot, pivot]
    covariance = _inverse_of_last(system, floor, determined)
    solution = np.empty((size, fits))
    right = system[size - 3 :, size]
    solution[size - 3 :] = np.einsum("ijb,jb->ib", covariance, right)
    explained += np.einsum("ib,ib->b", right, solution[size - 3 :])
    for row in range(size - 4, -1, -1):
        known = np.einsum("jb,jb->b", system[row, row + 1 : size], solution[row + 1 :])
        solution[row] = (system[row, size] - known) / system[row, row]

    # Round-off leaves about 1e-16 of the squared heights; below that nothing is known.
    total = float(samples) if root is None else np.einsum("sb,sb->b", root, root)
    freedom = max(samples - size, 1) / samples
    variance = np.maximum(square - explained, 1e-16 * square) / (total * freedom)
    spread = covariance[0, 0] + covariance[2, 2] - 2 * covariance[0, 2] + covariance[1, 1]
    gap_error = 2 * np.sqrt(np.maximum(spread, 0) * variance * total / samples)
    return HeightFit(
        {term: solution[row] for row, term in enumerate(terms)},
        np.sqrt(variance),
        gap_error,
        determined & (samples >= size),
    )


def _monomials(
    x: np.ndarray, y: np.ndarray, root: np.ndarray | None, degree: int, workspace: Workspace
) -> dict[tuple[int, int], np.ndarray]:
    """x^a y^b for a + b <= degree, each times `root` unless that is None."""
    terms = _terms(degree)
    arrays = iter(workspace.array("monomials", len(terms), *x.shape))
    powers = {}
    for total in range(degree + 1):
        for b in range(total + 1):
            a, out = total - b, next(arrays)
            if total == 0:
                out[:] = 1.0 if root is None else root
            elif a:
                np.multiply(powers[a - 1, b], x, out=out)
            else:
                np.multiply(powers[a, b - 1], y, out=out)
            powers[a, b] = out
    return powers


def _eliminate(
    system: np.ndarray, pivot: int, floor: np.ndarray, determined: np.ndarray
) -> None:
    """One step of the LDL^T elimination on the upper triangle; weak pivots are neutralized."""
    size = system.shape[0]
    weak = ~(system[pivot, pivot] > floor[pivot])
    if weak.any():
        determined &= ~weak
        system[pivot, pivot:, weak] = 0.0
        system[pivot, pivot, weak] = 1.0
    for row in range(pivot + 1, size):
        factor = system[pivot, row] / system[pivot, pivot]
        system[row, row:] -= factor * system[pivot, row:]


def _inverse_of_last(
    system: np.ndarray, floor: np.ndarray, determined: np.ndarray
) -> np.ndarray:
    """Inverse (3, 3, b) of the Schur complement of the three quadratic terms."""
    first = system.shape[0] - 3
    q = {(i, j): system[first + i, first + j] for i in range(3) for j in range(i, 3)}
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
    weak = ~(determinant > floor[first] * floor[first + 1] * floor[first + 2])
    for k in range(3):
        weak |= ~(q[k, k] > floor[first + k])
    determined &= ~weak
    scale = np.where(weak, 0.0, 1.0 / np.where(weak, 1.0, determinant))
    inverse = np.empty((3, 3, system.shape[2]))
    for (i, j), value in cofactor.items():
        inverse[i, j] = inverse[j, i] = value * scale
    return inverse
