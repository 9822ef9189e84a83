"""Making a seamless map injective around every point, by work near its flipped triangles only.

The energy |J|^2 / 2 chi(det J) + (1 + det^2 J) / 2 chi(det J) is finite for flipped triangles and,
as the regularization chi of the determinant sharpens, grows without bound before one flips
(Garanzha, Kaporin, Kudryavtseva, Protais, Ray & Sokolov 2021, 10.1145/3453141). It is minimized by
Newton's method with each triangle's Hessian made definite, under the same linear conditions as
the map. A fan of triangles may also unfold to the wrong number of turns about a vertex, which no
determinant shows; such fans are stiffened by least squares first.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import sparse

from ....base.progress import Progress
from ....mesh.rings import with_rings
from ..field.crosses import distances
from .cones import cone_targets
from .elimination import least_step
from .first_map import (
    FLIPPED,
    LEAST_STIFFENED,
    STIFFER,
    STIFFER_AROUND,
    first_map,
    followed_map,
    least_squares,
)
from .seamless_map import SeamlessProblem, determinant

# How often fans are stiffened, and how many rings then move.
STIFFENINGS, STIFFENED_RINGS = 5, 9
# Over how many lengths of quads sizes go back from what poles ask for to what they shall be, and
# how much of it they follow, first and where a map is loosened: the more of both the sooner maps
# become injective, and the less even quads are. At first half has the same angles as all. Chosen
# on waves 0 to 3 of the benchmark and on bowls of two thin sheets; confirmed on waves 4 and 5,
# Spot and a skull.
SOON_EVENED, EVENED = (2.0, 0.5), (5.0, 1.0)
# How often a map is loosened from the crosses around poles that fail, how near to a fault these
# are, and how much farther that goes each time, in lengths of quads; what triangles there weigh,
# and over which length that fades. Chosen on waves 0 to 11 of the benchmark.
LOOSENINGS, BESIDE, FARTHER, FIRM, FADING = 2, 2.5, 2.0, 10.0, 2.0
# Rings around flipped triangles that move, first and at most, and their growth.
FIRST_RINGS, MOST_RINGS, RING_GROWTH = 6, 40, 1.8
# A first map with flipped triangles at more than this share of the vertices is given back as it is:
# its features and poles contradict each other, and untangling it took nine tenths of the time in
# vain. Chosen on a face and a torso, where maps that became injective had flips at 1 % at most and
# those that did not at 9 % or more; confirmed on fandisk, a skull, a teapot and a plate with holes.
HOPELESS = 0.05
# Rounds without fewer flips before giving up.
PATIENCE = 2
# Steps of Newton's method in one region; determinant at which it is content.
STEPS, CONTENT = 30, 0.02
# What a step must leave of the least determinant, once all are positive, and of the determinant of
# each triangle at a pole.
KEEP, KEEP_GUARDED = 0.02, 0.05
# Least weight of a triangle beside the mean where flips are undone: without weight a triangle would
# flip for nothing.
LEAST_WEIGHT = 0.05
# The width in which the determinant is regularized: SHARP where none is flipped, else the root of
# FLAT + SOFT det^2 of the least one.
SHARP, FLAT, SOFT = 1e-3, 1e-4, 0.04
# The eigenvalues of a triangle's Hessian are at least this part of its largest, and so much.
DEFINITE, LEAST_CURVED = 1e-6, 1e-9
# From KEEP_GUARDED on these were tried on 13 first maps with flips (random surfaces 2, 13, 35, 73
# and 119 of benchmarks/quads; a decimated monkey, texts and a thin sheet from Blender): at half and
# twice (SHARP and DEFINITE a tenth and ten times, LEAST_CURVED a tenth), the same nine become
# injective. With half the width of SOFT that takes 1.6 times as long.
# A step must win this part of what its slope promises.
ARMIJO = 1e-4
LEAST_STEP = 1e-9
# What the determinant's derivatives make of one another.
_SWAP = np.array([[0, 0, 0, 1], [0, 0, -1, 0], [0, -1, 0, 0], [1, 0, 0, 0]], float)


def injective_map(problem: SeamlessProblem, progress: Progress) -> tuple[np.ndarray, np.ndarray]:
    """A map of `problem`, and where it is still not injective.

    Where poles fail it is loosened from the crosses around them, in the end everywhere.

    Returns
    -------
    x, faults:
        (unknowns,) solution, and (n,) bool vertices of triangles that are flipped or around
        which the map makes the wrong number of turns; none where the map is injective around
        every point.
    """
    crosses, shear = problem.crosses, problem.shear
    even = replace(problem, shear=np.ones(len(shear)))
    pole = crosses.singular
    if (shear > 1.0).any():
        loose, firm = np.zeros(len(pole), bool), np.ones(len(shear))
        for number in range(LOOSENINGS + 1):
            part = progress.part("Mapping the surface", 0.2 * number, 0.2 * (number + 1))
            evened = EVENED if number else SOON_EVENED
            x, faults = _untangled(problem, followed_map(problem, firm, *evened, part), part)
            if not faults.any():
                return x, faults
            beside = pole & (distances(crosses, np.flatnonzero(faults), BESIDE) < BESIDE)
            if np.count_nonzero(faults) > HOPELESS * len(faults) or not beside.any():
                break
            loose |= beside
            reach = FARTHER * (number + 1)
            far = distances(crosses, np.flatnonzero(loose), 2.0 * reach + FADING)
            far = far[crosses.triangles].mean(axis=1)
            firm = 1.0 + (FIRM - 1.0) * np.clip((reach - far) / FADING, 0.0, 1.0)
            problem = replace(problem, shear=np.where(far < reach, 1.0, shear))
    part = progress.part("Mapping the surface", 0.6, 1.0)
    return _untangled(even, first_map(even, part), part)


def _untangled(
    problem: SeamlessProblem, x: np.ndarray, progress: Progress
) -> tuple[np.ndarray, np.ndarray]:
    """As `injective_map`, from a first map x (unknowns,)."""
    progress.step(0.4)
    flipped = _flipped(problem, x, 0.0)
    if np.count_nonzero(flipped) > HOPELESS * len(flipped):
        return x, flipped
    x = _stiffened(problem, x, progress)
    progress.step(0.6)
    rings, least, idle = FIRST_RINGS, len(problem.weight), 0
    while rings <= MOST_RINGS and idle < PATIENCE:
        flipped = _flipped(problem, x)
        count = int(np.count_nonzero(flipped))
        if not count:
            break
        idle = 0 if count < least else idle + 1
        least = min(count, least)
        x = _newton(problem, x, with_rings(problem.crosses.triangles, flipped, rings), progress)
        progress.step(0.6 + 0.4 * rings / MOST_RINGS)
        rings = int(rings * RING_GROWTH)
    flipped = _flipped(problem, x, 0.0)
    flipped[problem.wound_wrongly(x)] = True
    return x, flipped


def _flipped(problem: SeamlessProblem, x: np.ndarray, least: float = FLIPPED) -> np.ndarray:
    """(n,) bool corners of triangles with less determinant."""
    found = np.zeros(len(problem.crosses.vertices), bool)
    wrong = determinant(problem.jacobian(x)) <= least
    found[problem.crosses.triangles[wrong]] = True
    return found


def _region(
    problem: SeamlessProblem, inside: np.ndarray
) -> tuple[sparse.csr_array, np.ndarray]:
    """The basis of the unknowns all of whose vertices are inside, and the triangles with any."""
    moves = problem.owner @ (~inside).astype(float) == 0.0
    triangles = np.flatnonzero(moves[problem.unknown].any(axis=1))
    return problem.basis(np.flatnonzero(moves)), triangles


def _stiffened(problem: SeamlessProblem, x: np.ndarray, progress: Progress) -> np.ndarray:
    """Folded fans of poles, and fans with wrong turns, pulled nearer to their directions."""
    crosses = problem.crosses
    boost = np.ones(len(crosses.triangles))
    target = problem.target.copy()
    best, least = x, (np.inf, np.inf)
    for attempt in range(STIFFENINGS + 1):
        progress.ask()
        flipped, wound = _flipped(problem, x), problem.wound_wrongly(x)
        # Flips can be undone later, wrong turns hardly; targets that contradict make more of both.
        found = float(len(wound)), float(np.count_nonzero(flipped))
        if found < least:
            best, least = x, found
        bad = flipped & crosses.singular
        bad[wound] = True
        if attempt == STIFFENINGS or not bad.any():
            break
        first = bad[crosses.triangles].any(axis=1)
        second = with_rings(crosses.triangles, bad, 1)[crosses.triangles].any(axis=1)
        boost[first] *= STIFFER
        boost[second & ~first] *= STIFFER_AROUND
        fan, opened = cone_targets(
            crosses, problem.seams, np.flatnonzero(bad & ~crosses.on_feature)
        )
        target[fan] = opened
        moving = with_rings(crosses.triangles, bad, STIFFENED_RINGS)
        basis, triangles = _region(problem, moving)
        weight = np.maximum(problem.weight, LEAST_STIFFENED) * boost
        x = least_squares(problem, weight, x, basis, triangles, target)
    return best


def _newton(
    problem: SeamlessProblem, x: np.ndarray, inside: np.ndarray, progress: Progress
) -> np.ndarray:
    """x after steps of Newton's method on what lies inside (n,) bool."""
    basis, triangles = _region(problem, inside)
    if not basis.shape[1]:
        return x
    unknown, derivative = problem.unknown[triangles], problem.derivative[triangles]
    weight = problem.weight[triangles]
    weight = np.maximum(weight / weight.mean(), LEAST_WEIGHT)
    # Fans at poles never flip back once they are right: they could unfold to the wrong turns.
    guarded = problem.crosses.singular[problem.crosses.triangles[triangles]].any(axis=1)
    jacobian = np.einsum("tij,tj->ti", derivative, x[unknown])
    det = determinant(jacobian)
    for _ in range(STEPS):
        progress.step(0.8)
        least = det.min()
        if least > CONTENT:
            break
        width = _width(least)
        value, slope, hessian = _derivatives(jacobian, det, width, weight)
        form = np.einsum("tia,tij,tjb->tab", derivative, hessian, derivative, optimize=True)
        right = -np.einsum("tia,ti->ta", derivative, slope)
        step = least_step(basis, unknown, form, right)
        promised = -(right * step[unknown]).sum()
        change = np.einsum("tij,tj->ti", derivative, step[unknown])
        length = 1.0
        while length > LEAST_STEP:
            trial = jacobian + length * change
            det_trial = determinant(trial)
            fine = _energy(trial, det_trial, width, weight) < value + ARMIJO * length * promised
            fine &= not (least > 0 and det_trial.min() <= KEEP * least)
            if fine and not (guarded & (det > 0) & (det_trial <= KEEP_GUARDED * det)).any():
                break
            length *= 0.5
        else:
            break
        x = x + length * step
        jacobian, det = trial, det_trial
    return x


def _width(least: float) -> float:
    """How softly the determinant is regularized, from the least one there is."""
    if least > 0:
        return SHARP
    # Far below 0 FLAT is nothing.
    return float(np.sqrt(FLAT + SOFT * least**2)) if least > -10 else 0.2 * abs(least)


def _regular(det: np.ndarray, width: float) -> tuple[np.ndarray, np.ndarray]:
    """The regularized determinant, positive everywhere, and the root in it."""
    root = np.sqrt(width**2 + det**2)
    # The second form is the first without cancellation.
    tiny = np.finfo(float).tiny
    chi = np.where(det > 0, 0.5 * (det + root), 0.5 * width**2 / np.maximum(root - det, tiny))
    return np.maximum(chi, tiny), root


def _energy(jacobian: np.ndarray, det: np.ndarray, width: float, weight: np.ndarray) -> float:
    chi, _ = _regular(det, width)
    shape = 0.5 * (jacobian**2).sum(axis=1)
    return float((weight * (shape + 0.5 * (1.0 + det**2)) / chi).sum())


def _derivatives(
    jacobian: np.ndarray, det: np.ndarray, width: float, weight: np.ndarray
) -> tuple[float, np.ndarray, np.ndarray]:
    """The energy, its gradient (t, 4) and its Hessian (t, 4, 4), made definite, by triangle."""
    chi, root = _regular(det, width)
    first, second = chi / root, 0.5 * width**2 / root**3
    inverse = 1.0 / chi
    inverse1 = -first / chi**2
    inverse2 = 2.0 * first**2 / chi**3 - second / chi**2
    shape = 0.5 * (jacobian**2).sum(axis=1)
    size = 0.5 * (1.0 + det**2)
    # By the determinant: of the shape's quotient and of the size's.
    by_det = shape * inverse1 + det * inverse + size * inverse1
    by_det2 = shape * inverse2 + inverse + 2.0 * det * inverse1 + size * inverse2
    cofactor = jacobian @ _SWAP
    slope = inverse[:, None] * jacobian + by_det[:, None] * cofactor
    mixed = jacobian[:, :, None] * cofactor[:, None, :]
    hessian = (
        inverse[:, None, None] * np.eye(4)
        + inverse1[:, None, None] * (mixed + mixed.transpose(0, 2, 1))
        + by_det2[:, None, None] * cofactor[:, :, None] * cofactor[:, None, :]
        + by_det[:, None, None] * _SWAP
    )
    values, vectors = np.linalg.eigh(hessian)
    values = np.maximum(values, DEFINITE * np.abs(values).max(axis=1, keepdims=True) + LEAST_CURVED)
    hessian = np.einsum("tij,tj,tkj->tik", vectors, values, vectors)
    value = float((weight * (shape + size) * inverse).sum())
    return value, weight[:, None] * slope, weight[:, None, None] * hessian
