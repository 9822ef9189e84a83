"""What the guidance leaves in the scene: attributes, poles, curves, the mirror, edge marks.

Objects are children of the mesh, carry the custom property `umbilics_guidance` (their part, one of
`PARTS`) and lie in a collection with the same property. They follow the mesh. A part that is made
again replaces its own objects only.

Custom properties: of a pole `umbilics_valence`, `umbilics_confidence`, `umbilics_umbilic` (row
among the kept umbilics, -1 for none) and `umbilics_number` (its number, 0 for none); of a curve
`umbilics_family` (0 larger, 1 smaller curvature) and `umbilics_lengths`, a length for each
spline; of ridges also `umbilics_kinds` and `umbilics_bends`, the mean bend in degrees of each.
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
from ...mesh.attributes import remove_results, write_attributes
from ...mesh.edge_marks import EDGE_ATTRIBUTES, mark_edges, unmark_edges
from ...mesh.fetch import unit_vectors
from ...mesh.read import MeshArrays
from .. import homes
from ..empties import name_of
from ..targets import is_local
from ..transaction import Transaction, empty_without
from . import grease_pencil, pole_shapes

TAG = "umbilics_guidance"
PARTS = ("poles", "lines", "separatrices", "ridges", "guides", "mirror")
POLES, LINES, SEPARATRICES, RIDGES, GUIDES, MIRROR = PARTS
ATTRIBUTES = {
    "umbilics_cross": ("POINT", "FLOAT_VECTOR"),
    "umbilics_confidence": ("POINT", "FLOAT"),
    "umbilics_cross_face": ("FACE", "FLOAT_VECTOR"),
    "umbilics_cross_index": ("FACE", "FLOAT"),
}
# 1 where we marked a seam, 2 where a sharp edge, 4 where a crease, and sums: to be undone.
MARKS = {"umbilics_marked": ("EDGE", "INT")}
_BIT = {"seam": 1, "edge_sharp": 2, "crease": 4}

_FAMILY_NAME = ("Larger Curvature", "Smaller Curvature")
_FAMILY_COLOUR = ((1.0, 0.15, 0.08, 1.0), (0.08, 0.35, 1.0, 1.0))
_RIDGE_NAME = ("Ridges", "Ravines")
_RIDGE_COLOUR = ((0.95, 0.55, 0.05, 1.0), (0.05, 0.6, 0.55, 1.0))
# Sizes as fractions of the mesh's extent.
_POLE_SIZE, _LIFT, _BEVEL = 0.008, 0.0005, 0.0014


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
    collection = _discard(obj, POLES, transaction)
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
        collection = _adopt(context, obj, empty, POLES, collection, transaction, at)
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
    _adopt(context, obj, empty, POLES, collection_of(obj), transaction, at)


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
    x = least - (least @ normal) * normal
    x /= max(float(np.linalg.norm(x)), 1e-30)
    matrix = np.eye(4)
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 2] = x, np.cross(normal, x), normal
    return Matrix(matrix)


def write_lines(
    context: bpy.types.Context,
    obj: bpy.types.Object,
    arrays: MeshArrays,
    lines: core.Lines,
    part: str,
    transaction: Transaction,
) -> None:
    """A curve object of poly splines for each family, in place of the earlier ones."""
    collection = _discard(obj, part, transaction)
    points = _lifted(arrays, lines)
    ridges = lines if isinstance(lines, core.RidgeLines) else None
    for family, name in enumerate(_FAMILY_NAME if ridges is None else _RIDGE_NAME):
        rows = np.flatnonzero(lines.family == family)
        if not len(rows):
            continue
        title = f"{part.capitalize()}: {name}" if ridges is None else name
        curve = transaction.made(bpy.data.curves.new(title, "CURVE"))
        curve.dimensions = "3D"
        curve.resolution_u = 1
        curve.bevel_depth = _thickness(arrays, part)
        curve.bevel_resolution = 1
        for row in rows:
            place = points[lines.start[row] : lines.start[row + 1]]
            spline = curve.splines.new("POLY")
            spline.points.add(len(place) - 1)
            co = np.ones((len(place), 4), dtype=np.float32)
            co[:, :3] = place
            spline.points.foreach_set("co", co.ravel())
            spline.use_cyclic_u = bool(lines.closed[row])
        curve_object = transaction.made(bpy.data.objects.new(curve.name, curve))
        colour = (_FAMILY_COLOUR if ridges is None else _RIDGE_COLOUR)[family]
        curve.materials.append(_coloured(title, colour, transaction))
        curve_object.color = colour
        curve_object["umbilics_family"] = family
        curve_object["umbilics_lengths"] = lines.length[rows].tolist()
        if ridges is not None:
            curve_object["umbilics_kinds"] = ridges.kind[rows].tolist()
            bends = np.add.reduceat(ridges.bend, ridges.start[:-1]) / np.diff(ridges.start)
            curve_object["umbilics_bends"] = bends[rows].tolist()
        collection = _adopt(context, obj, curve_object, part, collection, transaction)


def _coloured(name: str, colour: tuple[float, ...], transaction: Transaction) -> bpy.types.Material:
    """A material of that colour, which Solid view shows as it is set up from the start."""
    material = transaction.made(bpy.data.materials.new(name))
    material.diffuse_color = colour
    material[TAG] = True
    return material


def write_guides(
    context: bpy.types.Context,
    obj: bpy.types.Object,
    arrays: MeshArrays,
    lines: core.Lines,
    separatrices: core.Lines,
    ridges: core.RidgeLines,
    transaction: Transaction,
) -> None:
    """Lines, separatrices and ridges as Grease Pencil strokes, in place of the earlier ones."""
    collection = _discard(obj, GUIDES, transaction)
    layers = {}
    for name, some in grease_pencil.layers_of(lines, separatrices, ridges).items():
        part = LINES if name in grease_pencil.FAMILIES else SEPARATRICES
        layers[name] = some, _lifted(arrays, some), _thickness(arrays, part)
    frame = min(context.scene.frame_start, context.scene.frame_current)
    made = grease_pencil.make(f"Guides of {obj.name}", layers, frame, transaction)
    _adopt(context, obj, made, GUIDES, collection, transaction)


def _lifted(arrays: MeshArrays, lines: core.Lines) -> np.ndarray:
    """(p, 3) points in the object's space, a hair's breadth above the mesh, to be seen on it."""
    extent = float(np.ptp(arrays.vertices, axis=0).max())
    to_object = np.linalg.inv(arrays.matrix)
    lifted = lines.position + _LIFT * extent * lines.normal
    return lifted @ to_object[:3, :3].T + to_object[:3, 3]


def _thickness(arrays: MeshArrays, part: str) -> float:
    """Radius of lines in the object's space."""
    extent = float(np.ptp(arrays.vertices, axis=0).max())
    scale = float(np.cbrt(abs(np.linalg.det(arrays.matrix[:3, :3]))))
    return (1.0 if part == LINES else 1.5) * _BEVEL * extent / scale


def write_mirror(
    context: bpy.types.Context,
    obj: bpy.types.Object,
    arrays: MeshArrays,
    plane: core.MirrorPlane,
    transaction: Transaction,
) -> None:
    """An empty whose z axis is the plane's normal, as large as the mesh."""
    collection = _discard(obj, MIRROR, transaction)
    empty = transaction.made(bpy.data.objects.new("Mirror Plane", None))
    empty.empty_display_type = "CIRCLE"
    empty.empty_display_size = 0.55 * float(np.ptp(arrays.vertices, axis=0).max())
    empty["umbilics_normal"] = plane.normal.tolist()
    empty["umbilics_score"] = plane.score
    # The circle lies in the empty's x-z plane: its y axis is the normal.
    turn = Matrix.Rotation(-np.pi / 2.0, 4, "X")
    place = Matrix.Translation(plane.point.tolist()) @ _upright(plane.normal) @ turn
    _adopt(context, obj, empty, MIRROR, collection, transaction, (arrays.matrix, place))
    transaction.keep_properties(obj, homes.PLAN)
    obj.umbilics_plan.mirror = (
        f"{len(plane.pairs)} matched, {100.0 * plane.score:.0f} % of a perfect mirror"
    )


def mark(obj: bpy.types.Object, chosen: np.ndarray, kind: str, transaction: Transaction) -> int:
    """Mark edges (e,) bool as "seam", "edge_sharp" or "crease" and remember which; how many are
    new."""
    transaction.keep_attributes(obj.data, (*MARKS, *EDGE_ATTRIBUTES))
    unmark(obj, kind)
    fresh = mark_edges(obj.data, chosen, kind)
    ours = _marks(obj.data)
    ours[fresh] |= _BIT[kind]
    write_attributes(obj.data, {"umbilics_marked": ours}, MARKS)
    return int(fresh.sum())


def unmark(obj: bpy.types.Object, kind: str) -> bool:
    """Take back the marks that `mark` made; whether there were any."""
    ours = _marks(obj.data)
    mine = (ours & _BIT[kind]) > 0
    if not mine.any():
        return False
    unmark_edges(obj.data, mine, kind)
    write_attributes(obj.data, {"umbilics_marked": ours & ~_BIT[kind]}, MARKS)
    return True


def _marks(mesh: bpy.types.Mesh) -> np.ndarray:
    found = mesh.attributes.get("umbilics_marked")
    values = np.zeros(len(mesh.edges), np.int32)
    if found is not None and (found.domain, found.data_type) == MARKS["umbilics_marked"]:
        found.data.foreach_get("value", values)
    return values


def _discard(
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
    transaction.discard([child])
    if child.type in ("CURVE", "MESH") and child.data.users == 1:
        ours = [one for one in child.data.materials if one is not None and TAG in one]
        transaction.discard([child.data, *(one for one in ours if one.users == 1)])


def remove_all(obj: bpy.types.Object, transaction: Transaction) -> bool:
    """Have everything go that the guidance left on an object that is not in Edit Mode."""
    found = [bool(parts_of(obj))]
    for part in PARTS:
        _discard(obj, part, transaction)
    found.append(homes.leave(obj, ATTRIBUTES, homes.PLAN, transaction))
    if is_local(obj.data) and not homes.others_with_results(obj):
        # Marks are the mesh's: whoever shares it may have made them.
        transaction.keep_attributes(obj.data, (*MARKS, *EDGE_ATTRIBUTES))
        found += [unmark(obj, kind) for kind in _BIT]
        found.append(remove_results(obj.data, MARKS.keys(), MARKS) > 0)
    transaction.keep_properties(obj, homes.PLAN)
    found.append(plans.forget(obj))
    return any(found)


def collection_of(obj: bpy.types.Object) -> bpy.types.Collection | None:
    """The collection of what the guidance made for an object."""
    ours = [one for child in parts_of(obj) for one in child.users_collection if TAG in one]
    return ours[0] if ours else None


def _adopt(
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
        child.matrix_parent_inverse = Matrix(matrix).inverted()
        child.matrix_basis = basis
    if collection is None:
        collection = transaction.made(bpy.data.collections.new(f"Guidance of {obj.name}"))
        collection[TAG] = True
        context.scene.collection.children.link(collection)
    collection.objects.link(child)
    return collection
