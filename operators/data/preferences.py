"""The add-on's preferences: how results look."""

import bpy
from bpy.props import FloatProperty, FloatVectorProperty, IntProperty

from ... import core
from ..base.changes import notify

# Told apart by lightness as well as by hue, also with a red-green deficiency.
KIND_COLOURS = {
    "star": (0.05, 0.25, 0.85, 1.0),
    "lemon": (1.0, 0.62, 0.0, 1.0),
    "monstar": (0.75, 0.05, 0.35, 1.0),
    "compound": (0.2, 0.8, 0.72, 1.0),
    "uncertain": (0.5, 0.5, 0.5, 1.0),
}
EMPTY_SIZE = 3.0
SMALLEST_EMPTY = 0.005
MOST_EMPTIES = 1000
GLYPH_SIZE = 13.0
STROKE_WIDTH = 1.6
STROKE_COLOUR = (0.02, 0.03, 0.05, 0.75)
STROKE_COLOUR_2 = (0.95, 0.95, 0.97, 0.75)

# The extension holds operators, which hold data, which hold this.
_ADD_ON = __package__.rsplit(".", 2)[0]


def _changed(self: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    notify("view", context)


class UMBILICS_preferences(bpy.types.AddonPreferences):
    bl_idname = _ADD_ON

    empty_size: FloatProperty(
        name="Size",
        description="Size of the empties, in lengths of the mesh's edges around them",
        default=EMPTY_SIZE,
        min=0.0,
        soft_max=20.0,
    )
    smallest_empty: FloatProperty(
        name="Smallest",
        description="No empty is smaller than this fraction of the object's size",
        default=SMALLEST_EMPTY,
        min=0.0,
        max=1.0,
        precision=3,
    )

    most_empties: IntProperty(
        name="At Most",
        description="How many umbilics of an object get an empty, the most persistent first; "
        "the overlay draws them all",
        default=MOST_EMPTIES,
        min=0,
        max=100000,
    )
    glyph_size: FloatProperty(
        name="Glyph Size",
        description="Size of the overlay's glyphs on the screen, in pixels",
        subtype="PIXEL",
        default=GLYPH_SIZE,
        min=4.0,
        max=100.0,
        update=_changed,
    )
    stroke_width: FloatProperty(
        name="Stroke Width",
        description="Width of the overlay's strokes and rays on the screen, in pixels",
        subtype="PIXEL",
        default=STROKE_WIDTH,
        min=0.5,
        max=10.0,
        update=_changed,
    )
    stroke_colour: FloatVectorProperty(
        name="First Direction",
        description="Colour of the strokes along the larger curvature",
        default=STROKE_COLOUR,
        size=4,
        min=0.0,
        max=1.0,
        subtype="COLOR",
        update=_changed,
    )
    stroke_colour_2: FloatVectorProperty(
        name="Second Direction",
        description="Colour of the strokes along the smaller curvature",
        default=STROKE_COLOUR_2,
        size=4,
        min=0.0,
        max=1.0,
        subtype="COLOR",
        update=_changed,
    )

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        column = layout.column(heading="Overlay")
        for name in ("glyph_size", "stroke_width", "stroke_colour", "stroke_colour_2"):
            column.prop(self, name)
        column = layout.column(heading="Empties")
        column.prop(self, "empty_size")
        column.prop(self, "smallest_empty")
        column.prop(self, "most_empties")
        column = layout.column(heading="Kinds")
        for kind in core.KINDS:
            column.prop(self, f"{kind}_colour")


for _kind in core.KINDS:
    UMBILICS_preferences.__annotations__[f"{_kind}_colour"] = FloatVectorProperty(
        name=_kind.capitalize(),
        description=f"Colour of each {_kind}",
        default=KIND_COLOURS[_kind],
        size=4,
        min=0.0,
        max=1.0,
        subtype="COLOR",
        update=_changed,
    )


class Appearance:
    """Sizes and colours of the results, from the preferences where there are any."""

    def __init__(self, context: bpy.types.Context) -> None:
        add_on = context.preferences.addons.get(_ADD_ON)
        chosen = add_on.preferences if add_on is not None else None
        self.empty_size = getattr(chosen, "empty_size", EMPTY_SIZE)
        self.smallest_empty = getattr(chosen, "smallest_empty", SMALLEST_EMPTY)
        self.most_empties = getattr(chosen, "most_empties", MOST_EMPTIES)
        self.glyph_size = getattr(chosen, "glyph_size", GLYPH_SIZE)
        self.stroke_width = getattr(chosen, "stroke_width", STROKE_WIDTH)
        self.stroke_colours = (
            tuple(getattr(chosen, "stroke_colour", STROKE_COLOUR)),
            tuple(getattr(chosen, "stroke_colour_2", STROKE_COLOUR_2)),
        )
        self.colours = {
            kind: tuple(getattr(chosen, f"{kind}_colour", KIND_COLOURS[kind]))
            for kind in core.KINDS
        }


register, unregister = bpy.utils.register_classes_factory((UMBILICS_preferences,))
