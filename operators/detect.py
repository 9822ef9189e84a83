"""Operator: find the umbilics of the active mesh."""

import bpy

from .. import core
from . import engine, properties
from .words import outcome


class UMBILICS_OT_detect(bpy.types.Operator):
    bl_idname = "umbilics.detect"
    bl_label = "Detect Umbilics"
    bl_description = (
        "Find the points of the active mesh where the surface curves equally in all directions"
    )
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        reason = engine.why_not(context.active_object)
        if reason:
            cls.poll_message_set(reason)
        return not reason

    def execute(self, context):
        group = context.scene.umbilics
        try:
            context.view_layer.update()
            inputs = engine.gather(
                context.active_object,
                properties.to_settings(group),
                properties.given_names(group),
            )
            detection = engine.compute(inputs)
            engine.write(context, inputs, detection)
        except core.UmbilicsError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        level = "WARNING" if detection.warnings else "INFO"
        self.report({level}, " ".join((f"{outcome(detection)}.", *detection.warnings)))
        return {"FINISHED"}


def register() -> None:
    bpy.utils.register_class(UMBILICS_OT_detect)


def unregister() -> None:
    bpy.utils.unregister_class(UMBILICS_OT_detect)
