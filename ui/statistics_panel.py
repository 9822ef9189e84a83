"""Counts, the check of the indices, how far the results can be trusted, and warnings."""

import bpy

from .. import core
from . import kind_icons
from .parts import Part, line, paragraph

_PLURAL = {
    "star": "Stars",
    "lemon": "Lemons",
    "monstar": "Monstars",
    "compound": "Compound",
    "uncertain": "Uncertain",
}


class UMBILICS_PT_statistics(Part, bpy.types.Panel):
    bl_label = "Statistics"

    @classmethod
    def poll(cls, context):
        return context.active_object is not None and context.active_object.umbilics.detected

    def draw(self, context):
        found = context.active_object.umbilics
        table = self.layout.column(align=True)
        for kind in core.KINDS:
            count = getattr(found, kind)
            if count or kind in core.KINDS[:2]:
                icon = kind_icons.icon_of(context, kind)
                line(table, kind, _PLURAL[kind], str(count), icon_value=icon)
        if found.regions:
            line(table, "regions", "Umbilical regions", str(found.regions))
        line(table, "candidates", "Candidates", str(found.candidates))
        sums = self.layout.column(align=True)
        line(sums, "index_sum", "Index sum", f"{found.index_sum:g}")
        if found.closed:
            icon = "CHECKMARK" if found.balanced else "ERROR"
            value = f"{found.expected_index_sum:g}"
        else:
            icon, value = "NONE", f"{found.euler_characteristic} (open)"
        line(sums, "euler_characteristic", "Euler characteristic", value, icon=icon)
        numbers = self.layout.column(align=True)
        noise = f"{found.noise:.3g}" if found.noise else "unknown"
        line(numbers, "noise", "Noise", noise)
        radius = f"{found.scale:.3g}" if found.scale else "none"
        line(numbers, "scale", "Fitted radius", radius)
        name = "Strongest dropped" if found.used_persistence < 0.0 else "Dropped below"
        level = f"{found.persistence_level:.3g}" if found.persistence_level else "none"
        line(numbers, "persistence_level", name, level)
        icon = "CHECKMARK" if found.trust_ratio <= core.TRUSTED else "ERROR"
        ratio = f"{found.trust_ratio:.2f}"
        line(numbers, "trust_ratio", "Noise / median gap", ratio, icon=icon)
        for warning in found.warnings:
            paragraph(self.layout.box(), context, warning.text)


def register() -> None:
    bpy.utils.register_class(UMBILICS_PT_statistics)


def unregister() -> None:
    bpy.utils.unregister_class(UMBILICS_PT_statistics)
