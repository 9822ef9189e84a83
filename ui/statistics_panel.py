"""Counts, the check of the indices, how far the results can be trusted, and warnings."""

import bpy

from .. import core
from ..operators.base import units
from ..operators.scene import selection
from . import kind_icons
from .parts import Part, line, paragraph

_PLURAL = {
    "star": "Stars",
    "lemon": "Lemons",
    "monstar": "Monstars",
    "compound": "Compounds",
    "uncertain": "Uncertain",
}


class UMBILICS_PT_statistics(Part, bpy.types.Panel):
    bl_label = "Statistics"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        obj = selection.shown(context)
        return obj is not None and obj.umbilics.detected

    def draw(self, context: bpy.types.Context) -> None:
        found = selection.shown(context).umbilics
        table = self.layout.column(align=True)
        for kind in core.KINDS:
            count = getattr(found, kind)
            if count or kind in core.KINDS[:2]:
                picture = kind_icons.icon_of(context, kind)
                line(table, kind, _PLURAL[kind], str(count), icon_value=picture)
        if found.regions:
            line(table, "regions", "Umbilical regions", str(found.regions))
        line(table, "candidates", "Candidates", str(found.candidates))
        sums = self.layout.column(align=True)
        line(sums, "index_sum", "Index sum", f"{found.index_sum:g}")
        if found.closed:
            icon = "CHECKMARK" if found.balanced else "ERROR"
            value = f"{found.expected_index_sum:g}"
        else:
            count = found.euler_characteristic
            icon, value = "NONE", f"{count} (open)"
        line(sums, "euler_characteristic", "Euler characteristic", value, icon=icon)
        numbers = self.layout.column(align=True)
        scene = context.scene
        noise = units.length(scene, found.noise) if found.noise else "unknown"
        line(numbers, "noise", "Noise", noise)
        radius = units.length(scene, found.scale) if found.scale else "none"
        line(numbers, "scale", "Fitted radius", radius)
        name = "Strongest dropped" if found.used_persistence < 0.0 else "Dropped below"
        dropped = found.persistence_level
        level = units.curvature(scene, dropped) if dropped else "none"
        line(numbers, "persistence_level", name, level)
        icon, ratio = "QUESTION", "unknown"
        if found.noise:
            icon = "CHECKMARK" if found.trust_ratio <= core.TRUSTED else "ERROR"
            if not any(getattr(found, kind) for kind in core.KINDS):
                # On a sphere the gap is nothing but noise, and no umbilic hangs on it.
                icon = "NONE"
            ratio = f"{found.trust_ratio:.2f}"
        line(numbers, "trust_ratio", "Noise / median gap", ratio, icon=icon)
        for warning in found.warnings:
            paragraph(self.layout.box(), context, warning.text)


register, unregister = bpy.utils.register_classes_factory((UMBILICS_PT_statistics,))
