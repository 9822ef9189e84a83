"""What the panels of the tab share."""

from __future__ import annotations

import textwrap

import bpy

from ..operators.base.translation import translated
from ..operators.explain import UMBILICS_OT_explain

# Mean width of a letter of Blender's interface font, and what a box takes at its sides.
_LETTER, _MARGIN = 6.5, 60


class Tab:
    """Mixed into the panels of the sidebar's tab."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Umbilics"


class Part(Tab):
    """Mixed into the sub-panels; a property's name stands left of its value."""

    bl_parent_id = "UMBILICS_PT_main"


def short(value: float) -> str:
    """A number in at most six letters: 0.0123, 1.23, 123, 1.2k, 3.4M."""
    size = abs(value)
    if size >= 1e9 or 0.0 < size < 1e-4:
        return f"{value:.0e}".replace("e-0", "e-").replace("e+0", "e+").replace("e+", "e")
    for unit, letter in ((1e6, "M"), (1e3, "k")):
        if size >= 0.9995 * unit:
            return f"{value / unit:.{0 if size >= 9.95 * unit else 1}f}{letter}"
    return f"{value:.2g}" if size < 0.01 else f"{value:.{2 if size < 9.95 else 0}f}"


def line(
    layout: bpy.types.UILayout,
    number: str,
    name: str,
    value: str,
    icon_value: int = 0,
    icon: str = "NONE",
) -> None:
    """A number of the summary: its name, which explains itself, and its value.

    `icon_value` stands beside the name, `icon` beside the value.
    """
    halves = layout.split(factor=0.6)
    explained(halves, number, name, icon_value=icon_value)
    halves.label(text=translated(value), icon=icon)


def explained(
    layout: bpy.types.UILayout, number: str, text: str, icon_value: int = 0, alignment: str = "LEFT"
) -> None:
    """Text that says, when the mouse rests on it, what a number of the summary is."""
    row = layout.row()
    row.alignment = alignment
    name = UMBILICS_OT_explain.bl_idname
    row.operator(name, text=translated(text), icon_value=icon_value, emboss=False).number = number


def paragraph(
    layout: bpy.types.UILayout, context: bpy.types.Context, text: str, icon: str = "INFO"
) -> None:
    """Text broken into lines: a label of Blender's does not break by itself."""
    width = context.region.width / context.preferences.system.ui_scale
    column = layout.column(align=True)
    column.scale_y = 0.8
    for number, words in enumerate(broken(translated(text), width)):
        column.label(text=words, icon="BLANK1" if number and icon != "NONE" else icon)


def broken(text: str, width: float) -> list[str]:
    """The text in lines that fit a region so many pixels wide at a scale of one."""
    return textwrap.wrap(text, max(int((width - _MARGIN) / _LETTER), 20))
