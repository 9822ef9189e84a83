"""A detection as bytes that can be put away with a mesh, and filtered again from there.

What is kept are the candidates, the numbers and the warnings. Values at vertices and triangles
are not: front ends store those as attributes of the mesh. Of the curvature only its median gap
comes back, which is all that `filtered` reads.
"""

from __future__ import annotations

import dataclasses
import io
import json
import zlib
from zipfile import BadZipFile

import numpy as np

from ..curvature.field import CurvatureField
from .result import KINDS, Detection, Region, Umbilics

_NUMBERS = (
    "euler_characteristic",
    "index_sum",
    "expected_index_sum",
    "persistence_level",
    "trust_ratio",
    "noise",
    "scale",
)


def pack(detection: Detection) -> bytes:
    """The detection without its values at vertices and triangles; see `unpack`."""
    gap = detection.curvature.gap
    gap = gap[np.isfinite(gap)]
    text = {
        "numbers": {name: getattr(detection, name) for name in _NUMBERS},
        "warnings": list(detection.warnings),
        "timings": detection.timings,
        "median_gap": float(np.median(gap)) if len(gap) else 0.0,
        "regions": [
            (region.area, region.index, region.kind, region.curvature)
            for region in detection.regions
        ],
    }
    arrays = dict(vars(detection.candidates))
    arrays["kind"] = np.array([KINDS.index(kind) for kind in arrays["kind"]], dtype=np.int8)
    target = io.BytesIO()
    np.savez_compressed(target, text=np.array(json.dumps(text, default=float)), **arrays)
    return target.getvalue()


def unpack(data: bytes) -> Detection:
    """The detection that `pack` put away; its umbilics are all candidates until `filtered`.

    Raises
    ------
    ValueError
        The bytes are not a detection of this version.
    """
    try:
        # No pickles: the bytes may come with a file from anywhere.
        with np.load(io.BytesIO(data), allow_pickle=False) as found:
            arrays = {item.name: found[item.name] for item in dataclasses.fields(Umbilics)}
            text = json.loads(str(found["text"]))
        arrays["kind"] = np.array(KINDS)[arrays["kind"]]
        candidates = Umbilics(**arrays)
        none = np.empty((0, 3))
        median = np.array([text["median_gap"]])
        zero = np.zeros(1)
        return Detection(
            umbilics=candidates,
            candidates=candidates,
            curvature=CurvatureField(median, zero, none, none, none, zero),
            regions=[Region(np.empty(0, np.int64), *region) for region in text["regions"]],
            triangle_index=np.empty(0),
            surface_type=np.empty(0, np.int8),
            conformal_scale=np.empty(0),
            warnings=tuple(text["warnings"]),
            timings=text["timings"],
            **{name: text["numbers"][name] for name in _NUMBERS},
        )
    except (OSError, EOFError, LookupError, TypeError, BadZipFile, zlib.error) as error:
        raise ValueError(f"not a detection of this version ({error})") from error
