"""The settings of the guidance in the scene, and what the panel shows of a plan."""

import json
import math
from dataclasses import asdict, dataclass
from hashlib import blake2b
from typing import Any

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from ... import core
from ..base import caches, property_groups
from ..base.changes import notify
from ..mesh.fingerprint import Fingerprint
from ..mesh.scope import Scope, scope_in_file
from .properties import annotations_of, values_of

# On the empty of a pole: its row in the table.
ROW_TAG = "umbilics_pole"
UNREADABLE = (
    "The plan cannot be read: another version of this add-on made it, or the file is damaged. "
    "Plan again."
)
# Kinds of objects that can hold guide strokes: Grease Pencil has two names, old and new.
STROKE_TYPES = ("CURVE", "GREASEPENCIL", "GPENCIL")
# Which settings each of the steps reads.
OF_PLAN = (
    "smoothness", "feature_angle", "align_sharp", "align_borders", "align_crests", "plan",
)  # fmt: skip
OF_LINES = ("families", "spacing", "closest", "line_smoothness", "shortest")
OF_SEPARATRICES = ("line_smoothness", "length_limit")
OF_RIDGES = ("least_bend", "ridge_kinds")


@dataclass(frozen=True)
class Origin:
    """All that a plan was made of.

    Attributes
    ----------
    fingerprint:
        Of what was read of the object.
    detecting, given_names:
        Settings of the detection behind it, and the names of given curvatures.
    scope:
        Which part of the object was planned on.
    settings:
        Those of the guidance.
    zone:
        Name of the vertex group that poles avoid, or nothing.
    kept:
        Digest of the umbilics that were kept, see `scene.filters.kept_digest`.
    strokes:
        Digest of the guide strokes, or nothing.
    """

    fingerprint: Fingerprint
    detecting: core.Settings
    given_names: tuple[str, ...]
    scope: Scope
    settings: core.GuidanceSettings
    zone: str
    kept: str
    strokes: str = ""

    def to_text(self) -> str:
        values = vars(self) | {"fingerprint": self.fingerprint.to_text()}
        return json.dumps(values, default=asdict)

    @classmethod
    def from_text(cls, text: str) -> "Origin | None":
        """What `to_text` has written; None for any other text."""
        try:
            values = json.loads(text)
            return cls(
                fingerprint=Fingerprint.from_text(values["fingerprint"]),
                detecting=core.Settings(**values["detecting"]),
                given_names=tuple(str(name) for name in values["given_names"]),
                scope=scope_in_file(str(values["scope"]["kind"]), str(values["scope"]["group"])),
                settings=core.GuidanceSettings(**values["settings"]),
                zone=str(values["zone"]),
                kept=str(values["kept"]),
                strokes=str(values.get("strokes", "")),
            )
        except (ValueError, TypeError, LookupError, RecursionError, core.InvalidSettingsError):
            return None


class UMBILICS_PG_guidance(bpy.types.PropertyGroup):
    """How to plan; one for each scene."""


UMBILICS_PG_guidance.__annotations__ = {
    **annotations_of(core.GuidanceSettings),
    **annotations_of(core.StrokeSettings),
    "zone": StringProperty(
        name="Avoid",
        description="Vertex group that poles keep out of, for example where the mesh deforms",
    ),
    "strokes": PointerProperty(
        type=bpy.types.Object,
        poll=lambda _, obj: obj.type in STROKE_TYPES,
        name="Guide Strokes",
        description="Curves or Grease Pencil strokes on the surface that the field of the next "
        "plan and the edges of the quads are to run along",
    ),
}


class UMBILICS_PG_pole(bpy.types.PropertyGroup):
    """One pole of the table; its name is that of its empty."""

    row: IntProperty(description="Row among the poles of the plan", default=-2)
    valence: IntProperty(description="Edges that should meet there")
    origin: StringProperty(description="The umbilic that it comes from")
    confidence: FloatProperty(description="How sure it is, 0 to 1")
    place: FloatVectorProperty(description="Where the plan put its empty", size=3)


def _pole_chosen(self: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    notify("pole", context)


class UMBILICS_PG_plan(bpy.types.PropertyGroup):
    """The pole plan of an object, in numbers."""

    planned: BoolProperty(description="The object has a plan")
    by_hand: BoolProperty(description="Its poles were moved, added or deleted by the user")
    warnings: StringProperty(description="What the plan could not hold, a sentence a line")
    stamp: StringProperty(description="Digest of what it was made of")
    origin: StringProperty(description="What it was made of, see data/plans.py")
    source: StringProperty(description="What was planned on: BASE or EVALUATED")
    poles: CollectionProperty(type=UMBILICS_PG_pole)
    active: IntProperty(
        name="Active Pole",
        description="Click to select the pole, double-click to bring it into view",
        default=-1,
        update=_pole_chosen,
    )
    closed: BoolProperty(description="The surface has no border, so that the sum is known")
    expected: IntProperty(description="What the sum of 4 - valence must be on a closed surface")
    mirror: StringProperty(description="The mirror plane that was found, in words")
    axis: StringProperty(description="The rotation axis that was found, in words")
    mesh: PointerProperty(
        type=bpy.types.Mesh, description="Holds the fields that the object's own mesh cannot hold"
    )


def to_guidance_settings(
    group: UMBILICS_PG_guidance,
    given: bpy.types.Operator | None = None,
    names: tuple[str, ...] = (),
) -> core.GuidanceSettings:
    """The core's settings with the values of the property group, but those of some `names` with
    the values that an operator was given.

    Raises
    ------
    core.InvalidSettingsError
        A value is out of bounds.
    """
    values = values_of(group, core.GuidanceSettings)
    if given is not None:
        values |= values_of(given, core.GuidanceSettings, names)
    return core.GuidanceSettings(**values)


def store(
    obj: bpy.types.Object,
    made_of: Origin,
    guidance: core.Guidance,
    empties: list[bpy.types.Object],
    origins: list[str],
    by_hand: bool,
) -> None:
    """Put a plan into the object's table, in place of an earlier one."""
    plan, poles = obj.umbilics_plan, guidance.poles
    plan.planned, plan.by_hand = True, by_hand
    plan.warnings = "\n".join(guidance.warnings)
    plan.origin = made_of.to_text()
    plan.stamp = blake2b(plan.origin.encode(), digest_size=16).hexdigest()
    plan.closed = math.isfinite(poles.expected)
    plan.expected = int(poles.expected) if plan.closed else 0
    plan.poles.clear()
    for row, empty in enumerate(empties):
        item = plan.poles.add()
        item.name = empty.name
        item.row = row
        empty[ROW_TAG] = row
        item.place = empty.location
        item.valence = int(poles.valence[row])
        item.origin = origins[row]
        item.confidence = float(poles.confidence[row])


def origin_of(obj: bpy.types.Object) -> Origin | None:
    """What the object's plan was made of; None without one, or where it cannot be read."""
    plan = obj.umbilics_plan
    return read_origin(plan.origin) if plan.planned else None


def read_origin(text: str) -> Any:
    """As `Origin.from_text`; a text is read once."""
    return caches.RECORDS.of(("plan", text), lambda: Origin.from_text(text))


def changed_settings(group: UMBILICS_PG_guidance, made: Origin) -> list[str]:
    """Labels of the settings that differ from those of a plan."""
    try:
        now = to_guidance_settings(group)
    except core.InvalidSettingsError:
        return []
    changed = [
        option.label
        for name, option in core.options(core.GuidanceSettings).items()
        if name in OF_PLAN and getattr(now, name) != getattr(made.settings, name)
    ]
    if group.zone != made.zone:
        changed.append(group.bl_rna.properties["zone"].name)
    return changed


def empty_of(pole: UMBILICS_PG_pole) -> Any:
    """The empty of a pole of the table, or None.

    It has the name that the table knows and is a child of the pole's object. In a copy of both it
    has another name, and is the child that stands for the same row.
    """
    obj = pole.id_data
    found = bpy.data.objects.get(pole.name)
    if found is not None and found.parent == obj:
        return found
    return next((child for child in obj.children if child.get(ROW_TAG, -1) == pole.row), None)


def index_of(obj: bpy.types.Object, empty: bpy.types.Object) -> int:
    """The place in the object's table of the pole that an empty stands for; -1 for none."""
    poles = obj.umbilics_plan.poles
    return next((place for place, pole in enumerate(poles) if empty_of(pole) == empty), -1)


def change_of(pole: UMBILICS_PG_pole) -> str:
    """What the user has done to a pole of the table: "deleted", "moved", "changed" (its valence)
    or nothing."""
    empty = empty_of(pole)
    if empty is None or not empty.users_scene:
        return "deleted"
    if empty.get("umbilics_valence") != pole.valence:
        return "changed"
    return "moved" if tuple(empty.location) != tuple(pole.place) else ""


def forget(obj: bpy.types.Object) -> bool:
    """Clear the object's plan; says whether there was one."""
    plan = obj.umbilics_plan
    was_there = plan.planned or bool(plan.mirror or plan.axis)
    obj.property_unset("umbilics_plan")
    return was_there


register, unregister = property_groups.factory(
    (UMBILICS_PG_guidance, UMBILICS_PG_pole, UMBILICS_PG_plan),
    (bpy.types.Scene, "umbilics_guidance", UMBILICS_PG_guidance),
    (bpy.types.Object, "umbilics_plan", UMBILICS_PG_plan),
)
