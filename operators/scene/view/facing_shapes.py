"""What of an object's results is drawn upright to the viewer: its poles, numbers, and the marks
of a check."""

from __future__ import annotations

import bpy
import numpy as np

from ...data import record, topology
from ...data.preferences import Appearance
from ...drawing import check_marks as marks_of_check
from ...drawing import figures, poles
from ...drawing.shapes import Places, Shape
from ...mesh.fetch import fetch
from .. import filters
from ..retopology import guidance_objects
from .umbilic_shapes import opacity_of

# More numbers than these would hide each other and what they number.
MOST_NUMBERS = 200
# Height of a number and where it stands, in sizes of a glyph; the colour of its digits.
_HEIGHT, _BESIDE = 0.95, (1.35, 0.8)
_INK = (0.95, 0.95, 0.95)


def poles_seen(obj: bpy.types.Object) -> list[bpy.types.Object]:
    """The empties of the poles that are drawn: those that are not hidden."""
    found = guidance_objects.parts_of(obj, guidance_objects.POLES)
    return [one for one in found if one.visible_get() and one.get("umbilics_valence") in (3, 5)]


def pole_places(obj: bpy.types.Object) -> tuple[np.ndarray, np.ndarray]:
    """(k, 3) places of the poles seen, in the object's space, and (k,) their valences."""
    seen = poles_seen(obj)
    back = np.array(obj.matrix_world.inverted_safe())
    places = np.array([one.matrix_world.translation[:] for one in seen]).reshape(-1, 3)
    places = places @ back[:3, :3].T + back[:3, 3]
    return places, np.array([one["umbilics_valence"] for one in seen], int)


def numbered_rows(context: bpy.types.Context, obj: bpy.types.Object) -> np.ndarray:
    """(k,) rows of the candidates whose number is drawn: all that are seen or, if that is not
    wanted or they are too many, the one that is active in the list."""
    rows = filters.shown_rows(obj, context.scene)
    if context.scene.umbilics_display.numbers and len(rows) <= MOST_NUMBERS:
        return rows
    return rows[rows == obj.umbilics.active_row]


def shapes_of_poles(
    context: bpy.types.Context, obj: bpy.types.Object, upright: np.ndarray, faint: bool
) -> list[Shape]:
    """Glyphs of the poles; `upright` (2, 3) is what leads right and up on the screen, in the
    object's space. `faint`: the plan is stale, and looks it."""
    size = Appearance(context).glyph_size
    places, valence = pole_places(obj)
    shapes = []
    for some in (3, 5):
        mine = places[valence == some]
        if len(mine):
            shapes += poles.pole_glyphs(some, _facing(mine, upright), size, opacity_of(faint))
    return shapes


def check_marks(obj: bpy.types.Object) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(k, 3) places of the marks of the object's check, in its space, (k,) valences and states."""
    marks = obj.umbilics_check.marks
    return (
        fetch(marks, "place", 3, np.float32),
        fetch(marks, "valence", 1, np.int32),
        fetch(marks, "state", 1, np.int32),
    )


def shapes_of_check(
    context: bpy.types.Context, obj: bpy.types.Object, upright: np.ndarray, faint: bool
) -> list[Shape]:
    """The marks of a check, for the rest as `shapes_of_poles`; the chosen one is larger."""
    size = Appearance(context).glyph_size
    places, valence, state = check_marks(obj)
    chosen = np.arange(len(places)) == obj.umbilics_check.active
    shapes = []
    for some in range(len(topology.STATES)):
        for grown, rows in ((1.0, ~chosen), (marks_of_check.CHOSEN, chosen)):
            mine = np.flatnonzero((state == some) & rows)
            if len(mine):
                at = _facing(places[mine].astype(float), upright)
                shapes += marks_of_check.marks(
                    some, valence[mine].tolist(), at, grown * size, opacity_of(faint)
                )
    return shapes


def shapes_of_numbers(
    context: bpy.types.Context, obj: bpy.types.Object, upright: np.ndarray, faint: bool
) -> list[Shape]:
    """The numbers beside umbilics, for the rest as `shapes_of_poles`."""
    kept, rows = record.of(obj), numbered_rows(context, obj)
    if kept is None or not len(rows):
        return []
    size = Appearance(context).glyph_size
    back = np.linalg.inv(kept.matrix)
    places = kept.detection.candidates.position[rows] @ back[:3, :3].T + back[:3, 3]
    offset = (_BESIDE[0] * size, _BESIDE[1] * size)
    how = figures.Writing(_HEIGHT * size, (*_INK, opacity_of(faint)), offset)
    return figures.written(_facing(places, upright), kept.numbers[rows].tolist(), how)


def _facing(places: np.ndarray, upright: np.ndarray) -> Places:
    right, up = (np.broadcast_to(direction, places.shape) for direction in upright)
    return Places(places, right, up)
