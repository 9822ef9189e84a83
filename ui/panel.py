"""The tab "Umbilics" in the sidebar of the 3D view; sub-panels in the order of work."""

import textwrap

import bpy

from .. import core
from ..operators import running
from ..operators.add_arrows import UMBILICS_OT_add_arrows
from ..operators.cancel import UMBILICS_OT_cancel
from ..operators.clear import UMBILICS_OT_clear
from ..operators.detect import UMBILICS_OT_detect
from ..operators.properties import GIVEN_NAMES

_PLURAL = {"star": "Stars", "lemon": "Lemons", "monstar": "Monstars", "uncertain": "Uncertain"}
# Mean width of a letter of Blender's interface font, and what a box takes at its sides.
_LETTER, _MARGIN = 6.5, 60


class _Tab:
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Umbilics"


class UMBILICS_PT_main(_Tab, bpy.types.Panel):
    bl_label = "Umbilics"

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        settings = context.scene.umbilics
        column = layout.column()
        column.prop(settings, "method")
        if settings.method == "S":
            column.prop(settings, "parametrization")
        if settings.method == "C":
            column.prop(settings, "charts")
        actions = layout.column(align=True)
        run = running.current()
        if run is not None:
            actions.progress(factor=run.fraction, text=run.stage)
            actions.operator(UMBILICS_OT_cancel.bl_idname, text="Cancel", icon="CANCEL")
            return
        big = actions.row(align=True)
        big.scale_y = 1.6
        big.operator(UMBILICS_OT_detect.bl_idname, text="Detect", icon="VIEWZOOM")
        actions.operator(UMBILICS_OT_clear.bl_idname, text="Clear", icon="TRASH")


class UMBILICS_PT_result(_Tab, bpy.types.Panel):
    bl_label = "Result"
    bl_parent_id = "UMBILICS_PT_main"

    @classmethod
    def poll(cls, context):
        return context.active_object is not None and context.active_object.umbilics.detected

    def draw(self, context):
        result = context.active_object.umbilics
        table = self.layout.column(align=True)
        for kind in core.KINDS:
            count = getattr(result, kind)
            if count or kind in core.KINDS[:2]:
                _line(table, _PLURAL[kind], str(count))
        if result.regions:
            _line(table, "Umbilical regions", str(result.regions))
        _line(table, "Index sum", f"{result.index_sum:g}")
        if not result.closed:
            _line(table, "Euler characteristic", f"{result.euler_characteristic} (open)")
        else:
            _line(
                table,
                "Euler characteristic",
                f"{result.expected_index_sum:g}",
                icon="CHECKMARK" if result.balanced else "ERROR",
            )
        self.layout.operator(UMBILICS_OT_add_arrows.bl_idname, icon="ARROW_LEFTRIGHT")
        for warning in result.warnings:
            _paragraph(self.layout.box(), context, warning.text)


class UMBILICS_PT_curvature(_Tab, bpy.types.Panel):
    bl_label = "Curvature"
    bl_parent_id = "UMBILICS_PT_main"

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        settings = context.scene.umbilics
        layout.prop(settings, "curvature", text="From")
        if settings.curvature == "given":
            names = layout.column(align=True)
            for name in GIVEN_NAMES:
                names.prop(settings, f"given_{name}")
            return
        if settings.curvature == "jets":
            _automatic(layout, settings, "scale")
            if not settings.scale_auto:
                layout.prop(settings, "scale_unit", text="Unit")
        layout.prop(settings, "crease_angle")
        layout.prop(settings, "normal_smoothing", text="Smoothing")


class UMBILICS_PT_filters(_Tab, bpy.types.Panel):
    bl_label = "Filters"
    bl_parent_id = "UMBILICS_PT_main"

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        settings = context.scene.umbilics
        _automatic(layout, settings, "persistence")
        layout.prop(settings, "opening")
        if settings.opening:
            layout.prop(settings, "flatness")
        layout.prop(settings, "regions")


def _automatic(layout, settings, name: str) -> None:
    """A number beside the switch that leaves it to the add-on."""
    row = layout.row(align=True, heading=settings.bl_rna.properties[name].name)
    row.prop(settings, f"{name}_auto", text="Auto", toggle=True)
    if not getattr(settings, f"{name}_auto"):
        row.prop(settings, name, text="")


def _line(layout, name: str, value: str, icon: str = "NONE") -> None:
    split = layout.split(factor=0.65)
    split.label(text=name)
    split.label(text=value, icon=icon)


def _paragraph(layout, context, text: str) -> None:
    """Text broken into lines: a label of Blender's does not break by itself."""
    # The scale is 0 where Blender is a Python module and never had a window.
    width = context.region.width / (context.preferences.system.ui_scale or 1.0) - _MARGIN
    column = layout.column(align=True)
    column.scale_y = 0.8
    for number, line in enumerate(textwrap.wrap(text, max(int(width / _LETTER), 20))):
        column.label(text=line, icon="BLANK1" if number else "INFO")


_CLASSES = (UMBILICS_PT_main, UMBILICS_PT_result, UMBILICS_PT_curvature, UMBILICS_PT_filters)


def register() -> None:
    for cls in _CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
