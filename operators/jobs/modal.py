"""What the operators of the guidance share: background and window, progress, Esc, reports."""

from __future__ import annotations

from ... import core
from ..scene.modes import finished
from . import detect, worker

RUNNING = "Something is being computed. Wait for it, or press Esc."


class NeedsMesh:
    """A mixin: possible where the active object can be guided and nothing else is computed."""

    @classmethod
    def poll(cls, context):
        evaluated = context.scene.umbilics_display.source == "EVALUATED"
        reason = detect.why_not(context.active_object, with_modifiers=evaluated)
        if worker.current() is not None:
            reason = RUNNING
        if reason:
            cls.poll_message_set(reason)
        return not reason


class GuidanceOperator(NeedsMesh):
    """A mixin. Subclasses have `job(context)`, which gathers, and `put(context, job, found)`,
    which writes and answers with a sentence for the user."""

    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        """Run straight through."""
        try:
            context.view_layer.update()
            job = self.job(context)
            return self._write(context, job, worker.outcome_of(job))
        except core.UmbilicsError as error:
            return self._fail(error)

    def invoke(self, context, event):
        """Run beside the window."""
        try:
            context.view_layer.update()
            worker.begin(self.job(context))
        except core.UmbilicsError as error:
            return self._fail(error)
        self._timer = context.window_manager.event_timer_add(0.05, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        run = worker.current()
        if event.type == "ESC" and event.value == "PRESS":
            run.cancel()
            return {"RUNNING_MODAL"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        if not run.finished:
            worker.show(context)
            return {"PASS_THROUGH"}
        self.cancel(context)
        edited = context.mode == "EDIT_MESH"
        try:
            return finished(self._write(context, run.jobs[0], run.results()[0]), edited)
        except core.CancelledError:
            self.report({"INFO"}, "Cancelled; nothing was changed.")
            return {"CANCELLED"}
        except core.UmbilicsError as error:
            return self._fail(error)

    def cancel(self, context):
        """End the thread and take the progress away, also when a file is opened or closed."""
        worker.end()
        context.window_manager.event_timer_remove(self._timer)
        worker.show(context)

    def _write(self, context, job, found):
        if isinstance(found, core.UmbilicsError):
            raise found
        self.report({"INFO"}, self.put(context, job, found))
        return {"FINISHED"}

    def _fail(self, error):
        self.report({"ERROR"}, str(error))
        return {"CANCELLED"}
