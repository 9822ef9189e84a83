"""What is analysed, and what is shown of the results and how; one group for each scene."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty

from ... import core
from ..base import property_groups
from ..base.changes import notify
from . import reading, record
from .belonging import active_mesh
from .strength import get_strength, put_strength

KIND_ITEMS = [
    ("star", "Stars", "Index -1/2, three separatrices", 1),
    ("lemon", "Lemons", "Index +1/2, one separatrix", 2),
    ("monstar", "Monstars", "Index +1/2, three separatrices", 4),
    ("compound", "Compounds", "Another index: several that are not told from each other", 16),
    ("uncertain", "Uncertain", "The index and the cubic form disagree about the kind", 8),
]
MAPS = [
    ("k1", "κ₁", "Larger principal curvature: how strongly the surface bends at most"),
    ("k2", "κ₂", "Smaller principal curvature: how strongly the surface bends at least"),
    ("mean", "Mean H", "Mean curvature, half the sum of the principal curvatures"),
    ("gauss", "Gauss K", "Gaussian curvature, their product: above 0 domes, below 0 saddles"),
    ("gap", "Gap κ₁ - κ₂", "How far the principal curvatures differ; 0 at an umbilic"),
    ("type", "Surface Type", "Peaks, pits, ridges, valleys and saddles, by the signs of H and K"),
    ("region", "Regions", "Spherical and flat areas and curves of umbilics"),
]
FIELDS = [
    (
        "PRINCIPAL",
        "Principal Directions",
        "The lines of curvature. Strokes fade where the curvatures are nearly equal, since a "
        "direction means nothing there",
    ),
    (
        "CROSS",
        "Cross Field",
        "The smoothed field of the last Plan Poles, which a quad mesh follows: both arms of each "
        "cross, and it has a direction everywhere",
    ),
]
SORTS = [
    ("persistence", "Persistence", "The most certain umbilics first"),
    ("importance", "Importance", "Those first whose persistence is largest against their error"),
    ("kind", "Kind", "Stars, lemons, monstars, compounds, uncertain"),
    ("curvature", "Curvature", "The most strongly curved places first"),
]


def _filter_changed(self: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    notify("filter", context)


def _view_changed(self: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    notify("view", context)


def _glyphs_changed(self: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    notify("glyphs", context)
    notify("view", context)


def _map_changed(self: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    notify("map", context)


def _get_opened(self: bpy.types.PropertyGroup) -> bool:
    return self.id_data.umbilics.opening > 0


def _set_opened(self: bpy.types.PropertyGroup, value: bool) -> None:
    settings = self.id_data.umbilics
    kept = record.of(active_mesh())
    usual = (kept.settings.opening if kept else 0) or core.USUAL_OPENING
    settings.opening = usual if value else 0


class UMBILICS_PG_display(bpy.types.PropertyGroup):
    """What is shown; one for each scene."""

    strength: FloatProperty(
        name="Strength",
        description="Drag to thin out the umbilics: pairs that cancel more easily go first. "
        "Nothing is computed again",
        subtype="FACTOR",
        min=0.0,
        max=1.0,
        precision=3,
        get=get_strength,
        set=put_strength,
    )
    opened: BoolProperty(
        name="Opening",
        description="Keep only umbilics inside broad elliptic parts of the surface, where both "
        "curvatures have one sign",
        get=_get_opened,
        set=_set_opened,
    )
    kinds: EnumProperty(
        name="Kinds",
        description="Kinds of umbilics that are shown; hold Shift to choose several",
        items=KIND_ITEMS,
        options={"ENUM_FLAG"},
        default=set(core.KINDS),
        update=_filter_changed,
    )
    empties: BoolProperty(
        name="Empties",
        description="Put an empty at each umbilic, to snap to, export or animate. Without them "
        "the overlay draws the umbilics and the scene stays tidy",
        default=True,
        update=_filter_changed,
    )
    overlay: BoolProperty(
        name="Overlay",
        description="Draw the results over the 3D views; nothing is added to the scene",
        default=True,
        update=_glyphs_changed,
    )
    directions: BoolProperty(
        name="Directions",
        description="Strokes along a field of directions",
        default=True,
        update=_view_changed,
    )
    field: EnumProperty(
        name="Field",
        description="Which directions the strokes show",
        items=FIELDS,
        default="PRINCIPAL",
        update=_view_changed,
    )
    crosses: BoolProperty(
        name="Both Directions",
        description="Draw the direction of the smaller curvature as well, as a cross",
        default=False,
        update=_view_changed,
    )
    density: FloatProperty(
        name="Spacing",
        description="Distance between strokes on the screen, in pixels",
        subtype="PIXEL",
        default=20.0,
        min=8.0,
        max=100.0,
        update=_view_changed,
    )
    glyphs: BoolProperty(
        name="Glyphs",
        description="A star with three points, a lemon's drop and a monstar's three narrow "
        "fingers, where there is no empty that shows them",
        default=True,
        update=_glyphs_changed,
    )
    poles: BoolProperty(
        name="Poles",
        description="The poles of the last plan: a triangle with a 3 where three edges should "
        "meet, a pentagon with a 5 where five should",
        default=True,
        update=_glyphs_changed,
    )
    checks: BoolProperty(
        name="Check Marks",
        description="Of a topology that was checked: a green disc where a vertex stands for a "
        "planned pole, a yellow diamond where it is extra, a red hexagon where a pole has none",
        default=True,
        update=_view_changed,
    )
    numbers: BoolProperty(
        name="Numbers",
        description="The number of each umbilic, which it has in the list, the outliner and the "
        "table of poles as well. Without them that of the active one is drawn",
        default=False,
        update=_view_changed,
    )
    rays: BoolProperty(
        name="Separatrices",
        description="Rays along which a line of curvature runs into the umbilic: three at stars "
        "and monstars, one at lemons",
        default=True,
        update=_view_changed,
    )
    dropped: BoolProperty(
        name="Show Dropped",
        description="Draw faintly, as hollow glyphs, the umbilics that the opening leaves out",
        default=False,
        update=_view_changed,
    )
    discs: BoolProperty(
        name="Uncertainty",
        description="A circle as wide as the standard error of the umbilic's place",
        default=False,
        update=_view_changed,
    )
    map: EnumProperty(
        name="Map",
        description="What the colours show",
        items=MAPS,
        default="gap",
        update=_map_changed,
    )
    percentile: FloatProperty(
        name="Outliers",
        description="Share of the values at either end that the range of the colours leaves out, "
        "so that a few extremes do not wash out the rest",
        subtype="PERCENTAGE",
        default=2.0,
        min=0.0,
        max=25.0,
        precision=1,
        update=_map_changed,
    )
    lock_range: BoolProperty(
        name="Lock Range",
        description="Keep the range of the colours, to compare objects or steps of your work",
        default=False,
        update=_map_changed,
    )
    range_low: FloatProperty(
        name="From",
        description="Value at the lower end of the colours, in 1 / length or 1 / length²",
        default=0.0,
        precision=4,
        update=_map_changed,
    )
    range_high: FloatProperty(
        name="To",
        description="Value at the upper end of the colours, in 1 / length or 1 / length²",
        default=1.0,
        precision=4,
        update=_map_changed,
    )
    sort: EnumProperty(
        name="Sort By",
        description="Order of the list",
        items=SORTS,
        default="persistence",
    )
    descending: BoolProperty(name="Reverse", description="Turn the order round", default=False)
    preset: StringProperty(description="Name of the preset that was chosen last")
    legend: BoolProperty(
        name="Legend",
        description="Colours and their values in a corner of the view",
        default=True,
        update=_view_changed,
    )
    text_size: IntProperty(
        name="Text Size",
        description="Size of the legend's text, in points",
        default=12,
        min=6,
        max=48,
        update=_view_changed,
    )


UMBILICS_PG_display.__annotations__ |= reading.properties()


register, unregister = property_groups.factory(
    (UMBILICS_PG_display,), (bpy.types.Scene, "umbilics_display", UMBILICS_PG_display)
)
