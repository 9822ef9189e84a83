"""Operator: methods S, I and C, and the usual ways beside them, on the active mesh."""

from collections.abc import Callable
from dataclasses import dataclass

import bpy

from .. import core
from .base.translation import translated
from .data import properties, reading
from .jobs import detect
from .jobs.modal import BackgroundOperator, Message, NeedsMesh
from .scene import selection
from .scene.transaction import Transaction

_NUMBERS = ("points", "index sum", "missed", "elsewhere", "edges away", "seconds")


@dataclass(frozen=True)
class _Comparison:
    """What was gathered of the mesh, to be given to all methods."""

    inputs: detect.Inputs

    @property
    def object_name(self) -> str:
        return self.inputs.object_name

    def compute(self, progress: core.Progress | None = None) -> tuple[core.MethodResult, ...]:
        return detect.compare(self.inputs, progress)


class UMBILICS_OT_compare(NeedsMesh, BackgroundOperator, bpy.types.Operator):
    bl_idname = "umbilics.compare"
    bl_label = "Compare Methods"
    bl_description = (
        "Run methods S, I and C on the same curvatures of the active mesh, and the usual ways that "
        "look at vertices alone, and show what each finds; the scene stays as it is"
    )
    bl_options = {"REGISTER"}

    def jobs(
        self, context: bpy.types.Context
    ) -> tuple[list[_Comparison], list[core.UmbilicsError]]:
        scene = context.scene
        evaluated = scene.umbilics_display.source == "EVALUATED"
        inputs = detect.gather(
            selection.active(context),
            properties.to_settings(scene.umbilics),
            properties.given_names(scene.umbilics),
            all_methods=True,
            depsgraph=context.evaluated_depsgraph_get() if evaluated else None,
            scope=reading.scope_of(scene.umbilics_display),
        )
        return [_Comparison(inputs)], []

    def put(
        self,
        context: bpy.types.Context,
        job: _Comparison,
        found: tuple[core.MethodResult, ...],
        whole: Transaction | None,
    ) -> list[Message]:
        if not bpy.app.background:
            title = translated(f"{job.object_name}: what each method finds")
            rows = core.comparison_rows(found)
            context.window_manager.popup_menu(_drawing(rows, found), title=title)
        return [("INFO", core.comparison_table(found))]


def _drawing(
    rows: list[list[str]], results: tuple[core.MethodResult, ...]
) -> Callable[[bpy.types.Menu, bpy.types.Context], None]:
    """Draws the table in columns, and why a method was refused below it."""
    columns = [0, *(rows[0].index(name) for name in _NUMBERS)]

    def draw(menu: bpy.types.Menu, _context: bpy.types.Context) -> None:
        flow = menu.layout.row()
        for k in columns:
            column = flow.column()
            for row in rows:
                text = row[k].capitalize() if row is rows[0] else row[k]
                column.label(text=translated(text))
        for result in results:
            if result.refusal:
                reason = translated(str(result.refusal))
                menu.layout.label(text=f"{result.method}: {reason}", icon="ERROR")

    return draw


register, unregister = bpy.utils.register_classes_factory((UMBILICS_OT_compare,))
