"""Operator: write the cross field, poles and lines for other programs."""

from pathlib import Path

import bpy
from bpy.props import BoolProperty, StringProperty
from bpy_extras.io_utils import ExportHelper

from .. import core
from . import engine, guiding, running
from .guidance_operator import RUNNING

_CHOSEN = ("mesh", "rosy", "sharp")


class UMBILICS_OT_export_field(bpy.types.Operator, ExportHelper):
    bl_idname = "umbilics.export_field"
    bl_label = "Export Guidance"
    bl_description = (
        "Write the cross field, its poles and lines of curvature as files that remeshers read"
    )

    filename_ext = ".obj"
    filter_glob: StringProperty(default="*.obj;*.rosy;*.rawfield;*.dmat", options={"HIDDEN"})

    @classmethod
    def poll(cls, context):
        reason = engine.why_not(context.active_object)
        if running.current() is not None:
            reason = RUNNING
        if reason:
            cls.poll_message_set(reason)
        return not reason

    def draw(self, context):
        column = self.layout.column(heading="Files")
        for kind in core.FILE_KINDS:
            column.prop(self, kind)

    def execute(self, context):
        kinds = [kind for kind in core.FILE_KINDS if getattr(self, kind)]
        if not kinds:
            self.report({"ERROR"}, "Choose at least one kind of file.")
            return {"CANCELLED"}
        try:
            context.view_layer.update()
            job = guiding.gather(context, context.active_object, guiding.exported(kinds))
            written = core.write_guidance(
                Path(bpy.path.abspath(self.filepath)).with_suffix(""), kinds, job.compute()
            )
        except core.UmbilicsError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, f"Wrote {', '.join(path.name for path in written)}.")
        return {"FINISHED"}


for _kind, _about in core.FILE_KINDS.items():
    UMBILICS_OT_export_field.__annotations__[_kind] = BoolProperty(
        name=_about.label, description=_about.help, default=_kind in _CHOSEN
    )


def register() -> None:
    bpy.utils.register_class(UMBILICS_OT_export_field)


def unregister() -> None:
    bpy.utils.unregister_class(UMBILICS_OT_export_field)
