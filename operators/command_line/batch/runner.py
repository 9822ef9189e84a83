"""The batch itself: starts a process for each file, keeps the journal, ends with a summary."""

from __future__ import annotations

import contextlib
import errno
import hashlib
import shutil
import sys
import tempfile
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from itertools import chain
from pathlib import Path
from typing import Any

from .. import exit_codes, messages
from ..files import damage
from ..files.guard import OverwriteError, shown
from ..files.importers import SUFFIXES
from ..stopping import Stop
from . import journal, lock, machine, summary
from .display import Display, duration
from .plan import Plan, Task
from .worker import DeliveryError, Worker, identity

# Memory of a process with a file of so many bytes, besides Blender itself: what a mesh becomes.
# Measured on files of 1.3 million triangles; see docs/batch.md.
_PER_BYTE = 30
# How often the processes are looked after, in seconds.
_PAUSE = 0.05


def run(plan: Plan, blender: list[str], stop: Stop | None = None) -> int:
    """Do the batch; its exit code. `blender` starts the command for one file.

    Raises
    ------
    OSError
        The folder of the results or the summary cannot be written.
    BusyError
        Another batch is at work in the folder.
    """
    plan.out.mkdir(parents=True, exist_ok=True)
    with lock.held(plan.out, f"batch{plan.suffix}"):
        # Before hours of work, not after.
        _check_writable(plan.summary)
        kept = journal.Journal(plan.journal, fresh=not plan.resume)
        with (
            _scratch(plan.out, f"running{plan.suffix}") as scratch,
            contextlib.ExitStack() as stack,
        ):
            beside = None
            if plan.guide:
                beside = stack.enter_context(_scratch(plan.guide, f"guiding{plan.suffix}"))
            batch = _Batch(plan, blender, kept, scratch, beside, stop)
            try:
                batch.run()
            finally:
                batch.stop_workers()
        # Only what this batch is about: an earlier one may have had other files.
        entries = [kept.entries[task.name] for task in plan.tasks if task.name in kept.entries]
        entries = journal.ended(entries)
        if kept.trouble:
            messages.complain(f"{kept.trouble}; --resume will not know all.")
        summary.write_report(plan.summary, entries)
    code = _conclude(entries, plan.summary, len(plan.tasks) - len(entries))
    if kept.trouble:
        return exit_codes.FAILED
    return exit_codes.DONE if code == exit_codes.FAILED and plan.tolerant else code


def summarize(out: Path, report: Path | None) -> int:
    """One summary of all the parts in a folder; the exit code that they have together."""
    entries: dict[str, dict[str, Any]] = {}
    journals = sorted(out.glob("report*.jsonl"))
    if not journals:
        messages.complain(f"{shown(out)}: no batch has been at work there, so there is no summary.")
        return exit_codes.FAILED
    for path in journals:
        entries |= {entry["name"]: entry for entry in journal.ended(journal.read(path))}
    report = report or out / "report.csv"
    summary.write_report(report, list(entries.values()))
    return _conclude(list(entries.values()), report, 0)


def _conclude(entries: list[dict[str, Any]], report: Path, missing: int) -> int:
    failed = [entry for entry in entries if entry["status"] != "done"]
    for entry in failed:
        messages.say(shown(summary.in_words(entry)) + "\n", sys.stderr)
    text = f"{len(entries) - len(failed)} done, {len(failed)} failed"
    if missing:
        text += f", {missing} not done: the same command with --resume does them"
    messages.say(f"{text}; summary in {shown(report)}\n", sys.stderr)
    if missing:
        return exit_codes.INTERRUPTED
    return exit_codes.FAILED if failed else exit_codes.DONE


def _check_writable(path: Path) -> None:
    """Raise OSError if a file cannot be written there; what is there stays as it is."""
    if path.is_dir():
        raise IsADirectoryError(errno.EISDIR, "it is a folder", str(path))
    if path.exists() and not path.is_file():
        # A pipe or a device, which is written to as it is.
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    try:
        with tempfile.TemporaryFile(dir=path.parent):
            pass
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from error


@contextmanager
def _scratch(folder: Path, name: str) -> Iterator[Path]:
    """A folder for what is not complete yet, on the file system where it will be; removed
    afterwards, with what killed batches have left."""
    folder.mkdir(parents=True, exist_ok=True)
    prefix = f".umbilics-{name}."
    for left in folder.glob(f"{prefix}*"):
        shutil.rmtree(left, ignore_errors=True)
    # A name of its own: what a killed batch left running may still write into its folder.
    scratch = Path(tempfile.mkdtemp(prefix=prefix, dir=folder))
    try:
        yield scratch
    finally:
        shutil.rmtree(scratch, ignore_errors=True)


class _Batch:
    """The files still to do and the processes that are running."""

    def __init__(
        self,
        plan: Plan,
        blender: list[str],
        kept: journal.Journal,
        scratch: Path,
        beside: Path | None,
        stop: Stop | None,
    ) -> None:
        self._plan = plan
        self._command = blender
        self._journal = kept
        self._scratch = scratch
        self._beside = beside
        self._running: list[Worker] = []
        key = repr((plan.worker_arguments, plan.key))
        self._digest = hashlib.sha256(key.encode("utf-8", "surrogatepass")).hexdigest()[:16]
        self._stop = stop or Stop()

    def run(self) -> None:
        plan, stopping = self._plan, self._stop.asked
        waiting = [task for task in plan.tasks if not self._is_done(task)]
        total, skipped = len(waiting), len(plan.tasks) - len(waiting)
        display = Display(total, sys.stderr)
        jobs, memory = _shares(waiting, plan.jobs, plan.memory_limit)
        display.say(
            f"{total} files to do{f', {skipped} done before' if skipped else ''}; "
            f"{jobs} at a time, each with at most {memory >> 20} MB of memory."
        )
        if plan.events:
            messages.tell("batch", files=total, skipped=skipped)
        start = time.monotonic()
        waiting.reverse()
        ended = 0
        while (waiting and not stopping()) or self._running:
            finished = []
            while waiting and len(self._running) < jobs and not stopping():
                number = str(total - len(waiting) + 1)
                refused = self._start(waiting.pop(), number, memory)
                finished += [refused] if refused else []
            if not finished:
                time.sleep(_PAUSE)
            if stopping():
                self.stop_workers()
            finished += self._ended()
            for entry in finished:
                ended += 1
                self._journal.add(entry)
                display.ended(shown(summary.in_words(entry)), entry["status"] != "done")
                if plan.events:
                    _tell(entry, ended, total)
            display.tick()
        display.close()
        display.say(f"Took {duration(time.monotonic() - start)}.")

    def _ended(self) -> list[dict[str, Any]]:
        """The entries of the processes that have ended since the last look, whose results are in
        their places then."""
        found = []
        for worker in [w for w in self._running if w.has_ended(self._plan.time_limit)]:
            self._running.remove(worker)
            found.append(self._outcome(worker))
            worker.clear()
        return found

    def stop_workers(self) -> None:
        """End what is running; what it was about is not done."""
        for worker in self._running:
            worker.stop()
        self._running.clear()

    def _start(self, task: Task, number: str, memory: int) -> dict[str, Any] | None:
        """Start on a file; if that cannot be, its entry."""
        if why := task.refusal or damage.refusal(task.source, SUFFIXES):
            return self._failure(task, f"{shown(task.source)}: {why}.")
        plan = self._plan
        places = {kind: plan.out / f"{task.name}.{kind}" for kind in plan.kinds}
        guide = None
        if plan.guide is not None and self._beside is not None:
            guide = plan.guide / task.name, self._beside / number
        arguments = plan.worker_arguments
        try:
            worker = Worker(task, self._command, arguments, self._scratch / number, places, guide)
        except (OSError, ValueError) as error:
            return self._failure(task, f"no process could be started for it ({error}).")
        worker.memory.limit(memory)
        self._running.append(worker)
        return None

    def _failure(self, task: Task, why: str, **facts: object) -> dict[str, Any]:
        usual: dict[str, Any] = {"seconds": 0.0, "peak_mb": 0, "results": {}, "objects": []}
        return usual | self._about(task) | {"status": "failed", "error": why} | facts

    def _about(self, task: Task) -> dict[str, Any]:
        return {
            "name": task.name,
            "file": shown(task.source),
            "arguments": self._digest,
        }

    def _outcome(self, worker: Worker) -> dict[str, Any]:
        task = worker.task
        facts: dict[str, Any] = {
            "seconds": round(worker.seconds, 2),
            "peak_mb": round(worker.memory.peak / 2**20),
        }
        # The report is written last: without it the results are not complete.
        objects = summary.objects_in(worker.result())
        if not objects or worker.timed_out:
            return self._failure(task, worker.why(), **facts)
        facts["objects"] = objects
        beside = worker.beside()
        made = worker.makes(self._plan.out)
        try:
            for place in chain.from_iterable(made.values()):
                self._plan.guard.spares_inputs(self._plan.out / place)
            self._journal.add({"name": task.name, "status": "delivering", "results": made})
            worker.deliver()
        except (DeliveryError, OverwriteError) as error:
            return self._failure(task, str(error), **facts)
        facts["results"] = made
        if not worker.succeeded:
            return self._failure(task, worker.why(), **facts)
        facts |= {"source": worker.source, "beside": beside}
        return self._about(task) | {"status": "done"} | facts

    def _is_done(self, task: Task) -> bool:
        """Whether an earlier run has done this very file, in the same way."""
        entry = self._journal.entries.get(task.name)
        if entry is None or entry["status"] != "done":
            return False
        wanted = {*self._plan.kinds, *(["guide"] if self._plan.guide else [])}
        if not wanted <= entry["results"].keys():
            return False
        places = [place for kind in wanted for place in journal.places_of(entry, kind)]
        return (
            entry["arguments"] == self._digest
            and entry.get("source") == identity(task.source)
            and all(identity(name) == one for name, one in _beside(entry))
            and all((self._plan.out / place).is_file() for place in places)
        )


def _tell(entry: dict[str, Any], done: int, files: int) -> None:
    """Say to a program that one more of the files has ended."""
    known = {name: entry[name] for name in ("file", "status", "seconds", "error") if name in entry}
    messages.tell("file", **known, done=done, files=files)


def _beside(entry: dict[str, Any]) -> Iterable[tuple[str, Any]]:
    """The files that were read beside that of an entry, as they were."""
    kept = entry.get("beside")
    return kept.items() if isinstance(kept, dict) else ()


def _shares(tasks: list[Task], jobs: int | None, limit: int | None) -> tuple[int, int]:
    """How many files at a time, and bytes of memory for each process."""
    free = machine.free_memory()
    largest = max((size[0] for task in tasks if (size := identity(task.source))), default=0)
    if jobs is None:
        fitting = free // (limit or (machine.BLENDER + _PER_BYTE * largest))
        jobs = min(machine.processors(), fitting)
    jobs = max(1, min(jobs, len(tasks)))
    return jobs, limit or free // jobs
