"""Copies that earlier versions put in the place of an object with modifiers, hiding it.

They are the user's now: analysed as they are, and never removed. Clear shows the hidden object.
"""

from __future__ import annotations

import bpy

from .targets import is_local, named
from .transaction import Transaction

_TAGS = ("umbilics_copy_of", "umbilics_base")


def let_go(context: bpy.types.Context, obj: bpy.types.Object, transaction: Transaction) -> bool:
    """Show the object that a copy was made of, and forget where the copy came from."""
    if _TAGS[0] not in obj or not is_local(obj):
        return False
    source = named(str(obj[_TAGS[0]]))
    if source is not None and source.name in context.view_layer.objects:
        transaction.on_failure(source.hide_set, source.hide_get())
        source.hide_set(False)
    transaction.keep_custom(obj, _TAGS)
    for tag in _TAGS:
        if tag in obj:
            del obj[tag]
    return True
