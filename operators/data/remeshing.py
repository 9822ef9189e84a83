"""The settings of the remeshing in the scene: the core's own, and what becomes of the result."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import bpy

from ... import core
from ..base import property_groups
from .properties import annotations_of, values_of


@dataclass(frozen=True)
class Delivery:
    """What is done beside making the quads."""

    hide_original: bool = core.setting(
        True,
        label="Hide Original",
        help="Hide the mesh that the quads were made of, which lies in the same place, with its "
        "umbilics, poles and lines; Alt H shows them again",
        kind="flag",
    )
    shrinkwrap: bool = core.setting(
        False,
        label="Shrinkwrap",
        help="Give the quads a Shrinkwrap modifier onto the original, for editing them further",
        kind="flag",
    )
    transfer: bool = core.setting(
        False,
        label="Transfer Data",
        help="Carry materials, UV maps, vertex groups, colours and shape keys over from the "
        "original",
        kind="flag",
    )


def settings_properties() -> dict[str, Any]:
    """Blender properties for the core's settings alone."""
    return annotations_of(core.RemeshSettings)


def properties() -> dict[str, Any]:
    """Blender properties for all of it: the scene's group and the operator have the same."""
    return annotations_of(core.RemeshSettings) | annotations_of(Delivery)


class UMBILICS_PG_remesh(bpy.types.PropertyGroup):
    """How to remesh; one for each scene."""


UMBILICS_PG_remesh.__annotations__ = properties()


def idle(values: bpy.types.PropertyGroup | bpy.types.Operator) -> frozenset[str]:
    """Names of settings that change nothing as the others are: a length says how many quads, and
    without a plane nothing is mirrored."""
    counted = frozenset() if values.edge_length_auto else frozenset({"quads"})
    return counted | (frozenset({"mirror_single"}) if values.symmetry == "none" else frozenset())


def to_remesh_settings(values: bpy.types.PropertyGroup | bpy.types.Operator) -> core.RemeshSettings:
    """The core's settings with the values of the scene's group or of the operator.

    Raises
    ------
    core.InvalidSettingsError
        A value is out of bounds.
    """
    return core.RemeshSettings(**values_of(values, core.RemeshSettings))


def to_delivery(values: bpy.types.PropertyGroup | bpy.types.Operator) -> Delivery:
    """What becomes of the result, of the scene's group or of the operator."""
    return Delivery(**values_of(values, Delivery))


register, unregister = property_groups.factory(
    (UMBILICS_PG_remesh,), (bpy.types.Scene, "umbilics_remesh", UMBILICS_PG_remesh)
)
