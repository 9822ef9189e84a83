"""How far the normal turns across a ridge, from the curvature there and its second derivative."""

from __future__ import annotations

import numpy as np

# A normal that would turn farther than this, in degrees, before the curvature falls to zero is that
# of a tube, not of a crest: an ellipse comes here at axes of 1.12 to 1.
ROUND = 145.0


def bend_of(curvature: np.ndarray, bending: np.ndarray) -> np.ndarray:
    """Degrees that the normal turns across a ridge, at most `ROUND`.

    Of the parabola with this curvature and second derivative of it, as far as it is positive.
    """
    size = np.abs(curvature)
    with np.errstate(over="ignore"):
        half_width = np.sqrt(2.0 * size / np.maximum(np.abs(bending), np.finfo(float).tiny))
        return np.minimum(np.degrees(4.0 / 3.0 * size * half_width), ROUND)


def bending_of(curvature: np.ndarray, bend: float) -> np.ndarray:
    """Second derivative of the curvature across a ridge over which the normal turns by `bend`."""
    return np.asarray(2.0 * (4.0 / 3.0 / np.radians(bend)) ** 2 * np.abs(curvature) ** 3)
