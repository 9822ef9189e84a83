"""Fits over twice as many rings: whether what passes for noise at one scale does at the next."""

from __future__ import annotations

import dataclasses

import numpy as np

from ..base.progress import Progress
from ..mesh.surface import Surface
from .estimate import Estimate
from .fits.jets import fit_jets

# Rings over those of the field.
WIDER = 2
# Turn of the surface, in radians, over the root mean square distance of the samples, above which
# it is no height over its tangent plane.
MOST_TURN = 0.7


def can_widen(fitted: Estimate) -> bool:
    """Whether wider fits tell more: on clean meshes errors are bias, which grows."""
    around = fitted.neighbourhood
    return around is not None and not around.focused


def wider_ratio(
    surface: Surface, fitted: Estimate, vertices: np.ndarray, progress: Progress
) -> np.ndarray:
    """(v,) gap over its standard error at vertices by fits over `WIDER` times the rings; NaN where
    these reach around the surface or are not determined."""
    around = fitted.neighbourhood
    assert around is not None
    wide = dataclasses.replace(around, rings=WIDER * around.rings)
    jets = fit_jets(surface, fitted.field.normal, wide, progress, vertices)
    turn = jets.radius * np.maximum(np.abs(jets.k1), np.abs(jets.k2))
    known = jets.determined & (jets.noise > 0.0) & (turn <= MOST_TURN)
    error = np.where(known, fitted.factor * jets.noise, 1.0)
    return np.where(known, (jets.k1 - jets.k2) / error, np.nan)
