"""What the panel shows of a detection, kept with the object in the file."""

import math
from collections.abc import Iterable

import bpy
import numpy as np
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from .. import core
from .changes import notify, silence
from .words import is_balanced

# A longer list would neither be read nor keep up with a slider.
MOST_ITEMS = 1000


def _active_changed(self, context):
    notify("active", context)


class UMBILICS_PG_warning(bpy.types.PropertyGroup):
    """One warning of a detection."""

    text: StringProperty()


class UMBILICS_PG_item(bpy.types.PropertyGroup):
    """One umbilic of the list."""

    row: IntProperty(description="Row among all candidates of the detection")
    kind: IntProperty(description="Row of the kind in star, lemon, monstar, uncertain")
    index: FloatProperty(description="Index of the direction field around it")
    persistence: FloatProperty(description="Gap at which it cancels with its partner")
    curvature: FloatProperty(description="Mean curvature there")


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
    trust_ratio: FloatProperty(description="Gap at which noise cancels over the median gap")
    noise: FloatProperty(description="Standard deviation of the positions, in length; 0: unknown")
    scale: FloatProperty(description="Radius that curvature was fitted over, in length; 0: none")
    warnings: CollectionProperty(type=UMBILICS_PG_warning)
    record: StringProperty(description="The detection itself, see operators/record.py")
    stamp: StringProperty(description="Changes with every detection")
    signature: StringProperty(description="Tells whether the mesh is still the one analysed")
    source: StringProperty(description="What was analysed: BASE or EVALUATED")
    pinned: StringProperty(description="Rows of candidates that are kept in any case")
    deleted: StringProperty(description="Rows of candidates that the user deleted")
    items: CollectionProperty(type=UMBILICS_PG_item)
    hidden_items: IntProperty(description="Umbilics that are too many for the list")
    active: IntProperty(
        name="Active Umbilic",
        description="Click to select the umbilic, double-click to bring it into view",
        default=-1,
        update=_active_changed,
    )
    active_row: IntProperty(description="Row of the umbilic chosen last", default=-1)
    used_persistence: FloatProperty(description="Filter of what is shown; -1 for automatic")
    used_opening: BoolProperty(description="Whether what is shown was opened")


def store(obj: bpy.types.Object, detection: core.Detection) -> None:
    """Replace the object's numbers by those of `detection`."""
    kept = obj.umbilics
    kept.detected = True
    for kind, count in detection.umbilics.counts().items():
        setattr(kept, kind, count)
    kept.candidates = len(detection.candidates)
    kept.regions = len(detection.regions)
    kept.index_sum = detection.index_sum
    kept.euler_characteristic = detection.euler_characteristic
    kept.closed = math.isfinite(detection.expected_index_sum)
    kept.expected_index_sum = detection.expected_index_sum if kept.closed else 0.0
    kept.balanced = is_balanced(detection)
    for name in ("persistence_level", "trust_ratio", "noise", "scale"):
        value = getattr(detection, name)
        setattr(kept, name, value if math.isfinite(value) else 0.0)
    kept.warnings.clear()
    for text in detection.warnings:
        kept.warnings.add().text = text


def list_items(obj: bpy.types.Object, umbilics: core.Umbilics, rows: np.ndarray) -> None:
    """Fill the object's list with the candidates `umbilics`, whose rows are `rows` (k,)."""
    kept = obj.umbilics
    persistence = np.where(np.isnan(umbilics.persistence), -1.0, umbilics.persistence)
    chosen = np.sort(np.argsort(-persistence, kind="stable")[:MOST_ITEMS])
    items = kept.items
    while len(items) > len(chosen):
        items.remove(len(items) - 1)
    while len(items) < len(chosen):
        items.add()
    largest = float(np.finfo(np.float32).max)
    codes = [core.KINDS.index(kind) for kind in umbilics.kind[chosen]]
    for name, values, dtype in (
        ("row", rows[chosen], np.int32),
        ("kind", codes, np.int32),
        ("index", umbilics.index[chosen], np.float32),
        ("persistence", np.minimum(persistence[chosen], largest), np.float32),
        ("curvature", np.nan_to_num(umbilics.curvature[chosen]), np.float32),
    ):
        items.foreach_set(name, np.asarray(values, dtype=dtype))
    kept.hidden_items = len(rows) - len(chosen)
    # None is active until one is clicked: the list would scroll to it.
    place = np.flatnonzero(rows[chosen] == kept.active_row)
    active = int(place[0]) if len(place) else -1
    if active != kept.active:
        with silence("active"):
            kept.active = active


def rows_of(text: str) -> list[int]:
    """The rows in `pinned` or `deleted`."""
    return [int(row) for row in text.split()]


def text_of(rows: Iterable[int]) -> str:
    """What `rows_of` reads."""
    return " ".join(str(row) for row in sorted(set(rows)))


def forget(obj: bpy.types.Object) -> bool:
    """Clear the object's summary; says whether there was one."""
    was_there = obj.umbilics.detected
    obj.property_unset("umbilics")
    return was_there


_CLASSES = (UMBILICS_PG_warning, UMBILICS_PG_item, UMBILICS_PG_summary)


def register() -> None:
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Object.umbilics = PointerProperty(type=UMBILICS_PG_summary)


def unregister() -> None:
    del bpy.types.Object.umbilics
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
