"""Solver for Hermitian positive definite systems whose entries carry tangent vectors.

Conjugate gradients with a multilevel preconditioner by smoothed aggregation (Vanek, Mandel &
Brezina 1996). Vertices are gathered around roots; the vector of a root is carried to the others
of its aggregate by the phases of the matrix itself, so the levels need no geometry: on a
surface the coarse vectors are those that are as parallel as the connection allows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from ..base.factors import definite_factors
from ..base.progress import Progress
from ..base.unit import phase as unit_phase

# The coarsest level has at most so many rows.
SMALLEST = 1500
ROUNDING = float(np.finfo(np.float32).eps)
# Real systems of at most so many stored entries are factorized as a whole: 26,000 triangles and
# their neighbours take 0.07 s so, and weights of many orders of magnitude do not matter, under
# which conjugate gradients end far off.
FACTORIZED = 120_000
LEVELS = 12
# Damped Jacobi is stable up to twice the inverse of the largest eigenvalue of D^-1 A, which is
# at most 2 for a Laplacian of positive weights.
DAMPING = 0.8


@dataclass(frozen=True)
class _Level:
    matrix: sparse.csr_array
    inverse_diagonal: np.ndarray
    prolongation: sparse.csr_array
    restriction: sparse.csr_array


class Multigrid:
    """One V-cycle of the matrix (n, n), in single precision: a preconditioner, not a solver."""

    def __init__(self, matrix: sparse.csr_array, progress: Progress) -> None:
        # Single precision holds numbers up to 1e38: slivers weigh more.
        self._size = float(np.abs(matrix.data).max(initial=0.0)) or 1.0
        matrix = (matrix * (1.0 / self._size)).astype(np.complex64)
        self._levels: list[_Level] = []
        while matrix.shape[0] > SMALLEST and len(self._levels) < LEVELS:
            progress.ask()
            level, coarser = _coarsened(matrix)
            if coarser.shape[0] > 0.8 * matrix.shape[0]:
                break  # nothing left to gather: unconnected vertices
            self._levels.append(level)
            matrix = coarser
        progress.ask()
        # Single precision tells a matrix no better than that: a tetrahedron by itself, around whose
        # corners crosses come back to themselves, is singular without, or nothing at all.
        diagonal = np.abs(matrix.diagonal())
        unknown = np.where(diagonal > 0.0, ROUNDING * diagonal, 1.0)
        known = matrix + sparse.diags_array(unknown)
        self._solve = splu(known.astype(np.complex128).tocsc(), permc_spec="MMD_AT_PLUS_A").solve

    def __call__(self, right: np.ndarray) -> np.ndarray:
        """(n,) complex128: roughly the inverse of the matrix times `right`."""
        size = float(np.abs(right).max(initial=0.0)) or 1.0
        found = self._cycle(0, (right / size).astype(np.complex64)).astype(np.complex128)
        return np.asarray(found * (size / self._size))

    def _cycle(self, depth: int, right: np.ndarray) -> np.ndarray:
        if depth == len(self._levels):
            return self._solve(right.astype(np.complex128)).astype(np.complex64)
        level = self._levels[depth]
        value = level.inverse_diagonal * right
        residual = right - level.matrix @ value
        value += level.prolongation @ self._cycle(depth + 1, level.restriction @ residual)
        value += level.inverse_diagonal * (right - level.matrix @ value)
        return value


def _coarsened(matrix: sparse.csr_array) -> tuple[_Level, sparse.csr_array]:
    n = matrix.shape[0]
    diagonal = matrix.diagonal().real
    aggregate, phase, count = _aggregates(matrix)
    member = np.flatnonzero(aggregate >= 0)
    tentative = sparse.csr_array(
        (phase[member], (member, aggregate[member])), shape=(n, count), dtype=np.complex64
    )
    # Rows that single precision does not tell from nothing are left to the steps that ask.
    held = diagonal > np.finfo(np.float32).tiny / DAMPING
    damped = np.where(held, DAMPING / np.where(held, diagonal, 1.0), 0.0).astype(np.complex64)
    prolongation = tentative - sparse.diags_array(damped) @ (matrix @ tentative)
    prolongation = prolongation.tocsr()
    restriction = prolongation.conj().T.tocsr()
    coarser = (restriction @ (matrix @ prolongation)).tocsr()
    return _Level(matrix, damped, prolongation, restriction), coarser


def _aggregates(matrix: sparse.csr_array) -> tuple[np.ndarray, np.ndarray, int]:
    """Gather the rows of a matrix around roots that are at least three steps apart.

    Returns
    -------
    aggregate, phase, count:
        (n,) aggregate of each row, (n,) complex64 of modulus 1 that carries the aggregate's
        value to the row, and how many aggregates there are.
    """
    n = matrix.shape[0]
    start, other = matrix.indptr, matrix.indices
    # Rows hold at least their diagonal, so that no segment of the reductions is empty.
    priority = np.random.default_rng(0).permutation(n).astype(np.int32) + 1
    root = np.zeros(n, bool)
    open_rows = np.ones(n, bool)
    for _ in range(30):
        value = np.where(open_rows, priority, 0)
        around = np.maximum.reduceat(value[other], start[:-1])
        around = np.maximum.reduceat(around[other], start[:-1])
        fresh = open_rows & (around == priority)
        root |= fresh
        near = np.logical_or.reduceat(fresh[other], start[:-1])
        near = np.logical_or.reduceat(near[other], start[:-1])
        open_rows &= ~near
        if not open_rows.any():
            break
    root |= open_rows
    count = int(root.sum())
    aggregate = np.full(n, -1, np.int64)
    aggregate[root] = np.arange(count)
    phase = np.zeros(n, np.complex64)
    phase[root] = 1.0
    owner = np.repeat(np.arange(n, dtype=np.int32), np.diff(start))
    size = np.abs(matrix.data)
    size[owner == other] = 0.0
    for _ in range(3):
        if (aggregate >= 0).all():
            break
        joined = aggregate >= 0
        # The strongest link of each open row into an aggregate.
        strength = np.where(joined[other] & ~joined[owner], size, 0.0)
        best = np.maximum.reduceat(strength, start[:-1])
        chosen = np.flatnonzero((strength > 0) & (strength == best[owner]))
        row, link = owner[chosen], other[chosen]
        aggregate[row] = aggregate[link]
        phase[row] = -unit_phase(matrix.data[chosen].astype(np.complex128)) * phase[link]
    lonely = np.flatnonzero(aggregate < 0)
    aggregate[lonely] = count + np.arange(len(lonely))
    phase[lonely] = 1.0
    return aggregate, phase, count + len(lonely)


def solve(
    matrix: sparse.csr_array,
    right: np.ndarray,
    progress: Progress,
    tolerance: float = 2e-4,
    most: int = 200,
    precondition: Multigrid | None = None,
) -> np.ndarray:
    """(n,) complex128 solution of matrix @ x = right by preconditioned conjugate gradients.

    Parameters
    ----------
    matrix:
        (n, n) complex128 Hermitian positive definite, with its diagonal stored.
    right:
        (n,) complex128 right side.
    tolerance:
        Norm of the error, as the preconditioner sees it, over that of x at which to stop. The
        residual would not do: rows that weigh much, as those of features, drown all others in it.
    most:
        Steps after which the best so far is returned.
    precondition:
        That of the very matrix, where it is solved with again; made here without.
    """
    precondition = precondition or Multigrid(matrix, progress)
    # Begun at zero: the first step is a whole V-cycle and has the coarse shape right at once.
    x = np.zeros(len(right), np.complex128)
    residual = right.astype(np.complex128)
    direction, along = None, 1.0
    for _ in range(most):
        error = precondition(residual)
        size, wanted = float(np.linalg.norm(error)), tolerance * float(np.linalg.norm(x))
        if size <= wanted:
            break
        # The logarithm of the error falls evenly; x is zero at first and gives it no measure.
        share = np.log(tolerance * size / wanted) / np.log(tolerance) if wanted > 0.0 else 0.0
        progress.step(float(share))
        before, along = along, float(np.vdot(residual, error).real)
        direction = error if direction is None else error + (along / before) * direction
        step = matrix @ direction
        share = along / float(np.vdot(direction, step).real)
        x += share * direction
        residual -= share * step
    return x


def solve_diagonal(
    matrix: sparse.csr_array,
    right: np.ndarray,
    progress: Progress,
    tolerance: float = 1e-3,
    most: int = 100,
) -> np.ndarray:
    """As `solve`, real or complex, by the diagonal alone and in single precision: in a part of the
    time where the diagonal weighs enough that what lies far apart does not matter. The error is
    the diagonal's, which tells little of what varies slowly. What has not come to the tolerance
    after so many steps is left to `solve`."""
    single = np.complex64 if np.iscomplexobj(matrix.data) else np.float32
    scale = 1.0 / np.sqrt(matrix.diagonal().real)
    data = matrix.data * np.repeat(scale, np.diff(matrix.indptr))
    data *= scale[matrix.indices]
    rows = matrix.indices, matrix.indptr
    system = sparse.csr_array((data.astype(single), *rows), shape=matrix.shape)
    residual = (scale * right).astype(single)
    x = np.zeros_like(residual)
    direction = residual.copy()
    along = float(np.vdot(residual, residual).real)
    for _ in range(most):
        progress.ask()
        if not along:
            return np.asarray(scale * x)
        step = system @ direction
        bend = float(np.vdot(direction, step).real)
        if not bend > 0.0:
            # Single precision does not see far enough.
            break
        share = np.float32(along / bend)
        x += share * direction
        residual -= share * step
        before, along = along, float(np.vdot(residual, residual).real)
        if along <= tolerance**2 * float(np.vdot(x, x).real):
            return np.asarray(scale * x)
        direction *= np.float32(along / before)
        direction += residual
    return _by_multigrid(matrix, right, progress)


def _by_multigrid(matrix: sparse.csr_array, right: np.ndarray, progress: Progress) -> np.ndarray:
    """(n,) solution as `solve` gives it, real or complex as the matrix is."""
    found = solve(matrix.astype(np.complex128), right.astype(np.complex128), progress)
    return found if np.iscomplexobj(matrix.data) else found.real


def solve_part(matrix: sparse.csr_array, right: np.ndarray, progress: Progress) -> np.ndarray:
    """(n,) solution of matrix @ x = right, real or complex as both are: exact for a small system,
    for a large one as `solve` gives it, since factors fill up faster than they grow."""
    if matrix.nnz > FACTORIZED:
        return _by_multigrid(matrix, right, progress)
    return np.asarray(definite_factors(matrix).solve(right))
