"""What all operators share whose work takes long: background and window, progress, Esc, reports.

The protocol has three steps. An operator gathers from the scene (`jobs`), jobs compute (arrays
only, see `worker.Job`), and the operator writes (`put`).
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from dataclasses import replace
from typing import Any

import bpy

from ... import core
from ..base.translation import reported
from ..base.words import outcome, pins_lost
from ..data import properties, reading
from ..mesh.scope import Scope
from ..scene import selection, targets
from ..scene.modes import Place, finished, in_place, objects_mode, place_of
from ..scene.transaction import Transaction, all_or_nothing
from . import detect, refusals, retopology, worker

RUNNING = "Something is being computed. Wait for it, or press Esc."


def possible(operator: type[bpy.types.Operator], reason: str = "") -> bool:
    """Whether there is no reason against an operator and nothing is computed; for its `poll`,
    which tells the user why not."""
    if worker.current() is not None:
        reason = RUNNING
    if reason:
        operator.poll_message_set(reported(reason))
    return not reason


# A level of Blender's reports, and a sentence.
Message = tuple[str, str]


class BackgroundOperator:
    """A mixin of operators that run beside the window, and straight through from a script."""

    bl_options = {"REGISTER", "UNDO"}

    # `bpy.types.Operator` has it.
    report: Callable[[set[str], str], None]

    @abstractmethod
    def jobs(
        self, context: bpy.types.Context
    ) -> tuple[Sequence[worker.Job], list[core.UmbilicsError]]:
        """What to compute, and why some of what is wanted is left out; the scene is only read.

        Raises
        ------
        core.UmbilicsError
            There is nothing to compute.
        """

    @abstractmethod
    def put(
        self, context: bpy.types.Context, job: Any, found: Any, whole: Transaction | None
    ) -> list[Message]:
        """Write what a job, one of `jobs`, has found; what to tell the user.

        Of several jobs each is a part of the `whole`, and their objects are in Object Mode.

        Raises
        ------
        core.UmbilicsError
            It cannot be written; the scene is as it was.
        """

    def unwritten(self, context: bpy.types.Context) -> None:
        """Called when nothing was written: the user stopped it, or an error was reported."""

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Run straight through."""
        try:
            jobs, refused = self._gathered(context)
        except core.UmbilicsError as error:
            return self._fail(context, [error])
        outcomes = [worker.outcome_of(job) for job in jobs]
        return self._write(context, jobs, outcomes, refused, place_of(context))

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Run beside the window."""
        try:
            jobs, self._refused = self._gathered(context)
        except core.UmbilicsError as error:
            return self._fail(context, [error])
        if not jobs:
            return self._fail(context, self._refused)
        # The window may show another scene by the time that there is something to write.
        self._place = place_of(context)
        worker.begin(*jobs)
        self._timer = context.window_manager.event_timer_add(0.05, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        task = worker.current()
        if task is None:
            # Whoever ended it, as by opening a file, has taken the progress away.
            return {"CANCELLED"}
        if event.type == "ESC" and event.value == "PRESS":
            task.cancel()
            return {"RUNNING_MODAL"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        if not task.finished:
            worker.show(context)
            return {"PASS_THROUGH"}
        self.cancel(context)
        try:
            outcomes = task.results()
        except core.CancelledError:
            self.unwritten(context)
            self.report({"INFO"}, reported("Cancelled; nothing was changed."))
            return {"CANCELLED"}
        edited = context.mode == "EDIT_MESH"
        done = self._write(context, task.jobs, outcomes, self._refused, self._place)
        return finished(done, edited)

    def cancel(self, context: bpy.types.Context) -> None:
        """End the thread and take the progress away, also when a file is opened or closed."""
        worker.end()
        context.window_manager.event_timer_remove(self._timer)
        worker.show(context)

    def _gathered(
        self, context: bpy.types.Context
    ) -> tuple[Sequence[worker.Job], list[core.UmbilicsError]]:
        # The transforms of objects made or moved by a script are brought up to date only here.
        context.view_layer.update()
        return self.jobs(context)

    def _write(
        self,
        context: bpy.types.Context,
        jobs: Sequence[worker.Job],
        outcomes: Sequence[Any],
        refused: Sequence[core.UmbilicsError],
        place: Place,
    ) -> set[str]:
        errors, written = list(refused), []
        several = len(jobs) > 1
        try:
            with (
                in_place(context, place),
                objects_mode(context, _objects_of(jobs) if several else ()),
                all_or_nothing() if several else nullcontext() as whole,
            ):
                for job, found in zip(jobs, outcomes, strict=True):
                    try:
                        if isinstance(found, core.UmbilicsError):
                            raise found
                        written.append((job.object_name, self.put(context, job, found, whole)))
                    except core.UmbilicsError as error:
                        errors.append(error)
        except core.UmbilicsError as error:
            errors.append(error)
        if not written:
            return self._fail(context, errors)
        for name, messages in written:
            whose = f"{name}: " if len(jobs) + len(refused) > 1 else ""
            for level, sentence in messages:
                self.report({level}, reported(f"{whose}{sentence}"))
        for reason in errors:
            self.report({"WARNING"}, reported(str(reason)))
        return {"FINISHED"}

    def _fail(
        self, context: bpy.types.Context, errors: Sequence[core.UmbilicsError]
    ) -> set[str]:
        self.unwritten(context)
        self.report({"ERROR"}, reported(" ".join(str(error) for error in errors)))
        return {"CANCELLED"}


def _objects_of(jobs: Sequence[worker.Job]) -> list[bpy.types.Object]:
    found = [targets.named(job.object_name) for job in jobs]
    return [obj for obj in found if obj is not None]


class DetectionOperator(BackgroundOperator):
    """A mixin of operators that detect on all objects that are wanted."""

    # Whether to take the faces of the last detection, where the scope is what is selected or seen.
    again = False

    def jobs(
        self, context: bpy.types.Context
    ) -> tuple[list[detect.Inputs], list[core.UmbilicsError]]:
        scene = context.scene
        settings = properties.to_settings(scene.umbilics)
        depsgraph = context.evaluated_depsgraph_get() if with_modifiers(context) else None
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


def with_modifiers(context: bpy.types.Context) -> bool:
    """Whether what is seen is analysed, modifiers and shape keys included."""
    return bool(context.scene.umbilics_display.source == "EVALUATED")


def _was_of(obj: bpy.types.Object | None, scope: Scope) -> bool:
    """Whether the object's last detection had that scope, too."""
    return obj is not None and obj.type == "MESH" and obj.umbilics.scope == scope.kind


class NeedsMesh:
    """A mixin: possible where the active object can be guided and nothing else is computed."""

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        evaluated = with_modifiers(context)
        reason = refusals.why_not(selection.active(context), with_modifiers=evaluated)
        return possible(cls, reason)


class GuidanceOperator(NeedsMesh, BackgroundOperator):
    """A mixin of operators that make one thing of the active mesh; what `warnings(found)` says is
    told as well."""

    @abstractmethod
    def job(self, context: bpy.types.Context) -> retopology.Job:
        """The one of `jobs`."""

    @abstractmethod
    def done(self, context: bpy.types.Context, job: retopology.Job, found: Any) -> str:
        """As `put`, with a sentence for the user."""

    def jobs(self, context: bpy.types.Context) -> tuple[list[retopology.Job], list[Any]]:
        return [self.job(context)], []

    def put(
        self,
        context: bpy.types.Context,
        job: retopology.Job,
        found: Any,
        whole: Transaction | None,
    ) -> list[Message]:
        # Nothing is left to fail when all is written.
        warnings = (*self.warnings(found), *job.notes)
        sentence = self.done(context, job, found)
        return [("INFO", sentence), *(("WARNING", text) for text in warnings)]

    def warnings(self, found: Any) -> Sequence[str]:
        """Sentences on what of it could not be had."""
        return ()
