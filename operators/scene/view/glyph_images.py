"""Pictures of the glyphs, which the empties show: white, tinted by the empty's colour.

Blender draws the lines of an empty in the theme's one colour, but an image in its own. The
images are tagged by the custom property `umbilics_glyph` and go when nothing shows them.
"""

from __future__ import annotations

from collections import Counter
from functools import cache

import bpy
import numpy as np

from ...drawing.glyphs import OUTLINES
from ..transaction import Transaction

IMAGE_TAG = "umbilics_glyph"
# Length of the outline's unit as a fraction of the image's side, so that all outlines fit.
UNIT = 0.34

_PIXELS, _SAMPLES = 96, 4
_RIM, _RIM_BRIGHTNESS = 0.14, 0.12


def image_of(kind: str, transaction: Transaction) -> bpy.types.Image:
    """The image for a kind of umbilic, made if it is missing."""
    for image in bpy.data.images:
        if image.library is None and image.get(IMAGE_TAG) == kind:
            return image
    image = bpy.data.images.new(f"Umbilics {kind}", _PIXELS, _PIXELS, alpha=True)
    transaction.made(image)
    image[IMAGE_TAG] = kind
    image.pixels.foreach_set(drawn(kind).ravel())
    image.update()
    image.pack()
    return image


def unused_without(going: set[bpy.types.ID]) -> list[bpy.types.Image]:
    """Our images that nothing shows without the empties that go."""
    showing = Counter(one.data for one in going if isinstance(one, bpy.types.Object))
    return [
        image
        for image in bpy.data.images
        if IMAGE_TAG in image and image.library is None and image.users <= showing[image]
    ]


@cache
def drawn(kind: str) -> np.ndarray:
    """(pixels, pixels, 4) float32: a white glyph with a dark rim, clear around it.

    Every file that umbilics are found in has its image, of the same pixels.
    """
    outline = OUTLINES[kind]
    inside = _coverage(outline)
    # A rim by the outline's own shape: it grows by the same length at every point of it.
    reach = np.linalg.norm(outline, axis=1, keepdims=True)
    around = _coverage(outline * (1.0 + _RIM / reach))
    brightness = _RIM_BRIGHTNESS + (1.0 - _RIM_BRIGHTNESS) * inside
    pixels = np.dstack([brightness, brightness, brightness, around]).astype(np.float32)
    pixels.flags.writeable = False
    return pixels


def _coverage(outline: np.ndarray) -> np.ndarray:
    """(pixels, pixels) how much of each pixel lies inside an outline star-shaped about 0."""
    count = _PIXELS * _SAMPLES
    line = ((np.arange(count) + 0.5) / count - 0.5) / UNIT
    x, y = np.meshgrid(line, line)
    angle = np.arctan2(outline[:, 1], outline[:, 0])
    order = np.argsort(angle)
    # The side of the outline that each sample looks out through from 0.
    side = np.searchsorted(angle[order], np.arctan2(y, x), side="right") - 1
    (ax, ay), (bx, by) = outline[order].T, np.roll(outline, -1, axis=0)[order].T
    beyond = (bx - ax)[side] * (y - ay[side]) - (by - ay)[side] * (x - ax[side]) < 0.0
    return (~beyond).reshape(_PIXELS, _SAMPLES, _PIXELS, _SAMPLES).mean(axis=(1, 3))
