"""Which of the candidates are kept: quick enough to run while a slider is dragged."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .detection import Detection, Umbilics
from .persistence import choose_level, survivors, trust_ratio
from .settings import AUTO, Settings

# Above this share of the median gap the cancelled pairs are as large as the signal, and the
# survivors may sit elsewhere than the surface's own umbilics (measured on noisy ellipsoids).
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
    paired = ~np.isnan(candidates.persistence)
    level = _level(candidates, settings)
    ratio = trust_ratio(candidates.persistence[paired], level, detection.curvature.gap)
    umbilics = candidates.select(kept_rows(detection, settings, pinned, deleted))
    warnings = [text for text in detection.warnings if text != SMOOTH_MORE]
    if ratio > TRUSTED:
        warnings.append(SMOOTH_MORE)
    return replace(
        detection,
        umbilics=umbilics,
        index_sum=float(umbilics.index.sum() + sum(region.index for region in detection.regions)),
        persistence_level=level,
        trust_ratio=ratio,
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
    paired = ~np.isnan(candidates.persistence)
    kept = survivors(candidates.persistence, _level(candidates, settings)) | ~paired
    if settings.opening:
        kept &= candidates.elliptic
    kept &= ~candidates.at_border
    for rows, value in ((pinned, True), (deleted, False)):
        kept[[row for row in rows if 0 <= row < len(kept)]] = value
    return np.flatnonzero(kept)


def _level(candidates: Umbilics, settings: Settings) -> float:
    """The persistence below which pairs are dropped, in 1 / length."""
    if settings.persistence != AUTO:
        return 0.0 if np.isnan(candidates.persistence).all() else float(settings.persistence)
    return choose_level(candidates.persistence, candidates.partner, candidates.noise)
