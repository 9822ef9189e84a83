"""The settings of the guidance: cross field, poles, lines, export and symmetry.

Written once, like `core.base.settings`: the Blender properties, the panel and the command line are
made from the `Option` of each field.
"""

from __future__ import annotations

from dataclasses import dataclass

from ..base.options import AUTO, Choice, check, setting
from . import field_settings


@dataclass(frozen=True)
class GuidanceSettings:
    """How to turn a detection into a plan for a quad mesh; validated on construction.

    Raises
    ------
    InvalidSettingsError
        A value is of the wrong type, out of bounds or not among the choices.
    """

    smoothness: float | str = field_settings.automatic_smoothness()
    feature_angle: float = field_settings.feature_angle()
    align_sharp: bool = field_settings.align_sharp()
    align_borders: bool = setting(
        True,
        label="Open Borders",
        help="The cross field runs along open borders",
        kind="flag",
    )
    align_crests: bool = setting(
        False,
        label="Crests",
        help="The cross field is drawn to long rounded crests and hollows too; it then has "
        "poles where they end",
        kind="flag",
    )
    plan: str = setting(
        "field",
        label="Poles",
        help="Which umbilics become poles",
        kind="choice",
        choices=(
            Choice(
                "field",
                "Of the Smoothed Field",
                "Two poles for each umbilic that the smoothed cross field still has; opposite "
                "umbilics that merge in it cancel",
            ),
            Choice(
                "umbilics",
                "Of Every Umbilic",
                "Two poles for every umbilic that was kept, whatever the smoothing",
            ),
        ),
    )
    spacing: float | str = setting(
        AUTO,
        label="Spacing",
        help="Distance between neighbouring lines; automatic takes a fraction of the size of "
        "the surface",
        kind="number",
        minimum=0.0,
        automatic=True,
        manual=0.1,
        unit="length",
    )
    closest: float = setting(
        0.6,
        label="Closest Approach",
        help="A line ends where it comes nearer to another than this fraction of the spacing",
        kind="number",
        minimum=0.1,
        maximum=0.95,
    )
    line_smoothness: float | str = setting(
        AUTO,
        label="Line Smoothness",
        help="0 draws lines and separatrices as they are; more smooths their directions first, "
        "for bumpy surfaces and scans; automatic goes by the noise of the directions, and is 0 "
        "on clean meshes",
        kind="number",
        minimum=0.0,
        maximum=1.0,
        automatic=True,
        manual=0.0,
    )
    families: str = setting(
        "both",
        label="Families",
        help="Which lines of curvature are drawn",
        kind="choice",
        choices=(
            Choice("both", "Both", "Lines of the larger and of the smaller curvature"),
            Choice("first", "Larger", "Lines of the larger principal curvature"),
            Choice("second", "Smaller", "Lines of the smaller principal curvature"),
        ),
    )
    shortest: float = setting(
        1.0,
        label="Shortest Line",
        help="Lines shorter than this many spacings are left out",
        kind="number",
        minimum=0.0,
        maximum=100.0,
    )
    length_limit: float | str = setting(
        AUTO,
        label="Length Limit",
        help="Separatrices end after this length; automatic takes four times the size of the "
        "surface, and cuts those off that wind in a spiral without end",
        kind="number",
        minimum=0.0,
        automatic=True,
        manual=1.0,
        unit="length",
    )

    least_bend: float = setting(
        15.0,
        label="Least Bend",
        help="Ridges across which the surface turns by less are left out; along a line the bend "
        "may fall to half of it",
        kind="number",
        minimum=0.0,
        maximum=180.0,
        unit="degrees",
    )
    ridge_kinds: str = setting(
        "crests",
        label="Ridges",
        help="Which lines are drawn where the curvature is extremal along its own lines",
        kind="choice",
        choices=(
            Choice("crests", "Crests", "Convex edges and hollows that show, rounded or sharp"),
            Choice(
                "all",
                "All",
                "Every extremum of either curvature, also where it is the smaller one or turns "
                "the other way; for clean meshes only",
            ),
        ),
    )

    def __post_init__(self) -> None:
        check(self)
