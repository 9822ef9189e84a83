"""The tab "Umbilics" in the sidebar of the 3D view; sub-panels in the order of work."""

import bpy

from .. import core
from ..operators.apply_filters import UMBILICS_OT_apply_filters
from ..operators.base import verdict
from ..operators.base.layouts import automatic, split
from ..operators.base.translation import translated
from ..operators.cancel import UMBILICS_OT_cancel
from ..operators.clear import UMBILICS_OT_clear
from ..operators.clear_file import UMBILICS_OT_clear_file
from ..operators.compare import UMBILICS_OT_compare
from ..operators.data.properties import GIVEN_NAMES
from ..operators.detect import UMBILICS_OT_detect, why_not
from ..operators.jobs import worker
from ..operators.mend import UMBILICS_OT_mend
from ..operators.scene import filters, selection, staleness
from .parts import Part, Tab, explained, paragraph, short
from .presets import UMBILICS_PT_presets


class UMBILICS_PT_main(Tab, bpy.types.Panel):
    bl_label = "Umbilics"

    def draw_header_preset(self, context: bpy.types.Context) -> None:
        UMBILICS_PT_presets.draw_panel_header(self.layout)

    def draw(self, context: bpy.types.Context) -> None:
        layout = split(self.layout)
        _source(layout, context)
        actions = layout.column(align=True)
        run = worker.current()
        if run is not None:
            actions.progress(factor=run.fraction, text=translated(run.stage))
            actions.operator(UMBILICS_OT_cancel.bl_idname, text="Cancel", icon="CANCEL")
            return
        big = actions.row(align=True)
        big.scale_y = 1.6
        big.operator(UMBILICS_OT_detect.bl_idname, text="Detect", icon="VIEWZOOM")
        clearing = actions.row(align=True)
        clearing.operator(UMBILICS_OT_clear.bl_idname, text="Clear", icon="TRASH")
        clearing.operator(UMBILICS_OT_clear_file.bl_idname, text="All in File")
        reason = why_not(context)
        if reason:
            # The button alone is grey without a word.
            paragraph(layout, context, reason)
        obj = selection.shown(context)
        if obj is not None and obj.umbilics.detected:
            _verdict(layout, context, obj.umbilics)
            _freshness(layout, context, obj)


class UMBILICS_PT_filters(Part, bpy.types.Panel):
    bl_label = "Filters"

    def draw(self, context: bpy.types.Context) -> None:
        layout = split(self.layout)
        settings, display = context.scene.umbilics, context.scene.umbilics_display
        if filters.with_results(context):
            layout.prop(display, "strength", slider=True)
        automatic(layout, settings, "persistence")
        _dropped(layout, context)
        layout.prop(settings, "at_most", text="Most Important")
        row = layout.row(heading="Opening")
        row.prop(display, "opened", text="")
        if settings.opening:
            row.prop(settings, "opening", text="Passes")
            layout.prop(settings, "flatness")
            layout.prop(display, "dropped")
        # In two rows, so that the map's button is in sight, and no name is cut short.
        kinds = layout.grid_flow(row_major=True, columns=3, even_columns=True, align=True)
        kinds.use_property_split = False
        for kind in core.KINDS:
            kinds.prop_enum(display, "kinds", kind)
        row = layout.row(heading="Empties")
        row.prop(display, "empties", text="")
        if display.empties and context.space_data is not None:
            # The view's own switch: from a mesh whose origin is far off they are in the way.
            overlay = context.space_data.overlay
            row.prop(overlay, "show_relationship_lines", text="Dashed Lines", toggle=True)
        without = filters.without_empty(context, selection.shown(context))
        if without:
            words = (
                f"{without} less persistent umbilics have no empty. How many may have one is set "
                "in the add-on's preferences."
            )
            paragraph(layout, context, words)


class UMBILICS_PT_method(Part, bpy.types.Panel):
    bl_label = "Method"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout = split(self.layout)
        settings = context.scene.umbilics
        layout.prop(settings, "method")
        if settings.method == "S":
            layout.prop(settings, "parametrization")
            layout.prop(settings, "triangles")
        if settings.method == "C" or (
            settings.method == "S" and settings.parametrization == "charts"
        ):
            layout.prop(settings, "charts")
        layout.operator(UMBILICS_OT_compare.bl_idname, icon="SPREADSHEET")
        layout.prop(settings, "curvature")
        layout.prop(settings, "regions")
        layout.prop(settings, "merge")
        layout.prop(settings, "join_borders")
        if settings.curvature == "given":
            names = layout.column(align=True)
            for name in GIVEN_NAMES:
                names.prop(settings, f"given_{name}")
            return
        if settings.curvature == "jets":
            automatic(layout, settings, "scale")
            if not settings.scale_auto:
                layout.prop(settings, "scale_unit", text="Unit")
        automatic(layout, settings, "crease_angle")
        layout.prop(settings, "crease_marks")
        layout.prop(settings, "normal_smoothing", text="Smoothing")
        row = layout.row()
        row.active = settings.normal_smoothing > 0
        row.prop(settings, "normal_filter", text="By")


def _source(layout: bpy.types.UILayout, context: bpy.types.Context) -> None:
    """What of the object is analysed."""
    display, obj = context.scene.umbilics_display, selection.shown(context)
    layout.prop(display, "source")
    layout.prop(display, "scope")
    if display.scope != "GROUP":
        return
    if obj is not None and obj.type == "MESH":
        layout.prop_search(display, "scope_group", obj, "vertex_groups")
    else:
        layout.prop(display, "scope_group")


def _verdict(
    layout: bpy.types.UILayout, context: bpy.types.Context, summary: bpy.types.PropertyGroup
) -> None:
    """What was analysed, what was found, how far it can be trusted, and what would mend it."""
    judged = verdict.verdict(summary)
    icon = "CHECKMARK" if judged.is_good else "ERROR" if judged.remedy else "QUESTION"
    box = layout.box()
    paragraph(box, context, f"{judged.found}: {judged.trust}", icon=icon)
    if summary.analysed:
        paragraph(box, context, summary.analysed, icon="BLANK1")
    if judged.remedy:
        label = verdict.LABELS[judged.remedy]
        button = box.operator(UMBILICS_OT_mend.bl_idname, text=label, icon="MODIFIER")
        button.way = judged.remedy


def _dropped(layout: bpy.types.UILayout, context: bpy.types.Context) -> None:
    """What Persistence made of the active object's pairs, in a line.

    There is always one: a slider loses the mouse if rows come and go while it is dragged.
    """
    obj = selection.shown(context)
    if obj is None or not obj.umbilics.detected:
        return
    found = obj.umbilics
    number = "noise_multiple"
    if found.used_persistence >= 0.0:
        number = "candidates"
        count = sum(getattr(found, kind) for kind in core.KINDS)
        words = f"{count} of {found.candidates} kept"
    elif not found.candidates:
        words = "No candidates"
    elif not found.noise_multiple:
        words = "Noise unknown: none dropped"
    elif not found.persistence_level:
        words = f"None below {found.noise_multiple:.1f} × noise"
    else:
        strongest = short(found.persistence_level)
        words = f"Dropped up to {found.noise_multiple:.1f} × noise ({strongest})"
    explained(layout, number, words, alignment="RIGHT")


def _freshness(
    layout: bpy.types.UILayout, context: bpy.types.Context, obj: bpy.types.Object
) -> None:
    """Say what the results do not show any more, with the click that mends it."""
    reasons = staleness.reasons(context, obj)
    if reasons:
        box = layout.box()
        paragraph(box, context, " ".join(["Out of date.", *reasons]), icon="ERROR")
        refresh = box.operator(UMBILICS_OT_detect.bl_idname, text="Refresh", icon="FILE_REFRESH")
        refresh.again = True
    elif staleness.filters_differ(context, obj):
        box = layout.box()
        paragraph(box, context, "These results went through other filters.")
        box.operator(UMBILICS_OT_apply_filters.bl_idname, text="Apply Filters", icon="FILTER")


register, unregister = bpy.utils.register_classes_factory(
    (UMBILICS_PT_main, UMBILICS_PT_filters, UMBILICS_PT_method)
)
