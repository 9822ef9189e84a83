"""What is said of a topology: of the quads that were made, or of a mesh that was checked."""

from __future__ import annotations

from typing import Any

import numpy as np

from ... import core
from ..base.words import topology_in_words


def of_quads(
    made: core.QuadMesh, check: core.TopologyCheck, settings: core.RemeshSettings
) -> dict[str, Any]:
    """What the report says of a mesh that was remeshed."""
    by_number = settings.edge_length == core.AUTO
    return {
        "asked": settings.quads if by_number else None,
        "vertices": len(made.vertices),
        "patches": len(np.unique(made.patch)),
        **figures(check),
        "warnings": list(made.warnings),
        "timings": made.timings,
    }


def figures(check: core.TopologyCheck) -> dict[str, Any]:
    """How well a mesh follows surface and plan, in numbers; lengths as in the file."""
    jacobian = check.jacobian[np.isfinite(check.jacobian)]
    return {
        "faces": len(check.angle),
        "quads": check.quads,
        "irregular": len(check.irregular),
        "matched": check.matched,
        "missing": len(check.missing),
        "extra": check.extra,
        "angle": check.mean_angle,
        "jacobian": {
            "least": check.least_jacobian,
            "mean": float(jacobian.mean()) if len(jacobian) else None,
        },
        "distance": {
            "mean": float(check.distance.mean()) if len(check.distance) else None,
            "largest": float(check.distance.max(initial=0.0)),
        },
        "edge": check.edge,
    }


def in_words(check: core.TopologyCheck) -> str:
    """The same in a sentence."""
    lines = topology_in_words(
        matched=check.matched,
        missing=len(check.missing),
        extra=check.extra,
        faces=len(check.angle),
        quads=check.quads,
        angle=check.mean_angle,
        jacobian=check.least_jacobian,
        edges=check.edges_away,
    )
    return f"{'; '.join(lines)}."
