"""Operator: find the umbilics of the active mesh."""

import bpy

from .. import core
from . import engine, properties, running
from .words import outcome
from .workspace import finished


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
        if running.current() is not None:
            reason = "A detection is running. Wait for it, or press Esc."
        if reason:
            cls.poll_message_set(reason)
        return not reason

    def execute(self, context):
        """Run straight through."""
        try:
            inputs = _gather(context)
            return self._write(context, inputs, engine.compute(inputs))
        except core.UmbilicsError as error:
            return self._fail(error)

    def invoke(self, context, event):
        """Run beside the window."""
        try:
            running.begin(_gather(context))
        except core.UmbilicsError as error:
            return self._fail(error)
        self._timer = context.window_manager.event_timer_add(0.05, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        run = running.current()
        if event.type == "ESC" and event.value == "PRESS":
            run.cancel()
            return {"RUNNING_MODAL"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        if not run.finished:
            running.show(context)
            return {"PASS_THROUGH"}
        self.cancel(context)
        try:
            detection = run.result()
            edited = context.mode == "EDIT_MESH"
            return finished(self._write(context, run.inputs, detection), edited)
        except core.CancelledError:
            self.report({"INFO"}, "Detection cancelled; nothing was changed.")
            return {"CANCELLED"}
        except core.UmbilicsError as error:
            return self._fail(error)

    def cancel(self, context):
        """End the thread and take the progress away, also when a file is opened or closed."""
        running.end()
        context.window_manager.event_timer_remove(self._timer)
        running.show(context)

    def _write(self, context, inputs, detection):
        engine.write(context, inputs, detection)
        level = "WARNING" if detection.warnings else "INFO"
        self.report({level}, " ".join((f"{outcome(detection)}.", *detection.warnings)))
        return {"FINISHED"}

    def _fail(self, error):
        self.report({"ERROR"}, str(error))
        return {"CANCELLED"}


def _gather(context):
    # The transforms of objects made or moved by a script are brought up to date only here.
    context.view_layer.update()
    group = context.scene.umbilics
    return engine.gather(
        context.active_object, properties.to_settings(group), properties.given_names(group)
    )


def register() -> None:
    bpy.utils.register_class(UMBILICS_OT_detect)


def unregister() -> None:
    bpy.utils.unregister_class(UMBILICS_OT_detect)
