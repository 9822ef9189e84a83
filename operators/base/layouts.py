"""How settings are laid out, in panels and where operators are adjusted."""

from __future__ import annotations

from typing import Any

import bpy


def split(layout: bpy.types.UILayout) -> bpy.types.UILayout:
    """The layout with names left of values and without animation dots."""
    layout.use_property_split = True
    layout.use_property_decorate = False
    return layout


def automatic(layout: bpy.types.UILayout, settings: Any, name: str) -> None:
    """A number beside the switch that leaves it to the add-on; `settings` is a group of properties
    or those of an operator."""
    row = layout.row(align=True, heading=settings.bl_rna.properties[name].name)
    row.prop(settings, f"{name}_auto", text="Auto", toggle=True)
    if not getattr(settings, f"{name}_auto"):
        row.prop(settings, name, text="")


def all_of(layout: bpy.types.UILayout, settings: Any, idle: frozenset[str] = frozenset()) -> None:
    """All properties of a group or an operator in their order, but for those that are hidden and
    the `idle` ones, which now change nothing."""
    shown = [item for item in settings.bl_rna.properties if item.identifier != "rna_type"]
    names = [item.identifier for item in shown if not item.is_hidden]
    for name in names:
        if name in idle or f"{name}_auto" in names:
            continue
        if (number := name.removesuffix("_auto")) != name and number in names:
            automatic(layout, settings, number)
        else:
            layout.prop(settings, name)
