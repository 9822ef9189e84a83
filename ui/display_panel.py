"""What is drawn over the view, and the map of curvature."""

import bpy

from ..operators.base.layouts import split
from ..operators.hide_map import UMBILICS_OT_hide_map
from ..operators.scene import selection
from ..operators.scene.view import maps, view_shading
from ..operators.show_map import UMBILICS_OT_show_map
from .parts import Part


class UMBILICS_PT_map(Part, bpy.types.Panel):
    bl_label = "Map"

    def draw(self, context: bpy.types.Context) -> None:
        layout = split(self.layout)
        display = context.scene.umbilics_display
        row = layout.row(align=True)
        row.prop(display, "map", text="")
        row.operator(UMBILICS_OT_show_map.bl_idname, text="Show Map", icon="COLOR")
        shown = maps.is_shown_on(selection.shown(context))
        changed = context.area is not None and view_shading.is_changed(context.screen, context.area)
        if shown or changed:
            layout.operator(UMBILICS_OT_hide_map.bl_idname, text="Put Back", icon="LOOP_BACK")
        if display.map in maps.POWER:
            row = layout.row(align=True)
            row.active = not display.lock_range
            row.prop(display, "percentile")
            row.prop(
                display, "lock_range", text="", icon="LOCKED" if display.lock_range else "UNLOCKED"
            )
            if display.lock_range:
                ends = layout.column(align=True)
                ends.prop(display, "range_low")
                ends.prop(display, "range_high")
        layout.prop(display, "legend")


class UMBILICS_PT_overlay(Part, bpy.types.Panel):
    bl_label = "Overlay"

    def draw_header(self, context: bpy.types.Context) -> None:
        self.layout.prop(context.scene.umbilics_display, "overlay", text="")

    def draw(self, context: bpy.types.Context) -> None:
        layout = split(self.layout)
        display, obj = context.scene.umbilics_display, selection.shown(context)
        layout.active = display.overlay
        strokes = layout.column(heading="Directions")
        strokes.prop(display, "directions", text="Strokes")
        if display.directions:
            strokes.prop(display, "field")
            if display.field == "PRINCIPAL":
                strokes.prop(display, "crosses")
            elif obj is None or not obj.umbilics_plan.planned:
                strokes.label(text="None yet: Plan Poles makes it", icon="INFO")
            strokes.prop(display, "density")
        marks = layout.column(heading="Umbilics")
        marks.prop(display, "glyphs")
        marks.prop(display, "numbers")
        marks.prop(display, "rays")
        marks.prop(display, "discs")
        plan = layout.column(heading="Plan")
        plan.prop(display, "poles")
        plan.prop(display, "checks")


register, unregister = bpy.utils.register_classes_factory((UMBILICS_PT_map, UMBILICS_PT_overlay))
