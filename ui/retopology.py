"""The sub-panel "Retopology": the plan of a quad mesh, its lines, files and symmetry."""

import bpy

from ..operators.add_pole import UMBILICS_OT_add_pole
from ..operators.align_to_other import UMBILICS_OT_align_to_other
from ..operators.align_to_x import UMBILICS_OT_align_to_x
from ..operators.base.layouts import automatic, split
from ..operators.base.translation import translated
from ..operators.check_topology import UMBILICS_OT_check_topology
from ..operators.data import plans, remeshing, topology
from ..operators.draw_guides import UMBILICS_OT_draw_guides
from ..operators.export_field import UMBILICS_OT_export_field
from ..operators.guide import UMBILICS_OT_guide
from ..operators.jobs import worker
from ..operators.lines import UMBILICS_OT_lines
from ..operators.new_retopology import UMBILICS_OT_new_retopology
from ..operators.preview_layout import UMBILICS_OT_preview_layout
from ..operators.remesh_to_quads import UMBILICS_OT_remesh_to_quads
from ..operators.ridges import UMBILICS_OT_ridges
from ..operators.rotation_symmetry import UMBILICS_OT_rotation_symmetry
from ..operators.scene import selection, staleness
from ..operators.scene.retopology import by_hand, guidance_objects
from ..operators.separatrices import UMBILICS_OT_separatrices
from ..operators.show_check import UMBILICS_OT_show_check
from ..operators.symmetry import UMBILICS_OT_symmetry
from .menus import mark_menus
from .parts import Part, Tab, paragraph

_STATE_ICON = ("CHECKMARK", "ADD", "CANCEL")
_ICON = {3: "MESH_ICOSPHERE", 5: "MESH_CUBE"}


class UMBILICS_UL_poles(bpy.types.UIList):
    """Poles: valence, where each comes from, how sure it is."""

    def draw_item(
        self,
        context: bpy.types.Context,
        layout: bpy.types.UILayout,
        data: bpy.types.PropertyGroup,
        item: bpy.types.PropertyGroup,
        icon: int,
        active_data: bpy.types.PropertyGroup,
        active_property: str,
    ) -> None:
        change = plans.change_of(item)
        row = layout.split(factor=0.2)
        row.active = change != "deleted"
        row.label(text=str(item.valence), icon=_ICON.get(item.valence, "DOT"))
        rest = row.split(factor=0.7)
        rest.label(text=", ".join(map(translated, filter(None, (item.origin, change)))))
        rest.label(text=f"{100.0 * item.confidence:.0f} %")


class UMBILICS_PT_retopology(Part, bpy.types.Panel):
    bl_label = "Retopology"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 50

    def draw(self, context: bpy.types.Context) -> None:
        layout = split(self.layout)
        layout.active = worker.current() is None
        group, obj = context.scene.umbilics_guidance, selection.shown(context)
        column = layout.column()
        automatic(column, group, "smoothness")
        column.prop(group, "plan")
        if obj is not None and obj.type == "MESH":
            column.prop_search(group, "zone", obj, "vertex_groups")
        column.prop(group, "strokes")
        if group.strokes is not None:
            column.prop(group, "influence", slider=True)
        layout.operator(UMBILICS_OT_guide.bl_idname, icon="EMPTY_AXIS")
        if obj is None or not obj.umbilics_plan.planned:
            return
        plan = obj.umbilics_plan
        layout.template_list(
            "UMBILICS_UL_poles", "", plan, "poles", plan, "active", rows=3, maxrows=8
        )
        count = guidance_objects.pole_sum(obj)
        halves = layout.split(factor=0.65)
        halves.label(text="Sum of 4 - valence")
        if not plan.closed:
            halves.label(text=translated(f"{count} (open)"))
        else:
            icon = "CHECKMARK" if count == plan.expected else "ERROR"
            halves.label(text=translated(f"{count} of {plan.expected}"), icon=icon)
        _by_hand(layout, context, obj)
        reasons = staleness.plan_reasons(context, obj)
        if reasons:
            box = layout.box()
            paragraph(box, context, " ".join(["Plan out of date.", *reasons]), icon="ERROR")
            box.operator(UMBILICS_OT_guide.bl_idname, text="Plan Again", icon="FILE_REFRESH")
        layout.prop(context.scene.umbilics_display, "field", text="Strokes Show")


def _by_hand(layout: bpy.types.UILayout, context: bpy.types.Context, obj: bpy.types.Object) -> None:
    """What the user did to the poles, what becomes of it, and what the plan could not hold."""
    plan = obj.umbilics_plan
    for sentence in filter(None, plan.warnings.split("\n")):
        paragraph(layout, context, sentence, icon="ERROR")
    layout.operator_menu_enum(UMBILICS_OT_add_pole.bl_idname, "valence", icon="ADD")
    if plan.poles and not by_hand.poles_there(obj):
        told = (
            "No pole is left: they were deleted, or stayed with what this is a copy of. Plan again."
        )
        paragraph(layout, context, told)
    if not by_hand.is_steered(obj):
        return
    if by_hand.is_changed(obj):
        told = "Poles were moved, added or deleted by hand. Plan Poles bends the field after them."
    else:
        told = "The poles are those set by hand, and stay so."
    paragraph(layout, context, told)
    free = layout.operator(UMBILICS_OT_guide.bl_idname, text="Plan Without Hand", icon="LOOP_BACK")
    free.by_hand = False


class UMBILICS_PT_quads(Tab, bpy.types.Panel):
    bl_label = "Quads"
    bl_parent_id = "UMBILICS_PT_retopology"

    def draw(self, context: bpy.types.Context) -> None:
        layout = split(self.layout)
        layout.active = worker.current() is None
        group = context.scene.umbilics_remesh
        idle = remeshing.idle(group)
        if "quads" not in idle:
            layout.prop(group, "quads")
        automatic(layout, group, "edge_length")
        layout.prop(group, "symmetry")
        if "mirror_single" not in idle:
            layout.prop(group, "mirror_single")
        layout.prop(group, "adaptivity", slider=True)
        layout.prop(group, "smoothness", slider=True)
        layout.operator(UMBILICS_OT_preview_layout.bl_idname, icon="VIEW_ORTHO")
        column = layout.column(heading="Result")
        for name in ("hide_original", "shrinkwrap", "transfer"):
            column.prop(group, name)
        layout.operator(UMBILICS_OT_remesh_to_quads.bl_idname, icon="MESH_GRID")
        obj = context.active_object
        if obj is not None and obj.type == "MESH":
            _check(layout, context, obj, with_table=False)


class UMBILICS_PT_features(Tab, bpy.types.Panel):
    bl_label = "Align To"
    bl_parent_id = "UMBILICS_PT_retopology"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout = split(self.layout)
        group = context.scene.umbilics_guidance
        for name in ("feature_angle", "align_sharp", "align_borders", "align_crests"):
            layout.prop(group, name)


class UMBILICS_PT_lines(Tab, bpy.types.Panel):
    bl_label = "Lines"
    bl_parent_id = "UMBILICS_PT_retopology"

    def draw(self, context: bpy.types.Context) -> None:
        layout = split(self.layout)
        layout.active = worker.current() is None
        group = context.scene.umbilics_guidance
        layout.prop(group, "families")
        automatic(layout, group, "spacing")
        layout.prop(group, "closest")
        automatic(layout, group, "line_smoothness")
        layout.prop(group, "shortest")
        layout.operator(UMBILICS_OT_lines.bl_idname, icon="CURVE_DATA")
        automatic(layout, group, "length_limit")
        layout.operator(UMBILICS_OT_separatrices.bl_idname, icon="CURVE_PATH")
        layout.operator(UMBILICS_OT_draw_guides.bl_idname, icon="OUTLINER_OB_GREASEPENCIL")
        marks = layout.row(align=True)
        mark_menus(marks)


class UMBILICS_PT_ridges(Tab, bpy.types.Panel):
    bl_label = "Ridges"
    bl_parent_id = "UMBILICS_PT_retopology"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout = split(self.layout)
        layout.active = worker.current() is None
        group = context.scene.umbilics_guidance
        layout.prop(group, "least_bend", slider=True)
        layout.prop(group, "ridge_kinds")
        layout.operator(UMBILICS_OT_ridges.bl_idname, icon="MOD_EDGESPLIT")


class UMBILICS_UL_marks(bpy.types.UIList):
    """Irregular vertices and planned poles of a check: valence, and what each is."""

    def draw_item(
        self,
        context: bpy.types.Context,
        layout: bpy.types.UILayout,
        data: bpy.types.PropertyGroup,
        item: bpy.types.PropertyGroup,
        icon: int,
        active_data: bpy.types.PropertyGroup,
        active_property: str,
    ) -> None:
        state = ("Matched", "Extra", "Missing")[item.state]
        row = layout.split(factor=0.25)
        row.label(text=str(item.valence), icon=_STATE_ICON[item.state])
        row.label(text=translated(state))


def _check(
    layout: bpy.types.UILayout,
    context: bpy.types.Context,
    obj: bpy.types.Object,
    with_table: bool,
) -> None:
    """How well the mesh follows its surface."""
    kept = obj.umbilics_check
    if not kept.checked:
        return
    box = layout.box()
    sound = kept.quads == kept.faces and kept.jacobian > 0.0 and not kept.folded
    name = kept.against
    text = f"Against {name}" if sound else "Not all faces are sound quads"
    paragraph(box, context, text, icon="CHECKMARK" if sound else "ERROR")
    for line in topology.sentences(kept):
        paragraph(box, context, line, icon="NONE")
    for sentence in filter(None, kept.warnings.split("\n")):
        paragraph(box, context, sentence, icon="ERROR")
    if kept.planned:
        box.prop(kept, "own_plan")
    reasons = staleness.check_reasons(context, obj)
    if reasons:
        paragraph(box, context, " ".join(["Check out of date.", *reasons]), icon="ERROR")
        box.operator(UMBILICS_OT_check_topology.bl_idname, text="Check Again", icon="FILE_REFRESH")
    box.operator(UMBILICS_OT_show_check.bl_idname, icon="COLOR")
    if with_table:
        box.template_list("UMBILICS_UL_marks", "", kept, "marks", kept, "active", rows=3, maxrows=8)


class UMBILICS_PT_check(Tab, bpy.types.Panel):
    bl_label = "By Hand and Check"
    bl_parent_id = "UMBILICS_PT_retopology"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout = split(self.layout)
        layout.active = worker.current() is None
        layout.operator(UMBILICS_OT_new_retopology.bl_idname, icon="ADD")
        obj = selection.shown(context)
        if obj is None or obj.type != "MESH":
            return
        kept = obj.umbilics_check
        layout.prop(kept, "surface")
        layout.operator(UMBILICS_OT_check_topology.bl_idname, icon="VIEWZOOM")
        _check(layout, context, obj, with_table=True)


class UMBILICS_PT_hand_over(Tab, bpy.types.Panel):
    bl_label = "Export and Symmetry"
    bl_parent_id = "UMBILICS_PT_retopology"

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        layout.active = worker.current() is None
        layout.operator(UMBILICS_OT_export_field.bl_idname, icon="EXPORT")
        column = layout.column(align=True)
        column.operator(UMBILICS_OT_symmetry.bl_idname, icon="MOD_MIRROR")
        column.operator(UMBILICS_OT_align_to_x.bl_idname, icon="ORIENTATION_GIMBAL")
        column.operator(UMBILICS_OT_rotation_symmetry.bl_idname, icon="FILE_REFRESH")
        column.operator(UMBILICS_OT_align_to_other.bl_idname, icon="SNAP_ON")
        obj = selection.shown(context)
        if obj is not None and obj.umbilics_plan.mirror:
            layout.label(text=translated(obj.umbilics_plan.mirror))
        if obj is not None and obj.umbilics_plan.axis:
            layout.label(text=translated(obj.umbilics_plan.axis))


register, unregister = bpy.utils.register_classes_factory(
    (
        UMBILICS_UL_poles,
        UMBILICS_UL_marks,
        UMBILICS_PT_retopology,
        UMBILICS_PT_quads,
        UMBILICS_PT_features,
        UMBILICS_PT_lines,
        UMBILICS_PT_ridges,
        UMBILICS_PT_check,
        UMBILICS_PT_hand_over,
    )
)
