"""The list of umbilics, and what can be done with one of them."""

from collections.abc import Callable

import bpy

from ..operators.base.translation import translated
from ..operators.copy_coordinates import UMBILICS_OT_copy_coordinates
from ..operators.data import summary
from ..operators.delete_umbilic import UMBILICS_OT_delete_umbilic
from ..operators.frame_umbilic import UMBILICS_OT_frame_umbilic
from ..operators.pin import UMBILICS_OT_pin
from ..operators.restore_deleted import UMBILICS_OT_restore_deleted
from ..operators.scene import selection
from . import kind_icons
from .parts import Part, short

_PERMANENT = 1e37
# Part of a row for the kind, of the rest for the index, of the rest for the persistence; and of
# the columns' names, of which the kind's needs less.
_PARTS = 0.53, 0.24, 0.52
_NAME_PARTS = 0.4, 0.38, 0.48


class UMBILICS_UL_umbilics(bpy.types.UIList):
    """One line for each umbilic: number, kind, index, persistence, mean curvature."""

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
        pinned = item.row in summary.rows_of(data.pinned)
        kind = summary.kind_of(item)
        icon = kind_icons.icon_of(context, kind)
        name, index, persistence, curvature = _columns(layout, _PARTS)
        name.label(text=f"{item.number} {translated(kind.capitalize())}", icon_value=icon)
        if pinned:
            name.label(text="", icon="PINNED")
        index.label(text=_index(item.index))
        persistence.label(text=_persistence(item.persistence))
        curvature.label(text=short(item.curvature))

    def filter_items(
        self, context: bpy.types.Context, data: bpy.types.PropertyGroup, name: str
    ) -> tuple[list[int], list[int]]:
        items = getattr(data, name)
        display = context.scene.umbilics_display
        wanted = self.filter_name.lower()
        flags = [self.bitflag_filter_item if wanted in _words(item) else 0 for item in items]
        keys: dict[str, Callable[[bpy.types.PropertyGroup], float]] = {
            "persistence": lambda item: -item.persistence,
            "importance": lambda item: -item.importance,
            "kind": lambda item: item.kind,
            "curvature": lambda item: -abs(item.curvature),
        }
        key = keys[display.sort]
        order = sorted(range(len(items)), key=lambda row: key(items[row]))
        if display.descending:
            order.reverse()
        place = [0] * len(items)
        for new, old in enumerate(order):
            place[old] = new
        return flags, place

    def draw_filter(self, context: bpy.types.Context, layout: bpy.types.UILayout) -> None:
        display = context.scene.umbilics_display
        row = layout.row(align=True)
        row.prop(self, "filter_name", text="", icon="VIEWZOOM")
        row.prop(display, "sort", text="")
        row.prop(display, "descending", text="", icon="SORT_DESC", toggle=True)


class UMBILICS_PT_list(Part, bpy.types.Panel):
    bl_label = "Umbilics"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        obj = selection.shown(context)
        return obj is not None and obj.umbilics.detected

    def draw_header_preset(self, context: bpy.types.Context) -> None:
        shown = selection.shown(context).umbilics
        self.layout.label(text=str(len(shown.items) + shown.hidden_items))

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        found = selection.shown(context).umbilics
        _draw_names(layout)
        # So few that the map's button, which comes next, is in sight on a small screen.
        shown = {"rows": 4, "maxrows": 4}
        layout.template_list("UMBILICS_UL_umbilics", "", found, "items", found, "active", **shown)
        if found.hidden_items:
            text = translated(f"and {found.hidden_items} less persistent ones")
            layout.label(text=text, icon="INFO")
        actions = layout.row(align=True)
        actions.operator(UMBILICS_OT_frame_umbilic.bl_idname, text="Frame")
        actions.operator(UMBILICS_OT_copy_coordinates.bl_idname, text="Copy")
        actions.operator(UMBILICS_OT_pin.bl_idname, text="Pin")
        actions.operator(UMBILICS_OT_delete_umbilic.bl_idname, text="", icon="X")
        if found.deleted:
            count = len(summary.rows_of(found.deleted))
            text = translated(f"Restore {count} Deleted")
            layout.operator(UMBILICS_OT_restore_deleted.bl_idname, text=text)


def _words(item: bpy.types.PropertyGroup) -> str:
    """What the list can be searched for: number and kind."""
    kind = summary.kind_of(item)
    return f"{item.number} {kind} {translated(kind.capitalize())}".lower()


def _draw_names(layout: bpy.types.UILayout) -> None:
    """What the columns of the list are, clear of the list's frame and scroll bar."""
    row = layout.row()
    row.active = False
    row.scale_y = 0.7
    row.separator(factor=0.5)
    columns = _columns(row, _NAME_PARTS)
    for column, name in zip(columns, ("Kind", "Index", "Pers.", "H"), strict=True):
        column.label(text=name)
    row.separator(factor=2.0)


def _columns(layout: bpy.types.UILayout, parts: tuple[float, ...]) -> list[bpy.types.UILayout]:
    """Columns of a row, each of such a part of what those before it leave, and the last."""
    columns = []
    for part in parts:
        layout = layout.split(factor=part, align=True)
        columns.append(layout.row(align=True))
    return [*columns, layout.row(align=True)]


def _index(value: float) -> str:
    """An index as it is written: +½, −1, +1½."""
    halves = round(2.0 * value)
    whole, half = divmod(abs(halves), 2)
    sign = "\N{MINUS SIGN}" if halves < 0 else "+"
    number = f"{whole or ''}{'½' if half else ''}"
    return f"{sign}{number}" if halves else "0"


def _persistence(value: float) -> str:
    if value > _PERMANENT:
        return "∞"
    return "–" if value < 0.0 else short(value)


register, unregister = bpy.utils.register_classes_factory((UMBILICS_UL_umbilics, UMBILICS_PT_list))
