"""The glyphs of the kinds as icons, in the colours of the overlay: the panel is its legend."""

from __future__ import annotations

import bpy
import bpy.utils.previews
import numpy as np

from ..operators.data.preferences import Appearance
from ..operators.drawing.colour_maps import encoded
from ..operators.scene.view.glyph_images import drawn

_icons: bpy.utils.previews.ImagePreviewCollection | None = None


def icon_of(context: bpy.types.Context, kind: str) -> int:
    """The number of a kind's icon, for `icon_value`; it is made when it is first asked for."""
    colour = Appearance(context).colours[kind][:3]
    name = f"{kind} {colour}"
    if name not in _icons:
        pixels = drawn(kind)
        # Icons are stored multiplied by their opacity.
        pixels[..., :3] *= encoded(np.array(colour)) * pixels[..., 3:]
        icon = _icons.new(name)
        icon.icon_size = icon.image_size = pixels.shape[:2]
        icon.icon_pixels_float = icon.image_pixels_float = pixels.ravel().tolist()
    return _icons[name].icon_id


def register() -> None:
    global _icons
    _icons = bpy.utils.previews.new()


def unregister() -> None:
    global _icons
    bpy.utils.previews.remove(_icons)
    _icons = None
