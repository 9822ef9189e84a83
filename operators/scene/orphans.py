"""What is left of results whose object is deleted, joined to another or no longer has any.

Objects of ours are known by their tags. One that the user has taken from its object, or
animated, given a constraint, a child or, to an umbilic, another name is the user's.
"""

from __future__ import annotations

from collections.abc import Collection
from functools import partial

import bpy

from ..data.belonging import OWNER_TAG
from ..mesh.attributes import RESULTS, is_whole, remove_results
from . import display_objects, empties, homes
from .retopology import guidance_objects, marked_edges
from .targets import is_local
from .transaction import Transaction, empty_without
from .view import glyph_images

# What a detection and a plan leave on a mesh, and how it is laid out.
_ON_MESHES = (
    RESULTS,
    guidance_objects.ATTRIBUTES,
    marked_edges.MARKS,
    marked_edges.RIDGE_EDGES,
)


def with_results(going: Collection[bpy.types.ID] = ()) -> list[bpy.types.Object]:
    """The file's own mesh objects that have anything of ours, whatever scene they are in, without
    what is `going`."""
    objects = [obj for obj in bpy.data.objects if obj not in going]
    parents = {obj.parent for obj in objects if obj.parent and _is_tagged(obj)}
    return [
        obj
        for obj in objects
        if obj.type == "MESH"
        and is_local(obj)
        and (_has_results(obj) or obj in parents or _is_marked(obj.data))
    ]


def checked() -> list[bpy.types.Object]:
    """The file's own objects whose topology was checked."""
    return [obj for obj in bpy.data.objects if obj.umbilics_check.checked and is_local(obj)]


def remove(whole: Transaction, but: Collection[bpy.types.Object] = ()) -> int:
    """Remove what belongs to no object with results any more, `but` what belongs to these; how
    much there was."""
    names = {obj.name_full for obj in bpy.data.objects}
    alone = [
        obj
        for obj in bpy.data.objects
        if _is_tagged(obj) and _is_alone(obj, names) and obj.parent not in but
    ]
    # Those too that were left empty when the user deleted what was in them.
    collections = [one for one in bpy.data.collections if _is_ours(one) and is_local(one)]
    empty = empty_without(collections, set())
    with whole.part() as transaction:
        for obj in alone:
            guidance_objects.discard(obj, transaction)
        transaction.sweep(partial(empty_without, collections))
        transaction.sweep(glyph_images.unused_without)
        return len(alone) + len(empty) + _clean_meshes(transaction, but)


def _has_results(obj: bpy.types.Object) -> bool:
    plan = obj.umbilics_plan
    return bool(obj.umbilics.detected or plan.planned or plan.mirror or plan.axis)


def _is_tagged(obj: bpy.types.Object) -> bool:
    """Whether we made an object, and the user has not made it his own."""
    if not is_local(obj):
        return False
    if obj.type == "MESH":
        return display_objects.is_ours(obj)
    if empties.EMPTY_TAG in obj and obj.type == "EMPTY":
        kind = str(obj[empties.EMPTY_TAG])
        # Without a number in files of earlier versions.
        ours = (empties.name_of(kind, obj.get("umbilics_number", 0)), kind.capitalize())
        return obj.name.partition(".")[0] in ours
    return guidance_objects.TAG in obj


def _is_alone(obj: bpy.types.Object, names: set[str]) -> bool:
    """Whether the object that one of ours belonged to is gone, or has no results."""
    if obj.parent is not None:
        return obj.parent.type == "MESH" and not _has_results(homes.owner_of(obj.parent))
    if obj.animation_data is not None or obj.constraints or obj.children:
        return False
    # One whose object is there was unparented by the user.
    return str(obj.get(OWNER_TAG, "")) not in names


def _is_ours(collection: bpy.types.Collection) -> bool:
    return empties.COLLECTION_TAG in collection or guidance_objects.TAG in collection


def _is_marked(mesh: bpy.types.Mesh) -> bool:
    """Whether a mesh has attributes of ours, of whatever object."""
    return is_local(mesh) and (
        any(stamp in mesh for stamp in homes.STAMPS)
        or any(is_whole(mesh, layouts) for layouts in _ON_MESHES)
    )


def _clean_meshes(transaction: Transaction, but: Collection[bpy.types.Object]) -> int:
    """Take our values from meshes none of whose objects has results, `but` those of these; how
    many there were.

    Only where results are: a mesh with a stamp. Attributes of the same name may be the user's.
    """
    in_use = set()
    for obj in bpy.data.objects:
        if obj.type == "MESH" and (_has_results(obj) or obj in but):
            in_use |= {obj.data, obj.umbilics.mesh, obj.umbilics_plan.mesh}
    cleaned = 0
    for mesh in bpy.data.meshes:
        stamps = [key for key in homes.STAMPS if key in mesh]
        if not stamps or mesh in in_use or not is_local(mesh) or not mesh.users:
            continue
        transaction.keep_custom(mesh, stamps)
        for key in stamps:
            del mesh[key]
        for layouts in _ON_MESHES[:2]:
            transaction.keep_attributes(mesh, tuple(layouts))
            remove_results(mesh, layouts.keys(), layouts)
        cleaned += 1
    return cleaned
