"""Where the error of the curvatures is above their difference: nothing can be found there."""

from __future__ import annotations

import numpy as np

from ...curvature.tolerances import DROWNED_SIZE, REGION_BEND, UNRESOLVED
from ...mesh.surface import Surface
from .region_map import connected, largest_disc


def drowned_share(
    surface: Surface, gap: np.ndarray, noise: np.ndarray, radius: np.ndarray, known: np.ndarray
) -> float:
    """Share of the surface in areas, each as wide as a fit, in which the gap nowhere rises above
    what its errors alone may reach.

    Around an umbilic that stands out of the noise the gap does so within much less than a fit. A
    sphere or plane is no such area: there it is known that the gap is nothing.

    Parameters
    ----------
    gap, noise, radius:
        (n,) k1 - k2, its standard error and the radius of the fits, as for `find_regions`.
    known:
        (m,) bool, triangles of regions and of exact faces.
    """
    with np.errstate(invalid="ignore"):
        low = gap <= UNRESOLVED * noise
        # What is as large as the bend of the surface over the fit is no error of a smooth surface.
        low &= noise * radius <= REGION_BEND
    a, b, c = surface.at_corners(low)
    within = a & b & c & ~known
    if not within.any():
        return 0.0
    _, area = surface.face_normal_area
    label, count = connected(surface, within)
    size = np.bincount(label[within], weights=area[within], minlength=count)
    drowned = size >= DROWNED_SIZE * largest_disc(surface, radius, label, count)
    total = float(area.sum())
    return float(size[drowned].sum()) / total if total > 0.0 else 0.0


def drowned_words(share: float) -> str:
    """The sentence for the user."""
    said = f"{100.0 * share:.0f} %" if share >= 0.01 else "less than 1 %"
    return (
        f"On {said} of the surface the two curvatures differ by no more than their error: umbilics "
        "are missed there, or stand where the noise has them. A larger scale or a less noisy mesh "
        "tells more."
    )
