"""Operator: find the umbilics of the active mesh and of the other selected ones."""

from dataclasses import replace

import bpy
from bpy.props import BoolProperty

from .. import core
from .base.words import outcome, pins_lost
from .data import properties, reading
from .jobs import detect, refusals
from .jobs.modal import BackgroundOperator, Message, possible
from .mesh.scope import Scope
from .scene import selection
from .scene.transaction import Transaction


class UMBILICS_OT_detect(BackgroundOperator, bpy.types.Operator):
    bl_idname = "umbilics.detect"
    bl_label = "Detect Umbilics"
    bl_description = (
        "Find the umbilics of the active mesh and of the other selected ones: the points where "
        "the surface curves equally in all directions"
    )

    again: BoolProperty(
        name="Same Faces",
        description="Where the scope is what is selected or visible, take the faces of the last "
        "detection, whatever is selected or visible now",
        options={"HIDDEN", "SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return possible(cls, why_not(context))

    def jobs(
        self, context: bpy.types.Context
    ) -> tuple[list[detect.Inputs], list[core.UmbilicsError]]:
        scene = context.scene
        settings = properties.to_settings(scene.umbilics)
        depsgraph = context.evaluated_depsgraph_get() if _with_modifiers(context) else None
        scope = reading.scope_of(scene.umbilics_display)
        names = properties.given_names(scene.umbilics)
        jobs, refused = [], []
        for obj in selection.wanted(context):
            try:
                mine = replace(scope, kept=self.again and _was_of(obj, scope))
                job = detect.gather(obj, settings, names, depsgraph=depsgraph, scope=mine)
                jobs.append(job)
            except core.UmbilicsError as error:
                refused.append(error)
        return jobs, refused

    def put(
        self,
        context: bpy.types.Context,
        job: detect.Inputs,
        found: detect.Results,
        whole: Transaction | None,
    ) -> list[Message]:
        lost = detect.write(context, job, found, whole)
        detection = found.detection
        level = "WARNING" if detection.warnings else "INFO"
        messages = [(level, " ".join((f"{outcome(detection)}.", *detection.warnings)))]
        return [*messages, ("WARNING", pins_lost(lost))] if lost else messages


def _was_of(obj: bpy.types.Object | None, scope: Scope) -> bool:
    """Whether the object's last detection had that scope, too."""
    return obj is not None and obj.type == "MESH" and obj.umbilics.scope == scope.kind


def why_not(context: bpy.types.Context) -> str:
    """Why nothing can be detected, in words for the user; empty if something can."""
    modified = _with_modifiers(context)
    wanted = selection.wanted(context)
    whys = [refusals.why_not(obj, with_modifiers=modified) for obj in wanted]
    return "" if "" in whys else whys[0]


def _with_modifiers(context: bpy.types.Context) -> bool:
    return context.scene.umbilics_display.source == "EVALUATED"


register, unregister = bpy.utils.register_classes_factory((UMBILICS_OT_detect,))
