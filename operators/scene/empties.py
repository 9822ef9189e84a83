"""The empties at the umbilics of an object, in a collection that is ours by its tag.

The collection carries the custom property `umbilics`, each empty `umbilics_kind`; an object's
empties are those of its children that carry it, and its collection is the one they are in.
Names are for reading only: the user may change them. (A pointer to the object would be shorter,
but it would count as a user of it, and the object would outlive its deletion.)

Custom properties of an empty, all of them plain Python values:

umbilics_index        index of the direction field, a float
umbilics_kind         "star", "lemon", "monstar", "compound" or "uncertain"
umbilics_curvature    mean curvature there, in 1 / world length
umbilics_triangle     number of the mesh's loop triangle that holds the point
umbilics_vertices     the three vertices of that triangle
umbilics_barycentric  weights of those vertices
umbilics_persistence  gap at which it cancels with its partner, in 1 / world length;
                      3.4e38, the largest float, where topology keeps it; -1 where unknown
umbilics_row          row among all candidates of the detection
umbilics_number       its number in list, view and pole table, from 1
umbilics_of           full name of the object, then
"""

from __future__ import annotations

from functools import partial
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix

from ... import core
from ..data.belonging import OWNER_TAG
from ..data.preferences import Appearance
from ..data.record import Record
from ..drawing.frames import frames_of
from ..mesh.fetch import inverse
from .transaction import Transaction, all_or_nothing, empty_without
from .view.glyph_images import UNIT, image_of, unused_without

COLLECTION_TAG = "umbilics"
EMPTY_TAG = "umbilics_kind"
PERMANENT = float(np.finfo(np.float32).max)
UNKNOWN = -1.0
# Size of the cross under a glyph of the overlay, in sizes of the glyph.
_CROSS = 0.35
# No empty is larger than this part of the mesh, unless the preferences want it.
_LARGEST = 0.1


def collection_of(obj: bpy.types.Object) -> bpy.types.Collection | None:
    """The collection of the object's umbilics, if there is one."""
    for empty in empties_of(obj):
        for collection in empty.users_collection:
            if COLLECTION_TAG in collection:
                return collection
    return None


def empties_of(obj: bpy.types.Object) -> list[bpy.types.Object]:
    """The empties that a detection left at the object's umbilics, wherever they are now."""
    return [child for child in obj.children if child.type == "EMPTY" and EMPTY_TAG in child]


def replace(
    context: bpy.types.Context,
    obj: bpy.types.Object,
    record: Record,
    rows: np.ndarray,
    transaction: Transaction,
) -> None:
    """Put an empty at each of the candidates `rows` (k,), in place of earlier ones."""
    _exchange(context, obj, record, rows, empties_of(obj), transaction)


def update(
    context: bpy.types.Context,
    obj: bpy.types.Object,
    record: Record,
    rows: np.ndarray,
    transaction: Transaction,
) -> None:
    """As `replace`, for the same detection: empties that stay are left as they are."""
    wanted = set(rows.tolist())
    present = {empty.get("umbilics_row", -1): empty for empty in empties_of(obj)}
    unwanted = [empty for row, empty in present.items() if row not in wanted]
    missing = np.array(sorted(wanted - present.keys()), dtype=int)
    _exchange(context, obj, record, missing, unwanted, transaction)


def _exchange(
    context: bpy.types.Context,
    obj: bpy.types.Object,
    record: Record,
    rows: np.ndarray,
    unwanted: list[bpy.types.Object],
    transaction: Transaction,
) -> None:
    """Empties at the candidates `rows` (k,) instead of those unwanted."""
    collection = collection_of(obj)
    transaction.discard(unwanted)
    if len(rows):
        _add(context, obj, collection, record, rows, transaction)
    _sweep([collection] if collection is not None else [], transaction)


def name_of(kind: str, number: int) -> str:
    """What an umbilic is called, for example "Lemon 3"."""
    return f"{kind.capitalize()} {number}"


def _sweep(collections: list[bpy.types.Collection], transaction: Transaction) -> None:
    """Have our collections and images go with the last that is in them or shows them."""
    transaction.sweep(partial(empty_without, collections))
    transaction.sweep(unused_without)


def _add(
    context: bpy.types.Context,
    obj: bpy.types.Object,
    collection: bpy.types.Collection | None,
    record: Record,
    rows: np.ndarray,
    transaction: Transaction,
) -> None:
    if collection is None:
        # One of ours stands for another one.
        whose = obj.get(OWNER_TAG, obj.name)
        collection = transaction.made(bpy.data.collections.new(f"Umbilics of {whose}"))
        collection[COLLECTION_TAG] = True
    root = context.scene.collection
    if collection not in root.children_recursive:
        root.children.link(collection)
        transaction.on_failure(root.children.unlink, collection)
    look = Appearance(context)
    umbilics = record.detection.candidates.select(rows)
    # On a mesh of a few faces edges say nothing of how large an empty should be.
    size = np.minimum(look.empty_size * record.edge[rows], _LARGEST * record.extent)
    size = np.maximum(size, look.smallest_empty * record.extent)
    frames = frames_of(umbilics)
    is_overlaid = _is_overlaid(context)
    shown = set() if is_overlaid else set(umbilics.kind.tolist())
    images = {kind: image_of(kind, transaction) for kind in shown}
    to_object = inverse(record.matrix)
    views = local_views(context, obj)
    for place, row in enumerate(rows.tolist()):
        kind, number = str(umbilics.kind[place]), int(record.numbers[row])
        empty = transaction.made(bpy.data.objects.new(name_of(kind, number), None))
        _dress(empty, images.get(kind), float(size[place]), look.colours[kind])
        empty.parent = obj
        # The inverse undoes a non-uniform scale, which would shear the empty.
        empty.matrix_parent_inverse = to_object
        empty.matrix_basis = Matrix(frames[place])
        for name, value in _properties(umbilics, record.corners[row], place).items():
            empty[f"umbilics_{name}"] = value
        empty["umbilics_row"] = row
        empty["umbilics_number"] = number
        empty[OWNER_TAG] = obj.name_full
        collection.objects.link(empty)
        for view in views:
            empty.local_view_set(view, True)


def local_views(context: bpy.types.Context, obj: bpy.types.Object) -> list[bpy.types.SpaceView3D]:
    """The 3D views in local view that show the object: what is new there has to be let in."""
    return [
        area.spaces.active
        for window in context.window_manager.windows
        for area in window.screen.areas
        if area.type == "VIEW_3D"
        and area.spaces.active.local_view is not None
        and obj.local_view_get(area.spaces.active)
    ]


def remove(obj: bpy.types.Object, transaction: Transaction) -> bool:
    """Have the object's empties and their collection go; says whether there was anything.

    What the user has put into the collection stays, and then the collection stays too.
    """
    collection = collection_of(obj)
    empties = empties_of(obj)
    transaction.discard(empties)
    _sweep([collection] if collection is not None else [], transaction)
    return bool(empties)


def dress_all(context: bpy.types.Context, obj: bpy.types.Object) -> None:
    """Let the object's empties show the glyphs, or leave that to the overlay."""
    drawn = _is_overlaid(context)
    with all_or_nothing() as transaction:
        for empty in empties_of(obj):
            if drawn == (empty.empty_display_type == "IMAGE") and empty[EMPTY_TAG] in core.KINDS:
                size = empty.empty_display_size * (2.0 * UNIT if drawn else 1.0 / _CROSS)
                image = None if drawn else image_of(empty[EMPTY_TAG], transaction)
                _dress(empty, image, size, tuple(empty.color))
        transaction.sweep(unused_without)


def _is_overlaid(context: bpy.types.Context) -> bool:
    """Whether the overlay draws glyphs. Without a window it does not, and a file that is made
    then may be opened without the add-on."""
    display = context.scene.umbilics_display
    return display.overlay and display.glyphs and not bpy.app.background


def _dress(
    empty: bpy.types.Object,
    image: bpy.types.Image | None,
    size: float,
    colour: tuple[float, ...],
) -> None:
    """Let the empty show its glyph on the surface, from outside and in front of the mesh.

    Without an image it is a small cross, under the overlay's glyph: images have frames.
    """
    empty.color = colour
    if image is None:
        empty.data = None
        empty.empty_display_type = "PLAIN_AXES"
        empty.empty_display_size = _CROSS * size
        return
    empty.empty_display_type = "IMAGE"
    empty.data = image
    # The outlines are about two units across.
    empty.empty_display_size = size / (2.0 * UNIT)
    empty.empty_image_depth = "FRONT"
    empty.empty_image_side = "FRONT"


def _properties(umbilics: core.Umbilics, corners: np.ndarray, row: int) -> dict[str, Any]:
    return {
        "index": float(umbilics.index[row]),
        "kind": str(umbilics.kind[row]),
        "curvature": _finite(umbilics.curvature[row]),
        "triangle": int(umbilics.triangle[row]),
        "vertices": corners.tolist(),
        "barycentric": [_finite(weight) for weight in umbilics.barycentric[row]],
        "persistence": _persistence(float(umbilics.persistence[row])),
    }


def _finite(value: float) -> float:
    return float(value) if np.isfinite(value) else 0.0


def _persistence(value: float) -> float:
    return UNKNOWN if np.isnan(value) else min(value, PERMANENT)
