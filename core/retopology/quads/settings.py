"""The settings of the remeshing to quads, written once for every front end, like `Settings`."""

from __future__ import annotations

from dataclasses import dataclass

from ...base.options import AUTO, Choice, check, setting
from .. import field_settings


@dataclass(frozen=True)
class RemeshSettings:
    """How to turn a surface into quads; validated on construction.

    Raises
    ------
    InvalidSettingsError
        A value is of the wrong type, out of bounds or not among the choices.
    """

    quads: int = setting(
        2000,
        label="Quads",
        help="How many quads are wanted; the result comes close",
        kind="count",
        minimum=8,
        maximum=1_000_000,
    )
    edge_length: float | str = setting(
        AUTO,
        label="Edge Length",
        help="Length of the quads' edges; automatic takes it from the number of quads",
        kind="number",
        minimum=0.0,
        automatic=True,
        manual=0.1,
        unit="length",
    )
    smoothness: float = field_settings.smoothness()
    feature_angle: float = field_settings.feature_angle()
    align_sharp: bool = field_settings.align_sharp()
    adaptivity: float = setting(
        0.0,
        label="Adaptivity",
        help="0 makes quads of one size, 1 much smaller ones where the surface bends",
        kind="number",
        minimum=0.0,
        maximum=1.0,
    )
    symmetry: str = setting(
        "none",
        label="Symmetry",
        help="A plane that the quads are mirrored at exactly",
        kind="choice",
        choices=(
            Choice("none", "None", "Not mirrored"),
            Choice("auto", "Found", "The surface's own mirror plane, where it has one"),
            Choice("x", "X", "The plane across X through the origin"),
            Choice("y", "Y", "The plane across Y through the origin"),
            Choice("z", "Z", "The plane across Z through the origin"),
        ),
    )
    mirror_single: bool = setting(
        False,
        label="Mirror Single Pieces",
        help="Separate pieces on one side of the plane with nothing alike on the other, such as a "
        "sword in one hand, get an image there; otherwise they stay as they are",
        kind="flag",
    )
    relaxation: int = setting(
        40,
        label="Relaxation",
        help="Steps in which the quads are evened out and turned to the curvature on the surface",
        kind="count",
        minimum=0,
        maximum=1000,
    )

    def __post_init__(self) -> None:
        check(self)
