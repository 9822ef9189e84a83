"""The settings as Blender properties, generated from the core's own list of them.

A setting that may be automatic becomes two properties: the switch `<name>_auto` and the
number `<name>`, which counts when the switch is off.
"""

import math
from collections.abc import Collection
from typing import Any

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty

from ... import core
from ..base import property_groups
from ..base.changes import notify

# Settings that act on results at once, without a new detection.
LIVE = ("persistence", "opening", "at_most")
# Where curvature "given" reads: two curvatures and two directions.
GIVEN_NAMES = ("k1", "k2", "d1", "d2")


class UMBILICS_PG_settings(bpy.types.PropertyGroup):
    """How to detect; one for each scene."""


def _filter_changed(self: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    notify("filter", context)


def _property(name: str, option: core.Option, default: Any) -> Any:
    text: dict[str, Any] = {"name": option.label, "description": option.help}
    if name in LIVE:
        text["update"] = _filter_changed
    if option.kind == "choice":
        items = [(choice.value, choice.label, choice.help) for choice in option.choices]
        return EnumProperty(items=items, default=default, **text)
    if option.kind == "flag":
        return BoolProperty(default=default, **text)
    if option.automatic and default == core.AUTO:
        default = option.manual
    if option.kind == "count":
        return IntProperty(
            default=default, min=int(option.minimum), max=int(option.maximum), **text
        )
    if option.unit == "degrees":
        return FloatProperty(
            default=math.radians(default),
            min=math.radians(option.minimum),
            max=math.radians(option.maximum),
            subtype="ANGLE",
            **text,
        )
    if option.unit == "length":
        text["subtype"] = "DISTANCE"
    bounds = {"min": option.minimum, "max": option.maximum}
    bounds = {name: bound for name, bound in bounds.items() if math.isfinite(bound)}
    return FloatProperty(default=default, precision=4, **bounds, **text)


def annotations_of(settings: type, names: Collection[str] | None = None) -> dict[str, Any]:
    """Blender properties for the options of a class of settings, all or those of some `names`."""
    made = {}
    for name, option in core.options(settings).items():
        if names is not None and name not in names:
            continue
        default = core.defaults(settings)[name]
        if option.automatic:
            made[f"{name}_auto"] = BoolProperty(
                name=f"Automatic {option.label}",
                description=option.help,
                default=default == core.AUTO,
                update=_filter_changed if name in LIVE else None,
            )
        made[name] = _property(name, option, default)
    return made


def _properties() -> dict[str, Any]:
    made = annotations_of(core.Settings)
    for name in GIVEN_NAMES:
        made[f"given_{name}"] = StringProperty(
            name=name,
            description=f"Vertex attribute that holds {name}",
            default=name,
        )
    return made


UMBILICS_PG_settings.__annotations__ = _properties()


def to_settings(group: UMBILICS_PG_settings) -> core.Settings:
    """The core's settings with the values of the property group.

    Raises
    ------
    core.InvalidSettingsError
        The values do not fit each other.
    """
    return core.Settings(**values_of(group, core.Settings))


def values_of(
    group: bpy.types.PropertyGroup | bpy.types.Operator,
    settings: type,
    names: Collection[str] | None = None,
) -> dict[str, Any]:
    """The values of a property group that `annotations_of` made, all or those of some `names`, as
    the core wants them."""
    values = {}
    for name, option in core.options(settings).items():
        if names is not None and name not in names:
            continue
        value = getattr(group, name)
        if option.automatic and getattr(group, f"{name}_auto"):
            value = core.AUTO
        elif isinstance(value, float):
            # Blender keeps single precision: 0.01 would come back as 0.00999999978, and 180°,
            # kept in radians, as 180.000005, which is out of bounds.
            value = math.degrees(value) if option.unit == "degrees" else value
            value = float(f"{value:.7g}")
        values[name] = value
    return values


def from_settings(group: UMBILICS_PG_settings, settings: core.Settings) -> None:
    """Set the property group to the values of `settings`."""
    for name, option in core.options().items():
        value = getattr(settings, name)
        if option.automatic:
            setattr(group, f"{name}_auto", value == core.AUTO)
            if value == core.AUTO:
                continue
        setattr(group, name, math.radians(value) if option.unit == "degrees" else value)


def given_names(group: UMBILICS_PG_settings) -> tuple[str, ...]:
    """Names of the attributes that hold k1, k2, d1 and d2."""
    return tuple(getattr(group, f"given_{name}").strip() for name in GIVEN_NAMES)


register, unregister = property_groups.factory(
    (UMBILICS_PG_settings,), (bpy.types.Scene, "umbilics", UMBILICS_PG_settings)
)
