"""Which object of the user's one of ours belongs to."""

from __future__ import annotations

import bpy

# On everything of ours in a scene: the full name that its object had then.
OWNER_TAG = "umbilics_of"


def mesh_behind(obj: bpy.types.Object | None) -> bpy.types.Object | None:
    """The mesh that one of our empties, curves or drawings belongs to; any other object itself.

    One that the user has taken from its mesh belongs to nothing.
    """
    if obj is None or obj.type == "MESH" or OWNER_TAG not in obj:
        return obj
    parent = obj.parent
    return parent if parent is not None and parent.type == "MESH" else obj


def active_mesh() -> bpy.types.Object | None:
    """The object that is meant where a property of the scene is read or put."""
    # Not every context that a property is read in has an active object.
    return mesh_behind(getattr(bpy.context, "active_object", None))
