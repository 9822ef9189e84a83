"""Linear conditions solved for some of the unknowns, so that the others are free.

What a seamless map must hold across a cut (Bommer et al. 2009, 10.1145/1531326.1531383) are sparse
sums with coefficients of one or a few units. Eliminated once, they leave problems without
conditions, whose matrices are definite and have half the fill of the saddle points before.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse

from ....base.factors import definite_factors

# Coefficients below this are round-off; a coefficient is divided by if it is not smaller than this
# part of the largest.
NOTHING, LEAST_PIVOT = 1e-9, 0.1
# A trace of the mean diagonal keeps apart what nothing holds: a map may be shifted as a whole.
FLOATING = 1e-10


def free_basis(conditions: sparse.sparray, count: int) -> sparse.csr_array:
    """(count, f) the first unknowns by the f free ones, for conditions (c, u) that must be 0.

    Conditions that follow from others add nothing. Each is solved for the unknown that the fewest
    others hang on.
    """
    rows = conditions.tocsr()
    start, column, value = (part.tolist() for part in (rows.indptr, rows.indices, rows.data))
    solved: dict[int, dict[int, float]] = {}
    # Which of the solved unknowns hold each of the others.
    users: dict[int, set[int]] = {}
    for number in range(rows.shape[0]):
        span = slice(start[number], start[number + 1])
        sums: dict[int, float] = {}
        for name, factor in zip(column[span], value[span], strict=True):
            for other, share in solved.get(name, {name: 1.0}).items():
                sums[other] = sums.get(other, 0.0) + factor * share
        sums = {name: factor for name, factor in sums.items() if abs(factor) > NOTHING}
        if not sums:
            continue
        least = LEAST_PIVOT * max(map(abs, sums.values()))
        pivot = min(
            (name for name, factor in sums.items() if abs(factor) >= least),
            key=lambda name: (len(users.get(name, ())), name),
        )
        by = sums.pop(pivot)
        terms = {name: -factor / by for name, factor in sums.items()}
        for user in users.pop(pivot, set()):
            _put_in(solved[user], user, pivot, terms, users)
        solved[pivot] = terms
        for name in terms:
            users.setdefault(name, set()).add(pivot)
    return _as_matrix(solved, rows.shape[1])[:count]


def _put_in(
    held: dict[int, float],
    user: int,
    pivot: int,
    terms: dict[int, float],
    users: dict[int, set[int]],
) -> None:
    """Write `terms` for the unknown `pivot` in what `user` holds, in place."""
    by = held.pop(pivot)
    for name, factor in terms.items():
        total = held.get(name, 0.0) + by * factor
        if abs(total) > NOTHING:
            held[name] = total
            users.setdefault(name, set()).add(user)
        elif name in held:
            del held[name]
            users[name].discard(user)


def _as_matrix(solved: dict[int, dict[int, float]], count: int) -> sparse.csr_array:
    free = np.ones(count, bool)
    free[list(solved)] = False
    place = np.cumsum(free) - 1
    own = np.flatnonzero(free)
    size = [len(terms) for terms in solved.values()]
    row = np.repeat(np.fromiter(solved, np.int64, len(solved)), size)
    column = np.array([name for terms in solved.values() for name in terms], np.int64)
    value = np.array([factor for terms in solved.values() for factor in terms.values()])
    return sparse.coo_array(
        (
            np.concatenate([np.ones(len(own)), value]),
            (np.concatenate([own, row]), place[np.concatenate([own, column])]),
        ),
        shape=(count, len(own)),
    ).tocsr()


def least_step(
    basis: sparse.csr_array, unknown: np.ndarray, matrix: np.ndarray, right: np.ndarray
) -> np.ndarray:
    """(u,) the step of all unknowns that minimizes a sum of quadratic forms, 1/2 s A s - b s.

    Parameters
    ----------
    basis:
        (u, f) the unknowns by those that move freely.
    unknown:
        (t, k) unknowns of each form.
    matrix, right:
        (t, k, k) and (t, k) of the forms; their sum is definite but for a shift of all.
    """
    count = basis.shape[0]
    if not basis.shape[1]:
        return np.zeros(count)
    # Only the rows that the forms touch.
    used, local = np.unique(unknown, return_inverse=True)
    local = local.reshape(unknown.shape)
    some = basis[used]
    rows = np.broadcast_to(local[:, :, None], matrix.shape).ravel()
    columns = np.broadcast_to(local[:, None, :], matrix.shape).ravel()
    size = (len(used), len(used))
    whole = sparse.coo_array((matrix.ravel(), (rows, columns)), shape=size).tocsr()
    force = some.T @ np.bincount(local.ravel(), weights=right.ravel(), minlength=len(used))
    form = (some.T @ whole @ some).tocsc()
    scale = float(form.diagonal().mean())
    form = form / scale + FLOATING * sparse.eye_array(form.shape[0])
    return np.asarray(basis @ definite_factors(form).solve(force / scale))
