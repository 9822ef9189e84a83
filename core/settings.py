"""The settings of a detection: the one definition that every front end reads.

Each field carries an `Option` as metadata: label, help text, bounds and choices. The
Blender properties, the command line and the checks below are all made from it.
"""

from __future__ import annotations

import dataclasses
import math
import numbers
from dataclasses import dataclass, field
from typing import Any, Literal

from .errors import InvalidSettingsError

AUTO = "auto"


@dataclass(frozen=True)
class Choice:
    """One value that an option can take, as shown to the user."""

    value: str
    label: str
    help: str


@dataclass(frozen=True)
class Option:
    """How a setting is shown and checked.

    `kind` is "choice", "count" (a whole number), "number" or "flag". `automatic` says that
    the word "auto" is accepted besides a number; `manual` is the number a front end offers
    first when the user turns "auto" off.
    """

    label: str
    help: str
    kind: Literal["choice", "count", "number", "flag"]
    choices: tuple[Choice, ...] = ()
    minimum: float = -math.inf
    maximum: float = math.inf
    automatic: bool = False
    manual: float = 0.0
    unit: str = ""


def setting(default: Any, **option: Any) -> Any:
    """A field of a dataclass of settings, with its `Option` as metadata."""
    return field(default=default, metadata={"option": Option(**option)})


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
                "Interpolate the curvature tensor over a conformal unfolding (needs seams)",
            ),
        ),
    )
    parametrization: str = setting(
        "conformal",
        label="Parametrization",
        help="How a shape operator is laid into the plane of a triangle (method S)",
        kind="choice",
        choices=(
            Choice("conformal", "Conformal", "Rotate the tangent plane into the triangle"),
            Choice("projection", "Projection", "Project the tangent plane along the normal"),
        ),
    )
    charts: str = setting(
        "seams",
        label="Charts",
        help="What cuts the mesh into the pieces that method C unfolds",
        kind="choice",
        choices=(
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
    crease_angle: float = setting(
        180.0,
        label="Crease Angle",
        help="Edges sharper than this are not fitted across; 180 fits across all edges",
        kind="number",
        minimum=0.0,
        maximum=180.0,
        unit="degrees",
    )
    crease_marks: bool = setting(
        True,
        label="Sharp Edges",
        help="Edges marked sharp are not fitted across; ignored where more than a fifth of all "
        "edges are marked, as some importers leave them",
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
    regions: bool = setting(
        True,
        label="Regions",
        help="Report spherical and flat areas as one region each instead of many points",
        kind="flag",
    )

    def __post_init__(self) -> None:
        check(self)
        if self.normal_smoothing and self.curvature == "given":
            raise InvalidSettingsError(
                "Normal smoothing needs shape operators from jets or normals, not given ones."
            )


def options(of: type = Settings) -> dict[str, Option]:
    """The option of every setting, by the setting's name, in the order they are shown."""
    return {item.name: item.metadata["option"] for item in dataclasses.fields(of)}


def defaults(of: type = Settings) -> dict[str, Any]:
    """The default of every setting, by name."""
    return {item.name: item.default for item in dataclasses.fields(of)}


def check(settings: Any) -> None:
    """Raise `InvalidSettingsError` if a value does not suit its option."""
    for item in dataclasses.fields(settings):
        _check(item.name, getattr(settings, item.name), item.metadata["option"])


def _check(name: str, value: Any, option: Option) -> None:
    if option.kind == "choice":
        values = [choice.value for choice in option.choices]
        if value not in values:
            raise InvalidSettingsError(f"{name} must be one of {', '.join(values)}, not {value!r}.")
        return
    if option.kind == "flag":
        if not isinstance(value, bool):
            raise InvalidSettingsError(f"{name} must be True or False, not {value!r}.")
        return
    if option.automatic and isinstance(value, str) and value == AUTO:
        return
    number = numbers.Integral if option.kind == "count" else numbers.Real
    if isinstance(value, bool) or not isinstance(value, number) or not math.isfinite(value):
        wanted = "a whole number" if option.kind == "count" else "a number"
        auto = " or 'auto'" if option.automatic else ""
        raise InvalidSettingsError(f"{name} must be {wanted}{auto}, not {value!r}.")
    if not option.minimum <= value <= option.maximum:
        raise InvalidSettingsError(
            f"{name} must lie between {option.minimum:g} and {option.maximum:g}, not {value:g}."
        )
