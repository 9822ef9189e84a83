"""The detection that runs beside the window, in a thread that touches arrays only."""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence

import bpy

from ... import core
from . import detect

# Seconds between two looks of the user's at the progress.
PACE = 0.25

_current: Run | None = None
_shown: tuple[str | None, float] = (None, 0.0)


class Run:
    """Detections on one or more meshes in a worker thread, which `results` joins.

    Attributes
    ----------
    fraction, stage:
        How much is done, 0 to 1, and what is being done, for the user.
    """

    def __init__(self, jobs: Sequence[detect.Inputs]) -> None:
        self.jobs = jobs
        self.fraction = 0.0
        self.stage = "Starting"
        self._stop = threading.Event()
        self._name = ""
        self._outcomes: list[detect.Found | core.UmbilicsError] = []
        self._error: BaseException | None = None
        self._thread = threading.Thread(target=self._work, name="umbilics")

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

    def results(self) -> list[detect.Found | core.UmbilicsError]:
        """Wait for the worker; for each job its detection, or why there is none.

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

    def _work(self) -> None:
        progress = core.Progress(self._report, self._stop.is_set)
        count = len(self.jobs)
        try:
            for number, job in enumerate(self.jobs):
                self._name = f"{job.object_name}: " if count > 1 else ""
                part = progress.part("", number / count, (number + 1) / count)
                self._outcomes.append(outcome_of(job, part))
        except BaseException as error:  # raised again in the main thread by `results`
            self._error = error

    def _report(self, fraction: float, stage: str) -> None:
        if not self.cancelled:
            # Parts may run beside each other; a bar that goes back would only worry.
            self.fraction = max(self.fraction, fraction)
            self.stage = f"{self._name}{stage}" if stage else self.stage


def outcome_of(
    job: detect.Inputs, progress: core.Progress | None = None
) -> detect.Found | core.UmbilicsError:
    """What the job has found, or why there is none; `CancelledError` is raised."""
    try:
        if hasattr(job, "compute"):
            return job.compute(progress)
        return detect.found(job, detect.compute(job, progress))
    except core.CancelledError:
        raise
    except core.UmbilicsError as error:
        return error


def current() -> Run | None:
    """The detection that is running, if there is one."""
    return _current


def begin(*jobs: detect.Inputs) -> Run:
    """Start detections beside the window, one after the other; there is one run at a time."""
    global _current
    _current = Run(jobs)
    _current.start()
    return _current


def end() -> None:
    """Stop the running detection, if there is one, and wait until its thread is gone."""
    global _current
    if _current is None:
        return
    if not _current.finished:
        _current.cancel()
    _current.join()
    _current = None


def show(context: bpy.types.Context) -> None:
    """Progress in the status bar and in the panels; without a detection, take it away.

    Nothing is drawn again unless the text is another one: a sidebar that overlaps its view has
    the whole view drawn with it.
    """
    global _shown
    text = None
    if _current is not None:
        text = f"Umbilics: {_current.stage} ({_current.fraction:.0%})     Esc: Cancel"
    now = time.monotonic()
    if text is not None and (text == _shown[0] or now - _shown[1] < PACE):
        return
    _shown = (text, now)
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
