"""Which of the candidates are kept: quick enough to run while a slider is dragged."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .detection import Detection
from .persistence import choose_level, survivors, trust_ratio
from .settings import AUTO, Settings

# Above this share of the median gap the cancelled pairs are as large as the signal, and the
# survivors may sit elsewhere than the surface's own umbilics (measured on noisy ellipsoids).
TRUSTED = 0.7
SMOOTH_MORE = (
    "The noise is as strong as the shape: the umbilics that are left may sit elsewhere than the "
    "surface has them. Smooth more: a larger scale, or smooth the mesh first."
)


def filtered(detection: Detection, settings: Settings) -> Detection:
    """The detection with its umbilics chosen anew by `settings.persistence` and the opening.

    Nothing is computed again: only the persistence level, and whether the opening is on, are
    read; another strength of the opening takes a new detection.
    """
    candidates = detection.candidates
    paired = ~np.isnan(candidates.persistence)
    level = 0.0
    if paired.any():
        level = (
            choose_level(candidates.persistence, candidates.partner, candidates.noise)
            if settings.persistence == AUTO
            else float(settings.persistence)
        )
    kept = survivors(candidates.persistence, level) | ~paired
    ratio = trust_ratio(candidates.persistence[paired], level, detection.curvature.gap)
    if settings.opening:
        kept &= candidates.elliptic
    kept &= ~candidates.at_border
    umbilics = candidates.select(kept)
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

