"""What the panel shows of a detection, kept with the object in the file."""

import math
from collections.abc import Iterable, Sequence

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

from ... import core
from ..base import property_groups
from ..base.changes import notify, silence
from ..base.words import is_balanced
from ..mesh.fetch import fetch
from .record import Record

# A longer list would neither be read nor keep up with a slider.
MOST_ITEMS = 1000
# Of a row's number.
_MOST_DIGITS = 12
# The columns of the list.
_COLUMNS = {
    "row": np.int32,
    "number": np.int32,
    "kind": np.int32,
    "index": np.float32,
    "persistence": np.float32,
    "curvature": np.float32,
    "importance": np.float32,
}


def _active_changed(self: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    notify("active", context)


class UMBILICS_PG_warning(bpy.types.PropertyGroup):
    """One warning of a detection."""

    text: StringProperty()


class UMBILICS_PG_item(bpy.types.PropertyGroup):
    """One umbilic of the list."""

    row: IntProperty(description="Row among all candidates of the detection")
    number: IntProperty(description="Its number in list, view and pole table")
    kind: IntProperty(description="Row of the kind in star, lemon, monstar, compound, uncertain")
    index: FloatProperty(description="Index of the direction field around it")
    persistence: FloatProperty(description="Gap at which it cancels with its partner")
    curvature: FloatProperty(description="Mean curvature there")
    importance: FloatProperty(description="Persistence over the error of the gap")


class UMBILICS_PG_summary(bpy.types.PropertyGroup):
    """The outcome of the object's last detection, in numbers."""

    detected: BoolProperty(description="The object has results")
    method: StringProperty(description="Method that found them")
    star: IntProperty(
        name="Stars", description="Umbilics of index -1/2: three lines of curvature run into each"
    )
    lemon: IntProperty(
        name="Lemons", description="Umbilics of index +1/2: one line of curvature runs into each"
    )
    monstar: IntProperty(
        name="Monstars",
        description="Umbilics of index +1/2: three lines of curvature run into each, within a "
        "right angle",
    )
    compound: IntProperty(
        name="Compounds",
        description="Umbilics of another index: several that their errors do not tell from each "
        "other, or one that is no generic point",
    )
    uncertain: IntProperty(
        name="Uncertain",
        description="Umbilics whose index and cubic form disagree about the kind: look before "
        "you trust them",
    )
    candidates: IntProperty(
        name="Candidates",
        description="All umbilics that the detection found; the filters choose among them",
    )
    regions: IntProperty(
        name="Umbilical Regions",
        description="Areas that are spherical or flat, and curves along which every point is "
        "umbilical; each is counted once",
    )
    index_sum: FloatProperty(
        name="Index Sum",
        description="Sum of the indices of the umbilics and regions that the filters keep",
    )
    euler_characteristic: IntProperty(
        name="Euler Characteristic",
        description="Vertices - edges + faces: 2 for all that is like a ball, 0 for a ring, 2 "
        "less with each further hole. On a closed surface the indices sum to it, which the tick "
        "says; an open surface has no such rule",
    )
    closed: BoolProperty(description="The surface has no border, so that the sum is known")
    expected_index_sum: FloatProperty(description="What the sum must be on a closed surface")
    balanced: BoolProperty(description="The sum of the indices is what it must be")
    persistence_level: FloatProperty(
        name="Persistence",
        description="What Persistence has dropped, in 1 / length. A number that you set: all "
        "pairs that cancel below it. Auto, which judges each pair by the noise where it is: "
        "nothing above this value, the persistence of the strongest pair dropped; weaker pairs "
        "in quieter places are kept",
    )
    noise_multiple: FloatProperty(
        name="Auto",
        description="Auto drops a pair that cancels below this many times the noise: the error "
        "of the gap of the curvatures where the pair is. The more umbilics there are, the "
        "larger it is. The value behind it, in 1 / length, is the strongest pair that was dropped",
    )
    trust_ratio: FloatProperty(
        name="Noise / Median Gap",
        description="Gap at which noise makes pairs cancel, over the median gap. Up to 0.5 what "
        "is left sits where the surface has it; above 0.7 the noise is as strong as the shape",
    )
    noise: FloatProperty(
        name="Noise",
        description="How far the vertices scatter about a smooth surface, in length: their "
        "standard deviation, estimated from the fits",
    )
    scale: FloatProperty(
        name="Fitted Radius",
        description="Median radius of the neighbourhoods that curvature was fitted over, in length",
    )
    is_coarse: BoolProperty(description="The mesh is too coarse for the fits, see core.suitability")
    is_hard: BoolProperty(
        description="Curvature was fitted across the creases of a hard surface, see there"
    )
    warnings: CollectionProperty(type=UMBILICS_PG_warning)
    record: StringProperty(description="The detection itself, see data/record.py")
    stamp: StringProperty(description="Digest of the record, which tells it from all others")
    source: StringProperty(description="What was analysed: BASE or EVALUATED")
    scope: StringProperty(description="Which faces were: WHOLE, VISIBLE, SELECTED or GROUP")
    group: StringProperty(description="The vertex group of the scope GROUP")
    analysed: StringProperty(description="What was analysed and what was left out, in words")
    mesh: PointerProperty(
        type=bpy.types.Mesh, description="Holds the results that the object's own mesh cannot hold"
    )
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
    used_at_most: IntProperty(description="How many are shown at most; 0 for all")


def store(obj: bpy.types.Object, detected: Record, chosen: core.Selection) -> None:
    """Replace the object's numbers by those of a detection and what the filters keep of it."""
    kept, detection = obj.umbilics, detected.detection
    kept.detected = True
    codes = detected.kind_codes[chosen.rows]
    for kind, count in zip(core.KINDS, np.bincount(codes, minlength=len(core.KINDS)), strict=True):
        setattr(kept, kind, int(count))
    kept.candidates = len(detection.candidates)
    kept.regions = len(detection.regions)
    kept.index_sum = chosen.index_sum
    kept.euler_characteristic = detection.euler_characteristic
    kept.closed = math.isfinite(detection.expected_index_sum)
    kept.expected_index_sum = detection.expected_index_sum if kept.closed else 0.0
    kept.balanced = is_balanced(chosen.index_sum, detection.expected_index_sum)
    kept.persistence_level = chosen.persistence_level
    for name in ("trust_ratio", "noise", "scale"):
        value = getattr(detection, name)
        setattr(kept, name, value if math.isfinite(value) else 0.0)
    known = np.isfinite(detection.candidates.noise).any()
    kept.noise_multiple = core.noise_multiple(len(detection.candidates)) if known else 0.0
    kept.warnings.clear()
    for text in chosen.warnings:
        kept.warnings.add().text = text


def list_items(obj: bpy.types.Object, detected: Record, rows: np.ndarray) -> None:
    """Fill the object's list with the candidates `rows` (k,), the most persistent if they are
    too many."""
    kept = obj.umbilics
    chosen = detected.most_persistent(rows, MOST_ITEMS)
    umbilics = detected.detection.candidates.select(chosen)
    persistence = np.where(np.isnan(umbilics.persistence), -1.0, umbilics.persistence)
    largest = float(np.finfo(np.float32).max)
    columns = (
        chosen,
        detected.numbers[chosen],
        detected.kind_codes[chosen],
        umbilics.index,
        np.minimum(persistence, largest),
        np.nan_to_num(umbilics.curvature),
        np.minimum(umbilics.importance, largest),
    )
    put_columns(obj, columns)
    kept.hidden_items = len(rows) - len(chosen)
    # None is active until one is clicked: the list would scroll to it.
    place = np.flatnonzero(chosen == kept.active_row)
    active = int(place[0]) if len(place) else -1
    if active != kept.active:
        with silence("active"):
            kept.active = active


def columns_of(obj: bpy.types.Object) -> list[np.ndarray]:
    """What the object's list says, an array (k,) for each of `_COLUMNS`."""
    items = obj.umbilics.items
    return [fetch(items, name, 1, dtype) for name, dtype in _COLUMNS.items()]


def put_columns(obj: bpy.types.Object, columns: Sequence[np.ndarray]) -> None:
    """Fill the object's list by such arrays."""
    items, wanted = obj.umbilics.items, len(columns[0])
    while len(items) > wanted:
        items.remove(len(items) - 1)
    while len(items) < wanted:
        items.add()
    for (name, dtype), values in zip(_COLUMNS.items(), columns, strict=True):
        items.foreach_set(name, np.asarray(values, dtype=dtype))


def kind_of(item: UMBILICS_PG_item) -> str:
    """The kind of an umbilic of the list; the last, uncertain, where a damaged file says none."""
    return core.KINDS[item.kind] if 0 <= item.kind < len(core.KINDS) else core.KINDS[-1]


def rows_of(text: str) -> list[int]:
    """The rows in `pinned` or `deleted`; what is no row, in a damaged file, is passed over."""
    return [int(row) for row in text.split() if row.isdecimal() and len(row) < _MOST_DIGITS]


def text_of(rows: Iterable[int]) -> str:
    """What `rows_of` reads."""
    return " ".join(str(row) for row in sorted(set(rows)))


def forget(obj: bpy.types.Object) -> bool:
    """Clear the object's summary; says whether there was one."""
    was_there = obj.umbilics.detected
    obj.property_unset("umbilics")
    return was_there


register, unregister = property_groups.factory(
    (UMBILICS_PG_warning, UMBILICS_PG_item, UMBILICS_PG_summary),
    (bpy.types.Object, "umbilics", UMBILICS_PG_summary),
)
