"""Factors of symmetric positive definite sparse matrices."""

from __future__ import annotations

from scipy import sparse
from scipy.sparse.linalg import SuperLU, splu


def definite_factors(matrix: sparse.sparray) -> SuperLU:
    """The factors of a matrix (n, n) that is symmetric, or Hermitian, and positive definite.

    It is ordered by its own graph and needs no pivots; ordered like any other matrix, by the
    columns of its square, it fills up twice as far.
    """
    return splu(
        matrix.tocsc(),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
