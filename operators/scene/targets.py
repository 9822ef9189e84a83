"""Where the results of a mesh with modifiers go: to the base mesh, or to a copy tagged as ours.

The copy carries the custom property `umbilics_copy_of`, the full name of the object it was made
of, and `umbilics_base`, the signature of that object's own mesh at the time.
"""

from __future__ import annotations

import bpy

from ..mesh.fingerprint import mesh_signature
from ..mesh.read import MeshArrays, current_mesh

COPY_TAG = "umbilics_copy_of"
BASE_TAG = "umbilics_base"


def source_of(obj: bpy.types.Object | None) -> bpy.types.Object | None:
    """The object that a tagged copy was made of, if both are there; any other object itself."""
    if obj is None or COPY_TAG not in obj:
        return obj
    return named(obj[COPY_TAG])


def named(full_name: str) -> bpy.types.Object | None:
    """The object of that full name, which tells a linked object from one of this file."""
    return next((obj for obj in bpy.data.objects if obj.name_full == full_name), None)


def is_own(obj: bpy.types.Object) -> bool:
    """Whether object and mesh belong to this file, so that results can be kept with them.

    Of a library override Blender saves only what it allows to be overridden, and neither a
    mesh's attributes nor results are among it.
    """
    return all(
        data.library is None and data.override_library is None
        for data in (obj, obj.data)
        if data is not None
    )


def corresponds(obj: bpy.types.Object, arrays: MeshArrays) -> bool:
    """Whether vertices and faces that were read are those of the object's own mesh."""
    with current_mesh(obj) as mesh:
        return mesh_signature(mesh).rpartition("-")[2] == arrays.signature.rpartition("-")[2]


def copy_for(
    context: bpy.types.Context, obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph
) -> bpy.types.Object:
    """An object whose own mesh is what the modifiers make of `obj`, in place of an earlier one.

    The source is hidden, since both would lie in the same place.
    """
    mesh = bpy.data.meshes.new_from_object(
        obj.evaluated_get(depsgraph), preserve_all_data_layers=True, depsgraph=depsgraph
    )
    copies = (other for other in bpy.data.objects if other.get(COPY_TAG) == obj.name_full)
    copy = next(copies, None)
    if copy is None:
        copy = bpy.data.objects.new(f"{obj.name} with modifiers", mesh)
        for collection in _collections_for_a_copy(context, obj):
            collection.objects.link(copy)
    else:
        old, copy.data = copy.data, mesh
        if not old.users:
            bpy.data.meshes.remove(old)
    mesh.name = copy.name
    copy.matrix_world = obj.matrix_world
    copy[COPY_TAG] = obj.name_full
    with current_mesh(obj) as base:
        copy[BASE_TAG] = mesh_signature(base)
    if obj.mode == "OBJECT" and context.view_layer.objects.active == obj:
        obj.select_set(False)
        copy.select_set(True)
        context.view_layer.objects.active = copy
    obj.hide_set(True)
    return copy


def _collections_for_a_copy(
    context: bpy.types.Context, obj: bpy.types.Object
) -> list[bpy.types.Collection]:
    """The object's own, as far as they belong to this file, else the scene's."""
    own = [
        collection
        for collection in obj.users_collection
        if collection.library is None and collection.override_library is None
    ]
    return own or [context.scene.collection]


def remove_copy(context: bpy.types.Context, copy: bpy.types.Object) -> None:
    """Remove a tagged copy and show its source again."""
    source, mesh = source_of(copy), copy.data
    was_active = context.view_layer.objects.active == copy
    bpy.data.objects.remove(copy)
    if not mesh.users:
        bpy.data.meshes.remove(mesh)
    if source is not None and source.name in context.view_layer.objects:
        source.hide_set(False)
        if was_active:
            source.select_set(True)
            context.view_layer.objects.active = source
