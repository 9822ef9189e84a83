"""How the empty of a pole looks: a shape for its valence, or next to nothing under a glyph."""

from __future__ import annotations

import bpy

_SHAPE = {3: "SPHERE", 5: "CUBE"}
# Size of the cross under a glyph of the overlay, in sizes of the shape.
_CROSS = 0.5


def is_overlaid(context: bpy.types.Context) -> bool:
    """Whether the overlay draws poles. Without a window it does not, and a file that is made then
    may be opened without the add-on."""
    display = context.scene.umbilics_display
    return display.overlay and display.poles and not bpy.app.background


def dress(empty: bpy.types.Object, overlaid: bool, size: float) -> None:
    """Give a pole's empty the looks that it is to have; `size` is that of its shape."""
    empty.empty_display_type = "PLAIN_AXES" if overlaid else _SHAPE[empty["umbilics_valence"]]
    empty.empty_display_size = _CROSS * size if overlaid else size


def dress_all(poles: list[bpy.types.Object], overlaid: bool) -> None:
    """Let poles show their shape, or leave that to the overlay."""
    for empty in poles:
        is_cross = empty.empty_display_type == "PLAIN_AXES"
        if empty.get("umbilics_valence") in _SHAPE and is_cross != overlaid:
            size = empty.empty_display_size
            dress(empty, overlaid, size / _CROSS if is_cross else size)
