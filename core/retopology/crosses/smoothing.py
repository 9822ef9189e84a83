"""Over which length a field of directions is smoothed, and how far the curvature is believed."""

from __future__ import annotations

import numpy as np

from ...curvature.field import CurvatureField
from ...curvature.noise import field_noise
from ...fields.connection import weights_and_areas
from ...fields.transport import carried
from ...mesh.surface import Surface

# The gap over its standard error, and over the median gap, at which a direction counts half.
NOISE_RATIO = 4.0
WEAK_GAP = 0.15
# Smoothing lengths at the ends of the slider, in radii of the sphere of the same area.
SHORTEST, LONGEST = 0.003, 10.0
# A trace of the data everywhere keeps the system definite.
LEAST_CONFIDENCE = 1e-6
# Weight of a sure crest, in that of the edges around; it yields to what pulls there.
CREST_WEIGHT = 0.3
# What is held, as on hard features, outweighs what pulls at it from around by this much.
FIXED_WEIGHT = 100.0


def smoothing_length(surface: Surface, smoothness: float) -> float:
    """Length over which a field is smoothed, median over the vertices of the surface."""
    _, area = weights_and_areas(surface)
    return float(np.median(smoothing_lengths(surface, area, smoothness)))


def smoothness_of(surface: Surface, length: float) -> float:
    """The smoothness, 0 to 1, that smooths over a length: the inverse of `smoothing_length`."""
    shortest = smoothing_length(surface, 0.0)
    if length <= shortest:
        return 0.0
    return min(float(np.log(length / shortest) / np.log(LONGEST / SHORTEST)), 1.0)


def smoothing_lengths(surface: Surface, area: np.ndarray, smoothness: float) -> np.ndarray:
    """(n,) length over which a field is smoothed."""
    radius = np.sqrt(per_component(surface, area) / (4 * np.pi))[surface.component]
    return radius * SHORTEST * (LONGEST / SHORTEST) ** smoothness


def per_component(surface: Surface, values: np.ndarray) -> np.ndarray:
    """(components,) sums of values (n,) at the vertices of each connected component."""
    return np.bincount(surface.component, weights=values)


def curvature_data(
    surface: Surface,
    field: CurvatureField,
    normal: np.ndarray,
    axis: np.ndarray,
    undirected: np.ndarray | None,
    symmetry: int,
) -> tuple[np.ndarray, np.ndarray]:
    """(n,) confidence in the principal directions, and their powers `symmetry`."""
    gap, noise = field.gap, field.noise
    if not np.isfinite(noise).any():
        noise, _ = field_noise(surface, field.k1, field.k2, field.d1, field.normal)
    d1 = carried(field.d1, field.normal, normal)
    across = np.einsum("cn,nc->n", axis, d1)
    across = across / np.maximum(np.abs(across), 1e-12)
    known = np.isfinite(gap) & np.isfinite(across)
    typical = float(np.median(gap[known])) if known.any() else 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        doubt = (NOISE_RATIO * noise / gap) ** 2 + (WEAK_GAP * typical / gap) ** 2
        confidence = 1.0 / (1.0 + doubt)
    confidence = np.where(known & np.isfinite(confidence), confidence, 0.0)
    if undirected is not None and undirected.any():
        inside = np.ones(len(gap), bool)
        inside[surface.triangles[~undirected]] = False
        confidence[inside] = 0.0
    return confidence, np.where(known, across, 1.0) ** symmetry
