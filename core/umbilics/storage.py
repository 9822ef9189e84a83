"""A detection as bytes that can be put away with a mesh, and filtered again from there.

What is kept are the candidates, the numbers and the warnings. Values at vertices and triangles
are not: front ends store those as attributes of the mesh. Of the curvature only its median gap
comes back, which is all that `filtered` reads.

What is checked of the bytes is said where the candidates are, in the columns of `Umbilics`, and
in `_NUMBERS` here.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..base.rows import columns_of, decode, encode, is_number
from ..curvature.field import CurvatureField
from .result import KINDS, REGION_KINDS, Detection, Region, Umbilics

_COLUMNS = columns_of(Umbilics)
_LARGEST = 2.0**31 - 1.0
# Name and bounds of the numbers; each may be unknown (NaN) but for the counts.
_NUMBERS = {
    "euler_characteristic": (-_LARGEST, _LARGEST),
    "index_sum": (-_LARGEST, _LARGEST),
    "expected_index_sum": (-_LARGEST, _LARGEST),
    "persistence_level": (0.0, math.inf),
    "trust_ratio": (0.0, math.inf),
    "noise": (0.0, math.inf),
    "scale": (0.0, math.inf),
    "crease_angle": (0.0, 180.0),
}


def pack(detection: Detection) -> bytes:
    """The detection without its values at vertices and triangles; see `unpack`.

    Examples
    --------
    On an ellipsoid of `vertices` and `triangles`, as in `detect`:

    >>> detection = core.detect(vertices, triangles)
    >>> len(core.unpack(core.pack(detection)).umbilics)
    4
    """
    gap = detection.curvature.gap
    gap = gap[np.isfinite(gap)]
    text = {
        "numbers": {name: getattr(detection, name) for name in _NUMBERS},
        "borders_joined": int(detection.borders_joined),
        "warnings": list(detection.warnings),
        "timings": detection.timings,
        "median_gap": float(np.median(gap)) if len(gap) else 0.0,
        "regions": [
            (region.area, region.index, region.kind, region.curvature)
            for region in detection.regions
        ],
    }
    arrays = dict(vars(detection.candidates))
    codes = np.zeros(len(detection.candidates), np.int8)
    for code, kind in enumerate(KINDS):
        codes[arrays["kind"] == kind] = code
    return encode(_COLUMNS, arrays | {"kind": codes}, text)


def unpack(data: bytes) -> Detection:
    """The detection that `pack` put away; its umbilics are all candidates until `filtered`.

    Raises
    ------
    ValueError
        The bytes are not a detection of this version, or something in them cannot be.

    Examples
    --------
    Of an ellipsoid of `vertices` and `triangles`, as in `detect`:

    >>> data = core.pack(core.detect(vertices, triangles))
    >>> two = core.filtered(core.unpack(data), core.Settings(at_most=2))
    >>> len(two.candidates), len(two.umbilics)
    (4, 2)
    """
    text, arrays = decode(_COLUMNS, data)
    if (arrays["partner"] >= len(arrays["partner"])).any():
        raise ValueError("a partner is none of the candidates")
    _check(text)
    arrays["kind"] = np.array(KINDS)[arrays["kind"]]
    candidates = Umbilics(**arrays)
    none, zero = np.empty((0, 3)), np.zeros(1)
    median = np.array([float(text["median_gap"])])
    return Detection(
        umbilics=candidates,
        candidates=candidates,
        curvature=CurvatureField(median, zero, none, none, none, zero),
        regions=[Region(np.empty(0, np.int64), *region) for region in text["regions"]],
        triangle_index=np.empty(0),
        surface_type=np.empty(0, np.int8),
        conformal_scale=np.empty(0),
        borders_joined=bool(text["borders_joined"]),
        warnings=tuple(text["warnings"]),
        timings=text["timings"],
        **text["numbers"],
    )


def _check(text: Any) -> None:
    """Raise ValueError where what stands beside the candidates is not what `pack` writes."""
    try:
        numbers, warnings = text["numbers"], text["warnings"]
        timings, median, regions = text["timings"], text["median_gap"], text["regions"]
        well_formed = (
            set(numbers) == set(_NUMBERS)
            and all(is_number(numbers[name], *bounds) for name, bounds in _NUMBERS.items())
            and isinstance(numbers["euler_characteristic"], int)
            and isinstance(warnings, list)
            and all(isinstance(sentence, str) for sentence in warnings)
            and isinstance(timings, dict)
            and all(map(is_number, timings.values()))
            and is_number(median, 0.0)
            and is_number(text["borders_joined"], 0.0, 1.0)
            and isinstance(regions, list)
            and all(map(_is_region, regions))
        )
    except (LookupError, TypeError) as error:
        raise ValueError("numbers are missing") from error
    if not well_formed:
        raise ValueError("numbers are not what they must be")


def _is_region(region: Any) -> bool:
    area, index, kind, curvature = region if len(region) == 4 else (None,) * 4
    numbers = is_number(area, 0.0) and is_number(index, -_LARGEST, _LARGEST)
    return numbers and kind in REGION_KINDS and is_number(curvature)
