"""Operator: choose where the cross field, poles and lines go as files for other programs."""

import bpy
from bpy.props import BoolProperty, StringProperty
from bpy_extras.io_utils import ExportHelper

from .. import core
from .base.translation import reported
from .jobs.modal import NeedsMesh
from .write_files import stem_of

_CHOSEN = ("mesh", "rosy", "sharp")


class UMBILICS_OT_export_field(NeedsMesh, bpy.types.Operator, ExportHelper):
    bl_idname = "umbilics.export_field"
    bl_label = "Export Guidance"
    bl_description = (
        "Write the cross field, its poles and lines of curvature as files that remeshers read"
    )

    filename_ext = ".obj"
    filter_glob: StringProperty(default="*.obj;*.rosy;*.rawfield;*.dmat", options={"HIDDEN"})

    overwrite: BoolProperty(
        name="Overwrite",
        description="Replace files of these names that are there already",
        default=False,
        options={"SKIP_SAVE"},
    )

    _by_hand = False

    def draw(self, context: bpy.types.Context) -> None:
        column = self.layout.column(heading="Files")
        for kind in core.FILE_KINDS:
            column.prop(self, kind)
        there = in_the_way(self.filepath, self._kinds())
        if there:
            column = self.layout.column()
            column.label(text="Already there:", icon="ERROR")
            for name in there:
                column.label(text=name)
            column.prop(self, "overwrite")

    def _kinds(self) -> list[str]:
        return [kind for kind in core.FILE_KINDS if getattr(self, kind)]

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        self._by_hand = True
        return ExportHelper.invoke(self, context, event)

    def execute(self, context: bpy.types.Context) -> set[str]:
        kinds = self._kinds()
        if not kinds:
            self.report({"ERROR"}, reported("Choose at least one kind of file."))
            return {"CANCELLED"}
        # A script says what it wants; in the file browser only one of the names is seen.
        there = in_the_way(self.filepath, kinds) if self._by_hand and not self.overwrite else []
        if there:
            self.report(
                {"ERROR"},
                reported(f"{', '.join(there)}: already there. Choose another name, or Overwrite."),
            )
            return {"CANCELLED"}
        # An operator that came from the file browser cannot stay and wait; another one does.
        how = "INVOKE_DEFAULT" if self._by_hand else "EXEC_DEFAULT"
        try:
            done = bpy.ops.umbilics.write_files(how, filepath=self.filepath, kinds=" ".join(kinds))
        except RuntimeError as error:
            # What the other one reports as an error comes as an exception.
            self.report({"ERROR"}, reported(str(error).strip().removeprefix("Error: ")))
            return {"CANCELLED"}
        return {"CANCELLED"} if done == {"CANCELLED"} else {"FINISHED"}


def in_the_way(filepath: str, kinds: list[str]) -> list[str]:
    """Names of the files that are there already and would be written anew."""
    try:
        stem = stem_of(filepath)
    except core.UmbilicsError:
        # Said when it is to be written: a name may still be typed.
        return []
    return [path.name for path in core.guidance_paths(stem, kinds) if path.exists()]


for _kind, _about in core.FILE_KINDS.items():
    UMBILICS_OT_export_field.__annotations__[_kind] = BoolProperty(
        name=_about.label, description=_about.help, default=_kind in _CHOSEN
    )


register, unregister = bpy.utils.register_classes_factory((UMBILICS_OT_export_field,))
