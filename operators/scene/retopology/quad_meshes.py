"""A quad mesh as an object of the scene, beside what it was made of.

It is the user's from the start: nothing of ours ever replaces or removes it. Its mesh carries
`umbilics_valence` (vertices; of poles, else 0), `umbilics_patch` and `umbilics_angle` (faces), and
its patches are its face sets.
"""

from __future__ import annotations

import bpy
import numpy as np
from mathutils import Matrix

from .... import core
from ...data.remeshing import Delivery
from ...mesh.attributes import write_attributes
from ...mesh.build import from_polygons
from ...mesh.evaluated import evaluated_mesh
from ...mesh.fetch import fetch
from ...mesh.read import MeshArrays
from .. import empties, homes
from ..targets import is_local
from ..transaction import Transaction
from . import guidance_objects, shape_keys

ATTRIBUTES = {
    "umbilics_valence": ("POINT", "INT"),
    "umbilics_patch": ("FACE", "INT"),
    "umbilics_angle": ("FACE", "FLOAT"),
    ".sculpt_face_set": ("FACE", "INT"),
}
# What Blender's Data Transfer carries over, with the kinds of elements it does so between.
_TRANSFERRED = (
    ("VGROUP_WEIGHTS", {"vert_mapping": "POLYINTERP_NEAREST", "layers_select_src": "ALL"}),
    ("UV", {"loop_mapping": "POLYINTERP_NEAREST", "layers_select_src": "ALL"}),
    ("COLOR_VERTEX", {"vert_mapping": "POLYINTERP_NEAREST", "layers_select_src": "ALL"}),
    ("COLOR_CORNER", {"loop_mapping": "POLYINTERP_NEAREST", "layers_select_src": "ALL"}),
)


def add(
    context: bpy.types.Context,
    source: bpy.types.Object,
    arrays: MeshArrays,
    quads: core.QuadMesh,
    delivery: Delivery,
    transaction: Transaction,
    forward: bool = True,
) -> bpy.types.Object:
    """A new object of these quads where `source` is, in its collections.

    With `forward` it is active and selected, and the source hidden if that is wanted: not while
    the user edits or paints that.
    """
    # Without a parent's shear, which an object of its own cannot have: the vertices take it up.
    matrix = Matrix.LocRotScale(*Matrix(arrays.matrix).decompose())
    to_object = np.linalg.inv(np.array(matrix))
    vertices = quads.vertices @ to_object[:3, :3].T + to_object[:3, 3]
    faces = quads.quads
    if matrix.determinant() < 0.0:
        # Outwards in the world is inwards in the space of a mirrored object.
        faces = faces[:, ::-1]
    smooth = bool(len(source.data.polygons)) and source.data.polygons[0].use_smooth
    name = f"{source.name} Quads"
    sizes = np.full(len(faces), 4)
    mesh = transaction.made(from_polygons(vertices, faces.ravel(), sizes, smooth))
    mesh.name = name
    values = {
        "umbilics_valence": quads.valence,
        "umbilics_patch": quads.patch,
        "umbilics_angle": quads.angle,
        # Face sets count from one; rectangles without quads are none.
        ".sculpt_face_set": np.unique(quads.patch, return_inverse=True)[1].reshape(-1) + 1,
    }
    write_attributes(mesh, values, ATTRIBUTES)
    made = transaction.made(bpy.data.objects.new(name, mesh))
    own = [one for one in source.users_collection if is_local(one)]
    for collection in own or [context.scene.collection]:
        collection.objects.link(made)
    made.matrix_basis = matrix
    # Blender knows where a new object is in the world only then.
    context.view_layer.update()
    if delivery.transfer:
        _transfer(context, source, made, arrays, quads)
    if delivery.shrinkwrap:
        modifier = made.modifiers.new("Shrinkwrap", "SHRINKWRAP")
        modifier.target = source
    if forward:
        _come_forward(context, source, made, delivery.hide_original, transaction)
    return made


def lacks_keys(source: bpy.types.Object, made: bpy.types.Object) -> bool:
    """Whether the source has shape keys that could not be carried over."""
    return bool(source.data.shape_keys) and not made.data.shape_keys


def _transfer(
    context: bpy.types.Context,
    source: bpy.types.Object,
    made: bpy.types.Object,
    arrays: MeshArrays,
    quads: core.QuadMesh,
) -> None:
    """Materials by the faces below, the rest by Blender's own Data Transfer."""
    slots = [slot.material for slot in source.material_slots]
    for material in slots:
        made.data.materials.append(material)
    index = _slot_of_faces(context, source, arrays) if len(slots) > 1 else None
    if index is not None:
        corners = index[arrays.polygon[quads.source_triangle[quads.quads]]]
        # The one that most corners have, the first of equals.
        votes = (corners[:, :, None] == corners[:, None, :]).sum(axis=2)
        chosen = corners[np.arange(len(corners)), votes.argmax(axis=1)]
        made.data.polygons.foreach_set("material_index", chosen.astype(np.int32))
    wanted = {
        "VGROUP_WEIGHTS": bool(source.vertex_groups),
        "UV": bool(source.data.uv_layers),
        "COLOR_VERTEX": any(one.domain == "POINT" for one in source.data.color_attributes),
        "COLOR_CORNER": any(one.domain == "CORNER" for one in source.data.color_attributes),
    }
    with context.temp_override(
        object=source,
        active_object=source,
        selected_objects=[source, made],
        selected_editable_objects=[source, made],
    ):
        for kind, options in _TRANSFERRED:
            if wanted[kind]:
                bpy.ops.object.data_transfer(
                    data_type=kind, use_create=True, layers_select_dst="NAME", **options
                )
    shape_keys.carry_over(source, made, arrays)


def _slot_of_faces(
    context: bpy.types.Context, source: bpy.types.Object, arrays: MeshArrays
) -> np.ndarray | None:
    """(faces,) int32 material slot of each face that was analysed, of the mesh or of what its
    modifiers make of it; None where neither has as many faces."""
    if arrays.polygon_count == len(source.data.polygons):
        return fetch(source.data.polygons, "material_index", 1, np.int32)
    with evaluated_mesh(source, context.evaluated_depsgraph_get()) as seen:
        if arrays.polygon_count == len(seen.polygons):
            return fetch(seen.polygons, "material_index", 1, np.int32)
    return None


def _come_forward(
    context: bpy.types.Context,
    source: bpy.types.Object,
    made: bpy.types.Object,
    hide: bool,
    transaction: Transaction,
) -> None:
    """Select the new object alone, and hide what it was made of, with what stands on that."""
    layer = context.view_layer
    covering = _in_sight(context, source) if hide else []
    before = layer.objects.active, list(layer.objects.selected)
    transaction.on_failure(_as_before, layer, covering, *before)
    for other in list(layer.objects.selected):
        other.select_set(False)
    made.select_set(True)
    layer.objects.active = made
    for one in covering:
        one.hide_set(True)


def _in_sight(context: bpy.types.Context, source: bpy.types.Object) -> list[bpy.types.Object]:
    """The object, its umbilics, poles and guides, as far as they are seen; without a curve that
    the user steers by."""
    owner = homes.owner_of(source)
    ours = [*empties.empties_of(owner), *guidance_objects.parts_of(owner)]
    ours = [one for one in ours if one != context.scene.umbilics_guidance.strokes]
    return [one for one in (source, *ours) if one.visible_get(view_layer=context.view_layer)]


def _as_before(
    layer: bpy.types.ViewLayer,
    hidden: list[bpy.types.Object],
    active: bpy.types.Object | None,
    selected: list[bpy.types.Object],
) -> None:
    for one in hidden:
        one.hide_set(False)
    for other in selected:
        other.select_set(True)
    layer.objects.active = active
