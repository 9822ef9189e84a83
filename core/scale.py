"""The scale at which a surface is looked at: how far the jets reach, chosen from the noise.

A fit over few rings follows the noise, one over many smooths the surface away. Lepski's rule
(1991) takes the largest neighbourhood that still agrees with the smaller ones within their
noise: up to there only noise was averaged out, beyond it the surface's own shape is lost.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from .jets import Jets, fit_jets
from .neighbourhoods import Neighbourhood
from .progress import Progress
from .surface import Surface
from .tangent import frame

# Vertices that are fitted at every scale to choose one; medians over them are steady.
SAMPLED = 2000
# Disagreement of two neighbouring scales, in standard errors of the smaller one, that noise
# alone explains. On noisy ellipsoids and patches 1.2 picks the scale of least true error.
AGREEMENT = 1.2
# The standard error of k1 + k2 is less than that of the deviator by this factor: independent
# errors of variance v in S11, S22 and v / 2 in S12 give 2 v and 4 v.
MEAN_WEIGHT = 2**0.5
# Eight rings hold about 200 vertices; heavier noise than they average out hides the surface.
MOST_RINGS = 8
# Residuals below this share of the radius are round-off: there is no noise to average out.
ROUND_OFF = 1e-10


def choose(
    surface: Surface, normals: np.ndarray, neighbourhood: Neighbourhood, progress: Progress
) -> Neighbourhood:
    """The given neighbourhood with as many rings as the noise of the surface asks for."""
    interior = np.flatnonzero(~surface.border)
    if not len(interior):
        return neighbourhood
    centres = interior[:: max(len(interior) // SAMPLED, 1)]
    smaller: Jets | None = None
    for rings in range(2, MOST_RINGS + 1):
        candidate = dataclasses.replace(neighbourhood, rings=rings, focused=False)
        jets = fit_jets(surface, normals, candidate, progress, centres)
        if np.median(jets.residual) <= ROUND_OFF * np.median(jets.radius):
            break
        if smaller is not None and not _agree(smaller, jets, normals[centres]):
            break
        smaller, neighbourhood = jets, candidate
    focused = neighbourhood.rings == 2
    return dataclasses.replace(neighbourhood, focused=focused)


def _agree(smaller: Jets, larger: Jets, normals: np.ndarray) -> bool:
    both = smaller.determined & larger.determined
    if not both.any():
        return False
    e1, e2 = frame(normals.T)
    # The mean curvature too: on a sphere the deviator stays zero however far the fit reaches.
    change = np.maximum(
        np.abs(_deviator(smaller, e1, e2) - _deviator(larger, e1, e2)),
        MEAN_WEIGHT * np.abs(smaller.k1 + smaller.k2 - larger.k1 - larger.k2),
    )
    return bool(np.median(change[both]) <= AGREEMENT * np.median(smaller.noise[both]))


def _deviator(jets: Jets, e1: np.ndarray, e2: np.ndarray) -> np.ndarray:
    direction = np.einsum("nc,cn->n", jets.d1, e1) + 1j * np.einsum("nc,cn->n", jets.d1, e2)
    return (jets.k1 - jets.k2) * direction**2
