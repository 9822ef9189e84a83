"""Which objects can keep results, and finding them again."""

from __future__ import annotations

import bpy

from ..base.errors import ObjectError


def named(full_name: str) -> bpy.types.Object | None:
    """The object of that full name, which tells a linked object from one of this file."""
    found = bpy.data.objects.get(full_name)
    if found is not None and found.name_full == full_name:
        return found
    return next((obj for obj in bpy.data.objects if obj.name_full == full_name), None)


def still_there(full_name: str) -> bpy.types.Object:
    """The object of that full name.

    Raises
    ------
    ObjectError
        It is gone.
    """
    found = named(full_name)
    if found is None:
        raise ObjectError(f"{full_name} is no longer there. Try again.")
    return found


def is_local(data: bpy.types.ID) -> bool:
    """Whether a data-block belongs to this file, so that results can be kept with it.

    Of a library override Blender saves only what it allows to be overridden, and neither a
    mesh's attributes nor results are among it.
    """
    return data.library is None and data.override_library is None


def is_own(obj: bpy.types.Object) -> bool:
    """Whether object and mesh both belong to this file."""
    return is_local(obj) and (obj.data is None or is_local(obj.data))
