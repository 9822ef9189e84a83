"""Operator: the writing that Export Guidance starts once its files are chosen."""

from pathlib import Path

import bpy
from bpy.props import StringProperty

from .data import remeshing
from .jobs import retopology
from .jobs.modal import GuidanceOperator


class UMBILICS_OT_write_files(GuidanceOperator, bpy.types.Operator):
    bl_idname = "umbilics.write_files"
    bl_label = "Write Guidance Files"
    bl_description = "Write the guidance of the active mesh beside the window"
    # The scene stays as it is: nothing to undo.
    bl_options = {"INTERNAL"}

    filepath: StringProperty(subtype="FILE_PATH", options={"SKIP_SAVE"})
    kinds: StringProperty(description="Kinds of files, between blanks", options={"SKIP_SAVE"})

    def job(self, context):
        stem = Path(bpy.path.abspath(self.filepath)).with_suffix("")
        settings = remeshing.to_remesh_settings(context.scene.umbilics_remesh)
        work = retopology.exported(stem, self.kinds.split(), settings)
        return retopology.gather(context, context.active_object, work)

    def done(self, context, job, found):
        made = () if found.quads is None else found.quads.warnings
        wrote = f"Wrote {', '.join(path.name for path in found.paths)}."
        return " ".join((wrote, *found.left_out, *made))


def register() -> None:
    bpy.utils.register_class(UMBILICS_OT_write_files)


def unregister() -> None:
    bpy.utils.unregister_class(UMBILICS_OT_write_files)
