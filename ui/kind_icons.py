"""The glyphs of the kinds as icons, in the colours of the overlay: the panel is its legend."""

from __future__ import annotations

import functools

import bpy
import bpy.utils.previews
import numpy as np

from ..operators.data.preferences import Appearance
from ..operators.drawing.colour_maps import encoded
from ..operators.scene.view.glyph_images import drawn


@functools.cache
def _icons() -> bpy.utils.previews.ImagePreviewCollection:
    """All that were made so far, by name."""
    return bpy.utils.previews.new()


def icon_of(context: bpy.types.Context, kind: str) -> int:
    """The number of a kind's icon, for `icon_value`; it is made when it is first asked for."""
    colour = Appearance(context).colours[kind][:3]
    name = f"{kind} {colour}"
    icons = _icons()
    if name not in icons:
        pixels = drawn(kind).copy()
        # Icons are stored multiplied by their opacity.
        pixels[..., :3] *= encoded(np.array(colour)) * pixels[..., 3:]
        icon = icons.new(name)
        icon.icon_size = icon.image_size = pixels.shape[:2]
        icon.icon_pixels_float = icon.image_pixels_float = pixels.ravel().tolist()
    return icons[name].icon_id


def register() -> None:
    pass


def unregister() -> None:
    bpy.utils.previews.remove(_icons())
    _icons.cache_clear()
