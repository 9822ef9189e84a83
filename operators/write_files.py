"""Operator: the writing that Export Guidance starts once its files are chosen."""

from pathlib import Path

import bpy
from bpy.props import StringProperty

from .. import core
from .base.errors import FileError
from .data import remeshing
from .jobs import retopology, works
from .jobs.modal import GuidanceOperator
from .scene import selection


class UMBILICS_OT_write_files(GuidanceOperator, bpy.types.Operator):
    bl_idname = "umbilics.write_files"
    bl_label = "Write Guidance Files"
    bl_description = "Write the guidance of the active mesh beside the window"
    # The scene stays as it is: nothing to undo.
    bl_options = {"INTERNAL"}

    filepath: StringProperty(subtype="FILE_PATH", options={"SKIP_SAVE"})
    kinds: StringProperty(description="Kinds of files, between blanks", options={"SKIP_SAVE"})

    def job(self, context: bpy.types.Context) -> retopology.Job:
        stem = stem_of(self.filepath)
        settings = remeshing.to_remesh_settings(context.scene.umbilics_remesh)
        work = works.exported(stem, self.kinds.split(), settings)
        return retopology.gather(context, selection.shown(context), work, steered=True)

    def done(self, context: bpy.types.Context, job: retopology.Job, found: core.Written) -> str:
        made = () if found.quads is None else found.quads.warnings
        wrote = f"Wrote {', '.join(path.name for path in found.paths)}."
        return " ".join((wrote, *found.left_out, *made))


def stem_of(filepath: str) -> Path:
    """What the names of all files begin with, from the one that was chosen.

    Raises
    ------
    FileError
        No file is named.
    """
    path = Path(bpy.path.abspath(filepath))
    # Of a folder's own name files would be made beside it.
    if not path.name or path.is_dir():
        raise FileError("Name a file: its ending is replaced by those of the chosen kinds.")
    return path.with_suffix("")


register, unregister = bpy.utils.register_classes_factory((UMBILICS_OT_write_files,))
