"""One shape brought onto another by umbilics that are the same point of both."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base.blas import one_blas_thread
from ..base.errors import MatchError
from ..base.progress import Progress
from .closest_points import Fit, polished, refined
from .proposals import Similarity, matched, proposed, singly_proposed
from .shape import Shape

# Proposals that are refined a little, and those that are refined to the end; in so many steps at
# most, since one that wins nothing is the last.
REFINED, FINALISTS = 24, 4
SHORT, LONG = 5, 40
# Those of single umbilics, which are asked where pairs lead to nothing.
SINGLES = 48
# A proposal whose worth is so many times that of the best one after a few steps is dropped.
HOPELESS = 2.0
# Root mean square distance, in sizes, beyond which the shapes are not the same.
DIFFERENT = 0.006
# Standard deviations of the noise of both that are allowed beside it.
_NOISES = 3.0


@dataclass(frozen=True)
class Alignment:
    """A motion that brings one shape onto another.

    Attributes
    ----------
    matrix:
        (4, 4) of the motion in homogeneous coordinates.
    scale:
        Its factor of lengths; 1 for rigid motions.
    error:
        Root mean square distance between the shapes where they overlap, in the length of the
        other shape.
    overlap:
        Share of the shape's surface that lies on the other.
    rotation_error, shift_error:
        Standard errors of the motion about the middle of the overlap, in degrees and in length.
    score:
        0 to 1: the overlap, less where the error comes near what counts as another shape.
    pairs:
        (p, 2) rows of the umbilics of both shapes that meet.
    """

    matrix: np.ndarray
    scale: float
    error: float
    overlap: float
    rotation_error: float
    shift_error: float
    score: float
    pairs: np.ndarray


@one_blas_thread()
def align(
    one: Shape, other: Shape, progress: Progress | None = None, *, scaled: bool = False
) -> Alignment:
    """The motion of shape `one` onto `other`, which it may overlap in part.

    Parameters
    ----------
    one, other:
        From `Shape.of`.
    scaled:
        Whether their sizes may differ.

    Raises
    ------
    MatchError
        Too few umbilics, or no motion brings one onto the other.

    Examples
    --------
    An ellipsoid of `vertices` and `triangles`, as in `detect`, is brought onto itself elsewhere:

    >>> one, other = (
    ...     core.Shape.of(place, triangles, core.detect(place, triangles))
    ...     for place in (vertices, vertices + (1.0, 2.0, 3.0))
    ... )
    >>> found = core.align(one, other)
    >>> (found.matrix[:3, 3].round(3) + 0.0).tolist(), found.overlap
    ([1.0, 2.0, 3.0], 1.0)
    """
    fit = best_fit(one, other, progress or Progress(), scaled)
    alignment = _alignment(fit, one, other)
    if alignment.score <= 0.0:
        raise MatchError(
            "The shapes are not the same: the best motion leaves them "
            f"{100.0 * fit.error / other.size:.1f} % of the size apart over "
            f"{100.0 * fit.overlap:.0f} % of the surface."
        )
    return alignment


def best_fit(one: Shape, other: Shape, progress: Progress, scaled: bool) -> Fit:
    """The best fit over all proposals, whether or not it is a good one."""
    motions = proposed(one, other, scaled, REFINED)
    best = None
    if motions:
        part = progress.part("Matching pairs", 0.0, 0.5)
        best = finest(motions, one, other, scaled, part)
        if best is not None and best.error < limit(one, other, best.motion.scale):
            return best
    motions = singly_proposed(one, other, scaled, SINGLES)
    if motions:
        part = progress.part("Matching umbilics", 0.5, 1.0)
        fits = [fit for fit in (best, finest(motions, one, other, scaled, part)) if fit]
        best = min(fits, key=lambda fit: fit.worth, default=None)
    if best is None:
        raise MatchError(
            "Too few umbilics match to propose a motion. Lower the persistence to keep more, or "
            "take more of the shape."
        )
    return best


def finest(
    motions: list[Similarity], one: Shape, other: Shape, scaled: bool, progress: Progress
) -> Fit | None:
    """The best of the fits that the motions lead to; None where none leads to any."""
    rough = []
    for done, motion in enumerate(motions):
        progress.step(0.7 * done / len(motions))
        rough.append(refined(motion, one, other, scaled, SHORT, rough=True))
    ranked = sorted((fit for fit in rough if fit is not None), key=lambda fit: fit.worth)
    progress.step(0.7)
    finalists = [fit for fit in ranked[:FINALISTS] if fit.worth <= HOPELESS * ranked[0].worth]
    long = [refined(fit.motion, one, other, scaled, LONG) for fit in finalists]
    fits = [fit for fit in long if fit is not None]
    if not fits:
        return None
    best = min(fits, key=lambda fit: fit.worth)
    far = limit(one, other, best.motion.scale)
    # What is another shape needs no last digits.
    return best if best.error > 2.0 * far else polished(best, one, other, scaled, far)


def limit(one: Shape, other: Shape, scale: float = 1.0) -> float:
    """Root mean square distance, in the length of `other`, that shapes of their noise may have."""
    noise = float(np.hypot(np.nan_to_num(one.noise) * scale, np.nan_to_num(other.noise)))
    different = DIFFERENT * min(scale * one.size, other.size)
    # Noise that hides a shape does not make it alike.
    return float(np.hypot(different, min(_NOISES * noise, different)))


def _alignment(fit: Fit, one: Shape, other: Shape) -> Alignment:
    pairs, _ = matched(one, other, fit.motion)
    deviation = np.sqrt(np.diag(fit.equations.covariance(fit.equations.image)))
    score = fit.overlap * max(1.0 - fit.error / limit(one, other, fit.motion.scale), 0.0)
    return Alignment(
        matrix=fit.motion.matrix,
        scale=fit.motion.scale,
        error=fit.error,
        overlap=fit.overlap,
        rotation_error=float(np.degrees(np.linalg.norm(deviation[:3]))),
        shift_error=float(np.linalg.norm(deviation[3:6])),
        score=float(score),
        pairs=pairs,
    )
