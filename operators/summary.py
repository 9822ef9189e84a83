"""What the panel shows of a detection, kept with the object in the file."""

import math

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from .. import core
from .words import is_balanced


class UMBILICS_PG_warning(bpy.types.PropertyGroup):
    """One warning of a detection."""

    text: StringProperty()


class UMBILICS_PG_summary(bpy.types.PropertyGroup):
    """The outcome of the object's last detection, in numbers."""

    detected: BoolProperty(description="The object has results")
    method: StringProperty(description="Method that found them")
    star: IntProperty(name="Stars")
    lemon: IntProperty(name="Lemons")
    monstar: IntProperty(name="Monstars")
    uncertain: IntProperty(name="Uncertain")
    candidates: IntProperty(description="Umbilics before persistence and opening")
    regions: IntProperty(name="Regions")
    index_sum: FloatProperty(description="Sum of the indices of umbilics and regions")
    euler_characteristic: IntProperty(description="Vertices - edges + faces")
    closed: BoolProperty(description="The surface has no border, so that the sum is known")
    expected_index_sum: FloatProperty(description="What the sum must be on a closed surface")
    balanced: BoolProperty(description="The sum of the indices is what it must be")
    persistence_level: FloatProperty(description="Pairs that cancel below this were dropped")
    warnings: CollectionProperty(type=UMBILICS_PG_warning)


def store(obj: bpy.types.Object, settings: core.Settings, detection: core.Detection) -> None:
    """Replace the object's summary by that of `detection`."""
    kept = obj.umbilics
    kept.detected = True
    kept.method = settings.method
    for kind, count in detection.umbilics.counts().items():
        setattr(kept, kind, count)
    kept.candidates = len(detection.candidates)
    kept.regions = len(detection.regions)
    kept.index_sum = detection.index_sum
    kept.euler_characteristic = detection.euler_characteristic
    kept.closed = math.isfinite(detection.expected_index_sum)
    kept.expected_index_sum = detection.expected_index_sum if kept.closed else 0.0
    kept.balanced = is_balanced(detection)
    level = detection.persistence_level
    kept.persistence_level = level if math.isfinite(level) else 0.0
    kept.warnings.clear()
    for text in detection.warnings:
        kept.warnings.add().text = text


def forget(obj: bpy.types.Object) -> bool:
    """Clear the object's summary; says whether there was one."""
    was_there = obj.umbilics.detected
    obj.property_unset("umbilics")
    return was_there


_CLASSES = (UMBILICS_PG_warning, UMBILICS_PG_summary)


def register() -> None:
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Object.umbilics = PointerProperty(type=UMBILICS_PG_summary)


def unregister() -> None:
    del bpy.types.Object.umbilics
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
