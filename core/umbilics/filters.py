"""Which of the candidates are kept: quick enough to run while a slider is dragged."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..base.options import AUTO
from ..base.settings import Settings
from ..base.words import counted
from .pairing.persistence import survivors
from .result import Detection, Umbilics

# Above this share of the median gap the noise is as large as the signal, and the umbilics that
# are left may sit elsewhere than the surface's own (measured on noisy ellipsoids).
TRUSTED = 0.7
SMOOTH_MORE = (
    "The noise is as strong as the shape: the umbilics that are left may sit elsewhere than the "
    "surface has them. Smooth more: a larger scale, or smooth the mesh first."
)
AT_BORDER = (
    "next to an open border left out: fits are one-sided there, and a border may have made them. "
    "Where the surface goes on beyond it (the other half of a mirrored model), analyse the whole."
)


@dataclass(frozen=True)
class Selection:
    """What the filters make of a detection, without the umbilics themselves.

    Attributes
    ----------
    rows:
        (k,) int64 rows of the candidates that are kept, in ascending order.
    index_sum, persistence_level, warnings:
        As in `Detection`.
    """

    rows: np.ndarray
    index_sum: float
    persistence_level: float
    warnings: tuple[str, ...]


def filtered(
    detection: Detection,
    settings: Settings,
    pinned: Sequence[int] = (),
    deleted: Sequence[int] = (),
) -> Detection:
    """The detection with its umbilics chosen anew, as `select` chooses them.

    Examples
    --------
    On an ellipsoid of `vertices` and `triangles`, as in `detect`:

    >>> detection = core.detect(vertices, triangles)
    >>> len(core.filtered(detection, core.Settings(at_most=2)).umbilics)
    2
    """
    chosen = select(detection, settings, pinned, deleted)
    return replace(
        detection,
        umbilics=detection.candidates.select(chosen.rows),
        index_sum=chosen.index_sum,
        persistence_level=chosen.persistence_level,
        warnings=chosen.warnings,
    )


def select(
    detection: Detection,
    settings: Settings,
    pinned: Sequence[int] = (),
    deleted: Sequence[int] = (),
) -> Selection:
    """Choose the umbilics anew by `settings.persistence`, the opening and `settings.at_most`.

    Nothing is computed again: only the persistence level, whether the opening is on, and how
    many are left at most, are read; another strength of the opening takes a new detection.
    `pinned` and `deleted` are as for `kept_rows`.

    Examples
    --------
    Of an ellipsoid of `vertices` and `triangles` that was detected on, as in `detect`:

    >>> detection = core.detect(vertices, triangles)
    >>> chosen = core.select(detection, core.Settings(persistence=0.0), deleted=[0])
    >>> len(detection.candidates) - len(chosen.rows)
    1
    """
    candidates = detection.candidates
    cancelled = _cancelled(candidates, settings)
    dropped = candidates.persistence[cancelled]
    if settings.persistence == AUTO:
        level = float(np.nextafter(dropped.max(), np.inf)) if len(dropped) else 0.0
    else:
        paired = not np.isnan(candidates.persistence).all()
        level = float(settings.persistence) if paired else 0.0
    rows = _kept(candidates, cancelled, settings, pinned, deleted)
    regions = sum(region.index for region in detection.regions)
    warnings = [
        text for text in detection.warnings if text != SMOOTH_MORE and not text.endswith(AT_BORDER)
    ]
    if detection.trust_ratio > TRUSTED and len(dropped):
        warnings.append(SMOOTH_MORE)
    left_out = candidates.at_border & ~cancelled
    if settings.opening:
        left_out &= candidates.elliptic
    left_out[rows] = False
    left_out[[row for row in deleted if 0 <= row < len(left_out)]] = False
    if left_out.any():
        number = counted(int(left_out.sum()), "candidate")
        warnings.append(f"{number} {AT_BORDER}")
    index_sum = float(candidates.index[rows].sum() + regions)
    return Selection(rows, index_sum, level, tuple(warnings))


def kept_rows(
    detection: Detection,
    settings: Settings,
    pinned: Sequence[int] = (),
    deleted: Sequence[int] = (),
) -> np.ndarray:
    """(k,) int64 rows of the candidates that `filtered` keeps, in ascending order.

    The rows in `pinned` are kept whatever the filters say, those in `deleted` never; rows that
    do not exist are ignored.

    Examples
    --------
    On an ellipsoid of `vertices` and `triangles`, as in `detect`:

    >>> detection = core.detect(vertices, triangles)
    >>> core.kept_rows(detection, core.Settings(), deleted=[0]).tolist()
    [1, 2, 3]
    """
    candidates = detection.candidates
    return _kept(candidates, _cancelled(candidates, settings), settings, pinned, deleted)


def _kept(
    candidates: Umbilics,
    cancelled: np.ndarray,
    settings: Settings,
    pinned: Sequence[int],
    deleted: Sequence[int],
) -> np.ndarray:
    kept = ~cancelled & ~candidates.at_border
    if settings.opening:
        kept &= candidates.elliptic
    if settings.at_most:
        kept[[row for row in deleted if 0 <= row < len(kept)]] = False
        kept = _most_important(candidates, kept, settings.at_most)
    for rows, value in ((pinned, True), (deleted, False)):
        kept[[row for row in rows if 0 <= row < len(kept)]] = value
    return np.flatnonzero(kept)


def _most_important(candidates: Umbilics, kept: np.ndarray, most: int) -> np.ndarray:
    """(k,) bool, at most so many of the `kept` (k,). Those that cancel together are of one
    importance: where only some of them would be left, none is."""
    rows = np.flatnonzero(kept)
    if len(rows) <= most:
        return kept
    value = candidates.importance[rows]
    order = np.argsort(-value, kind="stable")
    above = value > value[order[most]]
    left = np.zeros(len(kept), bool)
    left[rows[above] if above.any() else rows[order[:most]]] = True
    return left


def _cancelled(candidates: Umbilics, settings: Settings) -> np.ndarray:
    """(k,) bool, the pairs that `settings.persistence` drops; umbilics without one are kept."""
    persistence = candidates.persistence
    if settings.persistence == AUTO:
        return ~candidates.resolved & np.isfinite(persistence)
    return ~survivors(persistence, float(settings.persistence)) & ~np.isnan(persistence)
