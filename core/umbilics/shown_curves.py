"""Curves of umbilics that are none: a finer fit shows umbilics on them that are no part of one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..base.progress import Progress
from ..curvature.estimate import Estimate
from ..curvature.tolerances import EDGE_BEND
from ..mesh.surface import Surface
from .judged import CERTAIN
from .methods.raw import RawUmbilics
from .pairing.persistence import significant
from .refine import Refined, refine
from .regions.region_map import RegionMap, without


def without_shown(
    surface: Surface,
    fitted: Estimate,
    raw: RawUmbilics,
    regions: RegionMap,
    progress: Progress,
) -> RegionMap:
    """The regions but for curves on which a finer fit shows each of the raw umbilics, or one that
    is isolated beyond doubt.

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
        dropped[label[on_curve[agrees & _isolated(places)]]] = True
    if not dropped.any():
        return regions
    left = without(regions, dropped)
    curves = regions.curves - int(dropped.sum())
    return replace(regions, label=left.label, count=left.count, curves=curves)


def _isolated(places: Refined) -> np.ndarray:
    """(k,) bool, places that cannot lie on a curve of umbilics.

    Along a curve the linear part p z + q conj(z) of the deviator vanishes, so that |p| = |q|. Here
    these differ by more than errors make them and, where errors are next to nothing, by more than
    linear interpolation leaves out. On the curves that r = 2 + cos z and eight random bodies of
    revolution show, clean, noisy or decimated, it is 3.3 errors at most, where this asks for 4.6 or
    more; at an umbilic in a valley that drowned (seed 800 of benchmarks.people, decimated) 28.
    """
    p, q = np.abs(places.p), np.abs(places.q)
    apart, error = np.abs(p - q), np.sqrt(2.0) * places.slope_error
    level = significant(len(p), CERTAIN)
    return (apart > level * error) & (apart > EDGE_BEND * (p + q))
