"""What the guidance leaves in the scene: attributes, poles, the mirror; and, of `curve_objects` and
`marked_edges`, curves and marks.

Objects are children of the mesh, carry the custom property `umbilics_guidance` (their part, one of
`PARTS`) and lie in a collection with the same property. They follow the mesh. A part that is made
again replaces its own objects only.

Custom properties of a pole: `umbilics_valence`, `umbilics_confidence`, `umbilics_umbilic` (row
among the kept umbilics, -1 for none) and `umbilics_number` (its number, 0 for none).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import bpy
import numpy as np
from mathutils import Matrix

from .... import core
from ...data import plans
from ...data.belonging import OWNER_TAG
from ...drawing.poles import COLOURS as POLE_COLOURS
from ...mesh.attributes import write_attributes
from ...mesh.fetch import inverse, unit_vectors
from ...mesh.read import MeshArrays
from .. import homes
from ..empties import name_of
from ..targets import is_local
from ..transaction import Transaction, empty_without
from . import grease_pencil, marked_edges, pole_shapes

TAG = "umbilics_guidance"
PARTS = ("poles", "lines", "separatrices", "ridges", "layout", "guides", "mirror", "axis")
POLES, LINES, SEPARATRICES, RIDGES, LAYOUT, GUIDES, MIRROR, AXIS = PARTS
ATTRIBUTES = {
    "umbilics_cross": ("POINT", "FLOAT_VECTOR"),
    "umbilics_confidence": ("POINT", "FLOAT"),
    "umbilics_cross_face": ("FACE", "FLOAT_VECTOR"),
    "umbilics_cross_index": ("FACE", "FLOAT"),
}

# As a fraction of the mesh's extent.
_POLE_SIZE = 0.008


def parts_of(obj: bpy.types.Object, part: str | None = None) -> list[bpy.types.Object]:
    """The objects that the guidance made for a mesh, of one part or all."""
    return [
        child for child in obj.children if TAG in child and (part is None or child[TAG] == part)
    ]


def pole_sum(obj: bpy.types.Object) -> int:
    """Sum of 4 - valence over the poles that are there now."""
    valences = [child.get("umbilics_valence") for child in parts_of(obj, POLES)]
    return sum(4 - valence for valence in valences if isinstance(valence, int))


@dataclass(frozen=True)
class Kept:
    """The umbilics that poles come from, and the number (k,) of each."""

    umbilics: core.Umbilics
    numbers: np.ndarray


def write_plan(
    context: bpy.types.Context,
    home: homes.Home,
    arrays: MeshArrays,
    guidance: core.Guidance,
    kept: Kept,
    origin: plans.Origin,
    transaction: Transaction,
    by_hand: bool = False,
) -> None:
    """Attributes of the field, an empty at each pole, and the table; `by_hand` says that the
    poles are the user's."""
    obj = home.owner
    to_object = np.linalg.inv(arrays.matrix[:3, :3]).T
    # The first triangle of each face; faces outside the scope have none, and no direction.
    first = np.full(arrays.polygon_count, -1)
    first[arrays.polygon[::-1]] = np.arange(len(arrays.polygon))[::-1]
    on_faces = np.where((first < 0)[:, None], 0.0, guidance.face_direction[first])
    values = {
        "umbilics_cross": unit_vectors(guidance.direction @ to_object),
        "umbilics_confidence": guidance.confidence,
        "umbilics_cross_face": unit_vectors(on_faces @ to_object),
        "umbilics_cross_index": np.bincount(
            arrays.polygon, weights=guidance.triangle_index, minlength=arrays.polygon_count
        ),
    }
    homes.leave(obj, ATTRIBUTES, homes.PLAN, transaction, home.mesh)
    transaction.keep_attributes(home.mesh, tuple(ATTRIBUTES))
    write_attributes(home.mesh, values, ATTRIBUTES)
    collection = replaced(obj, POLES, transaction)
    poles = guidance.poles
    extent = float(np.ptp(arrays.vertices, axis=0).max())
    empties, origins = [], []
    for row in range(len(poles)):
        empty = new_pole(
            context, int(poles.valence[row]), extent, float(poles.confidence[row]), transaction
        )
        umbilic = int(poles.umbilic[row])
        empty["umbilics_umbilic"] = umbilic
        empty["umbilics_number"] = int(kept.numbers[umbilic]) if umbilic >= 0 else 0
        place, normal = poles.position[row], poles.normal[row]
        at = arrays.matrix, upright_at(place, normal)
        collection = adopt(context, obj, empty, POLES, collection, transaction, at)
        empties.append(empty)
        origins.append("By Hand" if by_hand else _origin(poles, kept, row))
    transaction.keep_properties(obj, homes.PLAN)
    plans.store(obj, origin, guidance, empties, origins, by_hand)
    homes.settle(home, homes.PLAN, transaction)


def new_pole(
    context: bpy.types.Context,
    valence: int,
    extent: float,
    confidence: float,
    transaction: Transaction,
) -> bpy.types.Object:
    """An empty that stands for a pole on a mesh of this extent, in no collection yet."""
    empty = transaction.made(bpy.data.objects.new(f"Pole {valence}", None))
    empty["umbilics_valence"] = valence
    pole_shapes.dress(empty, pole_shapes.is_overlaid(context), _POLE_SIZE * extent)
    empty.color = POLE_COLOURS[valence]
    empty["umbilics_confidence"] = confidence
    empty["umbilics_umbilic"] = -1
    empty["umbilics_number"] = 0
    return empty


def put_pole(
    context: bpy.types.Context,
    obj: bpy.types.Object,
    empty: bpy.types.Object,
    place: np.ndarray,
    normal: np.ndarray,
    transaction: Transaction,
) -> None:
    """Put a pole beside those of the object's plan, at a place (3,) of the world."""
    at = np.array(obj.matrix_world), upright_at(place, normal)
    adopt(context, obj, empty, POLES, collection_of(obj), transaction, at)


def upright_at(place: np.ndarray, normal: np.ndarray) -> Matrix:
    """A matrix (4, 4) that takes the origin to a place and z to the normal there."""
    return Matrix.Translation(place.tolist()) @ _upright(normal)


def _origin(poles: core.Poles, kept: Kept, row: int) -> str:
    umbilic = int(poles.umbilic[row])
    if umbilic >= 0:
        return name_of(str(kept.umbilics.kind[umbilic]), int(kept.numbers[umbilic]))
    return f"Region {int(poles.region[row]) + 1}" if poles.region[row] >= 0 else "Field"


def _upright(normal: np.ndarray) -> Matrix:
    """A rotation (4, 4) that takes z to the normal."""
    least = np.eye(3)[np.abs(normal).argmin()]
    x = unit_vectors(least - (least @ normal) * normal)
    matrix = np.eye(4)
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 2] = x, np.cross(normal, x), normal
    return Matrix(matrix)


def write_mirror(
    context: bpy.types.Context,
    obj: bpy.types.Object,
    arrays: MeshArrays,
    plane: core.MirrorPlane,
    transaction: Transaction,
) -> None:
    """An empty whose z axis is the plane's normal, as large as the mesh."""
    collection = replaced(obj, MIRROR, transaction)
    empty = transaction.made(bpy.data.objects.new("Mirror Plane", None))
    empty.empty_display_type = "CIRCLE"
    empty.empty_display_size = 0.55 * float(np.ptp(arrays.vertices, axis=0).max())
    empty["umbilics_normal"] = plane.normal.tolist()
    empty["umbilics_score"] = plane.score
    # The circle lies in the empty's x-z plane: its y axis is the normal.
    turn = Matrix.Rotation(-np.pi / 2.0, 4, "X")
    place = Matrix.Translation(plane.point.tolist()) @ _upright(plane.normal) @ turn
    adopt(context, obj, empty, MIRROR, collection, transaction, (arrays.matrix, place))
    transaction.keep_properties(obj, homes.PLAN)
    obj.umbilics_plan.mirror = (
        f"{len(plane.pairs)} matched, {100.0 * plane.score:.0f} % of a perfect mirror"
    )


def write_axis(
    context: bpy.types.Context,
    obj: bpy.types.Object,
    arrays: MeshArrays,
    found: core.RotationSymmetry,
    transaction: Transaction,
) -> None:
    """An empty on the axis, whose arrow runs along it, as the offset of a radial array wants it."""
    collection = replaced(obj, AXIS, transaction)
    empty = transaction.made(bpy.data.objects.new(f"Rotation Axis {found.order}", None))
    empty.empty_display_type = "SINGLE_ARROW"
    empty.empty_display_size = 0.8 * float(np.ptp(arrays.vertices, axis=0).max())
    empty["umbilics_order"] = found.order
    empty["umbilics_score"] = found.score
    place = Matrix.Translation(found.point.tolist()) @ _upright(found.axis)
    adopt(context, obj, empty, AXIS, collection, transaction, (arrays.matrix, place))
    transaction.keep_properties(obj, homes.PLAN)
    obj.umbilics_plan.axis = (
        f"Order {found.order}, {100.0 * found.score:.0f} % of a perfect rotation"
    )


def replaced(
    obj: bpy.types.Object, part: str, transaction: Transaction
) -> bpy.types.Collection | None:
    """Have the objects of one part go, and the collection with its last; the collection."""
    found = parts_of(obj, part)
    ours = [one for child in parts_of(obj) for one in child.users_collection if TAG in one]
    for child in found:
        discard(child, transaction)
    transaction.sweep(partial(empty_without, ours))
    return ours[0] if ours else None


def discard(child: bpy.types.Object, transaction: Transaction) -> None:
    """Have one of our objects go, with data that nothing else uses."""
    if child.type in grease_pencil.OBJECT_TYPES:
        if grease_pencil.is_ours(child):
            transaction.discard(grease_pencil.parts_of(child))
            return
        # What the user drew on it is the user's.
        transaction.at_end(grease_pencil.remove_layers, child)
        transaction.keep_custom(child, (TAG,))
        del child[TAG]
        return
    if any(scene.umbilics_guidance.strokes == child for scene in bpy.data.scenes):
        # What was chosen to guide may have been edited: it is the user's, too.
        transaction.keep_custom(child, (TAG,))
        del child[TAG]
        return
    transaction.discard([child])
    if child.type in ("CURVE", "MESH") and child.data.users == 1:
        ours = [one for one in child.data.materials if one is not None and TAG in one]
        transaction.discard([child.data, *(one for one in ours if one.users == 1)])


def remove_all(obj: bpy.types.Object, transaction: Transaction) -> bool:
    """Have everything go that the guidance left on an object that is not in Edit Mode."""
    found = [bool(parts_of(obj))]
    for part in PARTS:
        replaced(obj, part, transaction)
    found.append(homes.leave(obj, ATTRIBUTES, homes.PLAN, transaction))
    if is_local(obj.data) and not homes.others_with_results(obj):
        # Marks are the mesh's: whoever shares it may have made them.
        found.append(marked_edges.remove_all(obj, transaction))
    transaction.keep_properties(obj, homes.PLAN)
    found.append(plans.forget(obj))
    return any(found)


def collection_of(obj: bpy.types.Object) -> bpy.types.Collection | None:
    """The collection of what the guidance made for an object."""
    ours = [one for child in parts_of(obj) for one in child.users_collection if TAG in one]
    return ours[0] if ours else None


def adopt(
    context: bpy.types.Context,
    obj: bpy.types.Object,
    child: bpy.types.Object,
    part: str,
    collection: bpy.types.Collection | None,
    transaction: Transaction,
    place: tuple[np.ndarray, Matrix] | None = None,
) -> bpy.types.Collection:
    """Make an object a tagged child of the mesh, in the guidance's collection, which is the
    answer; `place` is the mesh's world matrix (4, 4) and where the child stands in the world."""
    child[TAG] = part
    child[OWNER_TAG] = obj.name_full
    # Guides are to be worked with, not to be in a picture.
    child.hide_render = True
    child.parent = obj
    if place is not None:
        matrix, basis = place
        # The inverse undoes a non-uniform scale, which would shear the empty.
        child.matrix_parent_inverse = inverse(matrix)
        child.matrix_basis = basis
    if collection is None:
        collection = transaction.made(bpy.data.collections.new(f"Guidance of {obj.name}"))
        collection[TAG] = True
        context.scene.collection.children.link(collection)
    collection.objects.link(child)
    return collection
