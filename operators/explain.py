"""Operator: the name of a number, which says what it is when the mouse rests on it."""

import bpy
from bpy.props import StringProperty

from .data import summary


class UMBILICS_OT_explain(bpy.types.Operator):
    bl_idname = "umbilics.explain"
    bl_label = "Explain"
    bl_options = {"INTERNAL"}

    number: StringProperty(description="Name of the number", options={"SKIP_SAVE"})

    @classmethod
    def description(
        cls, _context: bpy.types.Context, properties: bpy.types.OperatorProperties
    ) -> str:
        # Blender ends it with a full stop.
        words = summary.UMBILICS_PG_summary.bl_rna.properties[properties.number].description
        explained = bpy.app.translations.pgettext_tip(words)
        click = bpy.app.translations.pgettext_tip("Click for the manual")
        return f"{explained}. {click}"

    def execute(self, _context: bpy.types.Context) -> set[str]:
        return bpy.ops.wm.doc_view_manual(doc_id=f"UMBILICS_PG_summary.{self.number}")


register, unregister = bpy.utils.register_classes_factory((UMBILICS_OT_explain,))
