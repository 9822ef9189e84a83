"""Fits to all samples at once, as tests make them; the core sums its samples block by block."""

from __future__ import annotations

import numpy as np

from core.base.buffers import Workspace
from core.curvature.fits.height_fit import HeightFit, solve_heights, sum_count, sum_samples


def fit_heights(
    x: np.ndarray, y: np.ndarray, z: np.ndarray, weights: np.ndarray | None, degree: int
) -> HeightFit:
    """Fit z as a polynomial of the given degree (>= 2) to each column of samples (s, b).

    The parameters are those of `sum_samples`.
    """
    samples, fits = x.shape
    sums, workspace = np.empty((sum_count(degree), fits)), Workspace()
    sum_samples(x, y, z, weights, degree, sums, workspace)
    return solve_heights(sums, np.full(fits, samples), degree, workspace)
