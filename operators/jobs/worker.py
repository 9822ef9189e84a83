"""The task that runs beside the window, in a thread that touches arrays only."""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence
from typing import Any, Protocol

import bpy

from ... import core
from ..base.translation import translated

# Seconds between two looks of the user's at the progress.
PACE = 0.25

# The running task, if there is one.
_running: list[BackgroundTask] = []


class Job(Protocol):
    """What was gathered from the scene, to be computed; an operator writes what comes of it."""

    @property
    def object_name(self) -> str:
        """Of the object that it is about, for the user."""

    def compute(self, progress: core.Progress | None = None) -> Any:
        """The work: arrays in and out, so that any thread may run it.

        Raises
        ------
        core.UmbilicsError
            It cannot be done; the text says why.
        """


class BackgroundTask:
    """Jobs that are computed one after the other in a worker thread, which `results` joins.

    Attributes
    ----------
    fraction, stage:
        How much is done, 0 to 1, and what is being done, for the user.
    """

    def __init__(self, jobs: Sequence[Job]) -> None:
        self.jobs = jobs
        self.fraction = 0.0
        self.stage = "Starting"
        self._stop = threading.Event()
        self._name = ""
        self._outcomes: list[Any] = []
        self._error: BaseException | None = None
        self._thread = threading.Thread(target=self._work, name="umbilics")
        self._shown = "", 0.0

    def start(self) -> None:
        self._thread.start()

    def cancel(self) -> None:
        """Ask the worker to stop at its next step."""
        self.stage = "Cancelling"
        self._stop.set()

    @property
    def cancelled(self) -> bool:
        return self._stop.is_set()

    @property
    def finished(self) -> bool:
        return not self._thread.is_alive()

    def join(self) -> None:
        self._thread.join()

    def results(self) -> list[Any]:
        """Wait for the worker; for each job what `outcome_of` says.

        Raises
        ------
        core.CancelledError
            The user stopped it, be it after the last step.
        """
        self.join()
        if self.cancelled:
            raise core.CancelledError("Cancelled.")
        if self._error is not None:
            raise self._error
        return self._outcomes

    def news(self) -> str:
        """What the status bar should say; nothing if that is what it said just now."""
        done = f"{self.fraction:.0%}"
        text = translated(f"Umbilics: {self.stage} ({done})     Esc: Cancel")
        now = time.monotonic()
        if text == self._shown[0] or now - self._shown[1] < PACE:
            return ""
        self._shown = text, now
        return text

    def _work(self) -> None:
        progress = core.Progress(self._report, self._stop.is_set)
        count = len(self.jobs)
        try:
            for number, job in enumerate(self.jobs):
                self._name = f"{job.object_name}: " if count > 1 else ""
                part = progress.part("", number / count, (number + 1) / count)
                self._outcomes.append(outcome_of(job, part))
        except BaseException as error:  # noqa: BLE001 (raised again in the main thread by `results`)
            self._error = error

    def _report(self, fraction: float, stage: str) -> None:
        if not self.cancelled:
            # Parts may run beside each other; a bar that goes back would only worry.
            self.fraction = max(self.fraction, fraction)
            self.stage = f"{self._name}{stage}" if stage else self.stage


def outcome_of(job: Job, progress: core.Progress | None = None) -> Any:
    """What the job has found, or the `UmbilicsError` that says why there is nothing.

    `CancelledError` is raised.
    """
    try:
        return job.compute(progress)
    except core.CancelledError:
        raise
    except core.UmbilicsError as error:
        return error


def current() -> BackgroundTask | None:
    """The task that is running, if there is one."""
    return _running[0] if _running else None


def begin(*jobs: Job) -> BackgroundTask:
    """Start jobs beside the window, one after the other; there is one task at a time."""
    task = BackgroundTask(jobs)
    _running.append(task)
    task.start()
    return task


def end() -> None:
    """Stop the running task, if there is one, and wait until its thread is gone."""
    for task in _running:
        if not task.finished:
            task.cancel()
        task.join()
    _running.clear()


def show(context: bpy.types.Context) -> None:
    """Progress in the status bar and in the panels; without a task, take it away.

    Nothing is drawn again unless the text is another one: a sidebar that overlaps its view has
    the whole view drawn with it.
    """
    task = current()
    text = None if task is None else task.news()
    if text == "":
        return
    if text is None:
        # The user may have gone to another workspace meanwhile.
        for workspace in bpy.data.workspaces:
            workspace.status_text_set(None)
    else:
        context.workspace.status_text_set(text)
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                for region in area.regions:
                    if region.type == "UI":
                        region.tag_redraw()


def register() -> None:
    pass


def unregister() -> None:
    end()
