"""Operator: find the umbilics of the active mesh and of the other selected ones."""

import bpy

from .. import core
from .base.words import outcome, pins_lost
from .data import properties, reading
from .jobs import detect, worker
from .scene import selection
from .scene.modes import finished


class UMBILICS_OT_detect(bpy.types.Operator):
    bl_idname = "umbilics.detect"
    bl_label = "Detect Umbilics"
    bl_description = (
        "Find the umbilics of the active mesh and of the other selected ones: the points where "
        "the surface curves equally in all directions"
    )
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        modified = _with_modifiers(context)
        wanted = selection.wanted(context)
        whys = [detect.why_not(obj, with_modifiers=modified) for obj in wanted]
        reason = "" if "" in whys else whys[0]
        if worker.current() is not None:
            reason = "A detection is running. Wait for it, or press Esc."
        if reason:
            cls.poll_message_set(reason)
        return not reason

    def execute(self, context):
        """Run straight through."""
        try:
            jobs, refused = _gather(context)
        except core.UmbilicsError as error:
            return self._fail([error])
        return self._write(context, jobs, [worker.outcome_of(job) for job in jobs], refused)

    def invoke(self, context, event):
        """Run beside the window."""
        try:
            jobs, self._refused = _gather(context)
        except core.UmbilicsError as error:
            return self._fail([error])
        if not jobs:
            return self._fail(self._refused)
        worker.begin(*jobs)
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
        try:
            outcomes = run.results()
        except core.CancelledError:
            self.report({"INFO"}, "Detection cancelled; nothing was changed.")
            return {"CANCELLED"}
        edited = context.mode == "EDIT_MESH"
        return finished(self._write(context, run.jobs, outcomes, self._refused), edited)

    def cancel(self, context):
        """End the thread and take the progress away, also when a file is opened or closed."""
        worker.end()
        context.window_manager.event_timer_remove(self._timer)
        worker.show(context)

    def _write(self, context, jobs, outcomes, refused):
        errors, written = list(refused), 0
        for job, found in zip(jobs, outcomes, strict=True):
            try:
                if isinstance(found, core.UmbilicsError):
                    raise found
                lost = detect.write(context, job, found)
            except core.UmbilicsError as error:
                errors.append(error)
                continue
            written += 1
            detection = found.detection
            level = "WARNING" if detection.warnings else "INFO"
            name = f"{job.object_name}: " if len(jobs) + len(refused) > 1 else ""
            self.report({level}, " ".join((f"{name}{outcome(detection)}.", *detection.warnings)))
            if lost:
                self.report({"WARNING"}, f"{name}{pins_lost(lost)}")
        if not written:
            return self._fail(errors)
        for error in errors:
            self.report({"WARNING"}, str(error))
        return {"FINISHED"}

    def _fail(self, errors):
        self.report({"ERROR"}, " ".join(str(error) for error in errors))
        return {"CANCELLED"}


def _gather(context):
    """What to compute, and why some of the wanted objects are left out."""
    # The transforms of objects made or moved by a script are brought up to date only here.
    context.view_layer.update()
    scene = context.scene
    settings = properties.to_settings(scene.umbilics)
    depsgraph = context.evaluated_depsgraph_get() if _with_modifiers(context) else None
    scope = reading.scope_of(scene.umbilics_display)
    jobs, refused = [], []
    for obj in selection.wanted(context):
        try:
            names = properties.given_names(scene.umbilics)
            job = detect.gather(obj, settings, names, depsgraph=depsgraph, scope=scope)
            jobs.append(job)
        except core.UmbilicsError as error:
            refused.append(error)
    return jobs, refused


def _with_modifiers(context) -> bool:
    return context.scene.umbilics_display.source == "EVALUATED"


def register() -> None:
    bpy.utils.register_class(UMBILICS_OT_detect)


def unregister() -> None:
    bpy.utils.unregister_class(UMBILICS_OT_detect)
