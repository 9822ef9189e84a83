"""The settings of a detection: the one definition that every front end reads."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

from .errors import InvalidSettingsError
from .options import AUTO, Choice, Option, check, setting


@dataclass(frozen=True)
class Settings:
    """What to detect and how; validated on construction.

    Raises
    ------
    InvalidSettingsError
        A value is of the wrong type, out of bounds or not among the choices.
    """

    method: str = setting(
        "S",
        label="Method",
        help="How umbilics are found",
        kind="choice",
        choices=(
            Choice("S", "Shape operators", "Interpolate shape operators inside each triangle"),
            Choice("I", "Index", "Turn of the principal directions around each vertex"),
            Choice(
                "C",
                "Curvature tensor",
                "Interpolate the curvature tensor over a conformal unfolding",
            ),
        ),
    )
    parametrization: str = setting(
        "conformal",
        label="Parametrization",
        help="Coordinates in which shape operators are interpolated in a triangle (method S)",
        kind="choice",
        choices=(
            Choice("conformal", "Conformal", "Rotate the tangent plane into the triangle"),
            Choice("projection", "Projection", "Project the tangent plane along the normal"),
            Choice("uv", "UV map", "Use the coordinates of the active UV map, however it is bent"),
            Choice("charts", "Charts", "Use the charts that method C unfolds"),
        ),
    )
    triangles: str = setting(
        "certified",
        label="Triangles",
        help="Which triangles hold an umbilic (method S)",
        kind="choice",
        choices=(
            Choice(
                "certified",
                "Certified",
                "Those that the directions turn around, told alike by neighbours: the indices sum "
                "to the Euler characteristic",
            ),
            Choice(
                "published",
                "As published",
                "Those in which the interpolated operator vanishes, each triangle for itself: on "
                "rough meshes some are missed and some found twice",
            ),
        ),
    )
    charts: str = setting(
        "automatic",
        label="Charts",
        help="What cuts the mesh into the pieces that method C unfolds",
        kind="choice",
        choices=(
            Choice(
                "automatic",
                "Automatic",
                "Unfold the pieces between marked seams, cut further where they are no disks or "
                "where a tip would be squeezed",
            ),
            Choice("seams", "Seams", "Unfold the pieces between marked seams"),
            Choice("islands", "UV islands", "Unfold the islands of the active UV map anew"),
            Choice("uv", "UV map", "Use the active UV map as it is"),
        ),
    )
    curvature: str = setting(
        "jets",
        label="Curvature",
        help="Where the shape operators at the vertices come from",
        kind="choice",
        choices=(
            Choice("jets", "Jets", "Fit a cubic height function around each vertex"),
            Choice("normals", "Normals", "Differences of vertex normals across each face"),
            Choice("given", "Attributes", "Read them from the mesh's own attributes"),
        ),
    )
    scale: float | str = setting(
        AUTO,
        label="Scale",
        help="Radius of the fitted neighbourhood; automatic grows it where there is noise",
        kind="number",
        minimum=0.0,
        automatic=True,
        manual=2.0,
    )
    scale_unit: str = setting(
        "rings",
        label="Scale Unit",
        help="What the scale is measured in",
        kind="choice",
        choices=(
            Choice("rings", "Rings", "Rings of neighbouring vertices"),
            Choice("length", "Length", "Scene units"),
        ),
    )
    crease_angle: float | str = setting(
        AUTO,
        label="Crease Angle",
        help="Edges sharper than this are not fitted across; 180 fits across all edges, automatic "
        "too unless the mesh is a tessellated part, whose creases its angles tell",
        kind="number",
        minimum=0.0,
        maximum=180.0,
        automatic=True,
        manual=30.0,
        unit="degrees",
    )
    crease_marks: bool = setting(
        True,
        label="Sharp Edges",
        help="Edges marked sharp are not fitted across; ignored where more than a fifth of all "
        "edges are marked, as some importers leave them",
        kind="flag",
    )
    join_borders: bool = setting(
        True,
        label="Join Borders",
        help="Borders that lie on each other, as exporters leave them at UV seams, are joined for "
        "the analysis, and vertices on a border edge inserted there; the mesh stays as it is",
        kind="flag",
    )
    normal_smoothing: int = setting(
        0,
        label="Normal Smoothing",
        help="Passes of a linear filter over the vertex normals before shape operators are "
        "taken from them",
        kind="count",
        minimum=0,
        maximum=1000,
    )
    normal_filter: str = setting(
        "mean",
        label="Normal Filter",
        help="What a pass of the normal smoothing does at each vertex",
        kind="choice",
        choices=(
            Choice("mean", "Mean", "Average the normals around the vertex"),
            Choice("fit", "Linear Fit", "Fit normals that change linearly to those around it"),
        ),
    )
    opening: int = setting(
        0,
        label="Opening",
        help="Erosions, then dilations, of the elliptic part; umbilics outside it are dropped. "
        "0 is off, 2 is the usual strength",
        kind="count",
        minimum=0,
        maximum=100,
    )
    flatness: float = setting(
        0.01,
        label="Flatness",
        help="Curvatures below this fraction of the mesh's typical curvature count as zero "
        "when surface types are told apart",
        kind="number",
        minimum=0.0,
        maximum=1.0,
    )
    persistence: float | str = setting(
        AUTO,
        label="Persistence",
        help="Umbilics that cancel below this gap of the principal curvatures are dropped in "
        "pairs; automatic takes it from the noise, 0 keeps all",
        kind="number",
        minimum=0.0,
        automatic=True,
        manual=0.0,
        unit="1 / length",
    )
    at_most: int = setting(
        0,
        label="At Most",
        help="Only so many of the umbilics that are left, the most important ones: those that lie "
        "farthest above the error of the fits before they cancel. Pairs come and go together; 0 "
        "keeps all",
        kind="count",
        minimum=0,
        maximum=1_000_000,
    )
    regions: bool = setting(
        True,
        label="Regions",
        help="Report spherical and flat areas as one region each instead of many points",
        kind="flag",
    )

    merge: bool = setting(
        True,
        label="Merge",
        help="Umbilics that their errors do not tell from each other are one, with the sum of "
        "their indices; method I reports each cluster of vertices once. Off to see the parts",
        kind="flag",
    )

    @property
    def unfolds(self) -> bool:
        """Whether the mesh is laid into the plane by its charts."""
        return self.method == "C" or (self.method == "S" and self.parametrization == "charts")

    @property
    def certified(self) -> bool:
        """Whether the indices that are found balance over the surface."""
        return self.method == "S" and self.triangles == "certified"

    def __post_init__(self) -> None:
        check(self)
        if self.normal_smoothing and self.curvature == "given":
            raise InvalidSettingsError(
                "Normal smoothing needs shape operators from jets or normals, not given ones."
            )


def options(of: type = Settings) -> dict[str, Option]:
    """The option of every setting, by the setting's name, in the order they are shown.

    Examples
    --------
    >>> core.options()["method"].label
    'Method'
    """
    return {item.name: item.metadata["option"] for item in dataclasses.fields(of)}


def defaults(of: type = Settings) -> dict[str, Any]:
    """The default of every setting, by name.

    Examples
    --------
    >>> core.defaults()["method"]
    'S'
    """
    return {item.name: item.default for item in dataclasses.fields(of)}
