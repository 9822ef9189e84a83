"""Options of the cross field that guidance and quads share, written once."""

from __future__ import annotations

from typing import Any

from ..base.options import AUTO, setting

# Smooths over one and a half edges of a mesh of 2,000 quads: detail finer than that no quads
# follow, and smoothing more only turns them from the curvature.
USUAL_SMOOTHNESS = 0.45


def smoothness() -> Any:
    """How smooth the field is, for a front end that asks for a number."""
    return setting(
        USUAL_SMOOTHNESS,
        label="Smoothness",
        help="0 follows the principal directions closely, 1 is as smooth as the surface, its "
        "creases and borders allow",
        kind="number",
        minimum=0.0,
        maximum=1.0,
    )


def automatic_smoothness() -> Any:
    """How smooth the field is, by itself or a number."""
    return setting(
        AUTO,
        label="Smoothness",
        help="0 follows the principal directions closely, 1 is as smooth as the surface, its "
        "creases and borders allow; automatic smooths over one and a half edges of a mesh of 2,000 "
        "quads, and less where that makes no more poles",
        kind="number",
        minimum=0.0,
        maximum=1.0,
        automatic=True,
        manual=USUAL_SMOOTHNESS,
    )


def feature_angle() -> Any:
    """From which angle on creases are followed."""
    return setting(
        40.0,
        label="Feature Angle",
        help="The cross field runs along creases sharper than this, where edges go on in a "
        "chain; 180 leaves creases alone",
        kind="number",
        minimum=0.0,
        maximum=180.0,
        unit="degrees",
    )


def align_sharp() -> Any:
    """Whether marked edges are followed."""
    return setting(
        True,
        label="Marked Sharp Edges",
        help="The cross field runs along edges that are marked sharp; ignored where more than a "
        "fifth of all edges are, as some importers leave them",
        kind="flag",
    )
