"""A seamless map by least squares, with which making it injective begins."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from ....base.progress import Progress
from ....mesh.rings import with_rings
from ..field.crosses import Crosses
from .cones import cone_scales, cone_targets
from .elimination import least_step
from .seamless_map import SeamlessProblem, determinant

# Flips that the first solution may have before all triangles are weighed anew, as a share, and
# how often that is done at most.
FEW_FLIPS, REWEIGHINGS = 0.003, 6
# Determinant below which a triangle counts as flipped; 1 is undistorted.
FLIPPED = 1e-3
# Residuals count up to this when triangles are weighed anew.
MOST_RESIDUAL = 5.0
# What fans of poles and the rings around them weigh where they are stiffened, and the least weight
# of a triangle there: without weight a triangle would flip for nothing.
STIFFER, STIFFER_AROUND, LEAST_STIFFENED = 6.0, 2.0, 0.1


def first_map(problem: SeamlessProblem, progress: Progress) -> np.ndarray:
    """(unknowns,) the least-squares map, its triangles weighed anew while many are flipped."""
    weight = problem.weight
    x = least_squares(problem, weight)
    flips = determinant(problem.jacobian(x)) <= FLIPPED
    best, least = x, np.count_nonzero(flips)
    around = _around(problem.crosses)
    for _ in range(REWEIGHINGS):
        progress.ask()
        if least <= FEW_FLIPS * len(weight):
            break
        off = problem.jacobian(x) - np.array([1.0, 0.0, 0.0, 1.0])
        residual = np.minimum((off**2).sum(axis=1), MOST_RESIDUAL)
        weight = weight * (1.0 + residual) * np.where(flips, 2.0, 1.0)
        # Neighbours share half of what is put on, so that weights do not jump.
        weight = np.sqrt(weight * (around @ weight))
        x = least_squares(problem, weight)
        flips = determinant(problem.jacobian(x)) <= FLIPPED
        if np.count_nonzero(flips) < least:
            best, least = x, np.count_nonzero(flips)
    return best


def followed_map(
    problem: SeamlessProblem,
    firm: np.ndarray,
    evened: float,
    share: float,
    progress: Progress,
) -> np.ndarray:
    """(unknowns,) the least-squares map that follows the crosses as much as they count.

    Fans of poles are held to their turns, and triangles around them to the sizes that they ask for.

    Parameters
    ----------
    firm:
        (m,) what triangles weigh besides.
    evened:
        Over how many lengths of quads sizes go back to what they shall be.
    share:
        How much of what poles ask for they follow, in logarithms.
    """
    progress.ask()
    crosses = problem.crosses
    pole = crosses.singular
    fan = pole[crosses.triangles].any(axis=1)
    around = with_rings(crosses.triangles, pole, 1)[crosses.triangles].any(axis=1)
    weight = np.where(around, np.maximum(problem.weight, LEAST_STIFFENED), problem.weight)
    weight *= np.where(fan, STIFFER, np.where(around, STIFFER_AROUND, 1.0)) * firm
    target = problem.target * (cone_scales(crosses, evened) ** share)[:, None]
    opened, wanted = cone_targets(crosses, problem.seams, np.flatnonzero(pole))
    target[opened] = wanted
    return least_squares(problem, weight, target=target)


def least_squares(
    problem: SeamlessProblem,
    weight: np.ndarray,
    x: np.ndarray | None = None,
    basis: sparse.csr_array | None = None,
    triangles: np.ndarray | None = None,
    target: np.ndarray | None = None,
) -> np.ndarray:
    """The map whose Jacobians come nearest to the wanted ones, (unknowns,).

    Parameters
    ----------
    weight:
        (m,) weights of the triangles.
    x, basis, triangles:
        A solution that changes by a basis only, and the triangles (t,) that this touches; all of
        them without.
    target:
        (m, 4) Jacobians that are wanted in place of the problem's.
    """
    target = problem.target if target is None else target
    x = np.zeros(problem.count) if x is None else x
    basis = problem.whole_basis if basis is None else basis
    triangles = np.arange(len(weight)) if triangles is None else triangles
    derivative, unknown = problem.derivative[triangles], problem.unknown[triangles]
    rest = target[triangles] - np.einsum("mij,mj->mi", derivative, x[unknown])
    by, shear = weight[triangles], problem.shear[triangles]
    each = np.stack([by, by * shear, by * shear, by], axis=1)
    right = np.einsum("mi,mij,mi->mj", each, derivative, rest)
    matrix = np.einsum("mi,mij,mik->mjk", each, derivative, derivative, optimize=True)
    return x + least_step(basis, unknown, matrix, right)


def _around(crosses: Crosses) -> sparse.csr_array:
    """(m, m) mean over the triangles that touch a triangle's corners."""
    m, n = len(crosses.triangles), len(crosses.vertices)
    touch = sparse.coo_array(
        (np.ones(3 * m), (np.arange(3 * m) // 3, crosses.tail)), shape=(m, n)
    ).tocsr()
    count = np.asarray(touch.sum(axis=0)).ravel()
    mean = sparse.diags_array(1.0 / np.maximum(count, 1.0)) @ touch.T
    return (touch @ mean / 3.0).tocsr()
