"""Curves of umbilics that are none: a finer fit tells all of their umbilics from each other."""

from __future__ import annotations

import numpy as np

from ..base.progress import Progress
from ..curvature.estimate import Estimate
from ..mesh.surface import Surface
from .methods.raw import RawUmbilics
from .refine import refine
from .regions.region_map import RegionMap, without


def without_shown(
    surface: Surface,
    fitted: Estimate,
    raw: RawUmbilics,
    regions: RegionMap,
    progress: Progress,
) -> RegionMap:
    """The regions but for curves on which a finer fit shows each of the raw umbilics.

    Errors break a curve of umbilics into many pairs that come and go with the fit: on surfaces of
    revolution, clean, noisy, decimated or out of marching cubes, there are 32 and more of which a
    finer fit shows 11 to 87 %. A valley between umbilics that drowns in the error of the field
    holds these and no others: on three such (seeds 200, 300 and 400 of benchmarks.people) two to
    four, and all are shown.
    """
    dropped = np.zeros(regions.count, bool)
    if regions.curves and fitted.neighbourhood is not None:
        label = regions.label[raw.triangle]
        on_curve = np.flatnonzero(label >= regions.count - regions.curves)
        places = refine(
            surface, raw.triangle[on_curve], raw.barycentric[on_curve], fitted, progress
        )
        agrees = places.agrees(raw.index[on_curve])
        dropped[label[on_curve]] = True
        dropped[label[on_curve[~agrees]]] = False
    if not dropped.any():
        return regions
    left = without(regions, dropped)
    return RegionMap(left.label, left.count, regions.faces, regions.curves - int(dropped.sum()))
