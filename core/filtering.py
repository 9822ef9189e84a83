"""Which of the candidates are kept: quick enough to run while a slider is dragged."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .detection import Detection, Umbilics
from .persistence import made_by_noise, survivors
from .settings import AUTO, Settings

# Above this share of the median gap the noise is as large as the signal, and the umbilics that
# are left may sit elsewhere than the surface's own (measured on noisy ellipsoids).
TRUSTED = 0.7
SMOOTH_MORE = (
    "The noise is as strong as the shape: the umbilics that are left may sit elsewhere than the "
    "surface has them. Smooth more: a larger scale, or smooth the mesh first."
)


def filtered(
    detection: Detection,
    settings: Settings,
    pinned: Sequence[int] = (),
    deleted: Sequence[int] = (),
) -> Detection:
    """The detection with its umbilics chosen anew by `settings.persistence` and the opening.

    Nothing is computed again: only the persistence level, and whether the opening is on, are
    read; another strength of the opening takes a new detection. `pinned` and `deleted` are as
    for `kept_rows`.
    """
    candidates = detection.candidates
    dropped = candidates.persistence[_cancelled(candidates, settings)]
    if settings.persistence == AUTO:
        level = float(np.nextafter(dropped.max(), np.inf)) if len(dropped) else 0.0
    else:
        paired = not np.isnan(candidates.persistence).all()
        level = float(settings.persistence) if paired else 0.0
    umbilics = candidates.select(kept_rows(detection, settings, pinned, deleted))
    warnings = [text for text in detection.warnings if text != SMOOTH_MORE]
    if detection.trust_ratio > TRUSTED and len(dropped):
        warnings.append(SMOOTH_MORE)
    return replace(
        detection,
        umbilics=umbilics,
        index_sum=float(umbilics.index.sum() + sum(region.index for region in detection.regions)),
        persistence_level=level,
        warnings=tuple(warnings),
    )


def kept_rows(
    detection: Detection,
    settings: Settings,
    pinned: Sequence[int] = (),
    deleted: Sequence[int] = (),
) -> np.ndarray:
    """(k,) rows of the candidates that `filtered` keeps, in ascending order.

    The rows in `pinned` are kept whatever the filters say, those in `deleted` never; rows that
    do not exist are ignored.
    """
    candidates = detection.candidates
    kept = ~_cancelled(candidates, settings)
    if settings.opening:
        kept &= candidates.elliptic
    kept &= ~candidates.at_border
    for rows, value in ((pinned, True), (deleted, False)):
        kept[[row for row in rows if 0 <= row < len(kept)]] = value
    return np.flatnonzero(kept)


def _cancelled(candidates: Umbilics, settings: Settings) -> np.ndarray:
    """(k,) bool, the pairs that `settings.persistence` drops; umbilics without one are kept."""
    persistence = candidates.persistence
    if settings.persistence == AUTO:
        return made_by_noise(persistence, candidates.partner, candidates.noise)
    return ~survivors(persistence, float(settings.persistence)) & ~np.isnan(persistence)
