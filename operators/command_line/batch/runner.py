"""The batch itself: starts a process for each file, keeps the journal, ends with a summary."""

from __future__ import annotations

import hashlib
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from . import journal, machine
from .display import Display, duration
from .plan import Plan, Task
from .worker import Worker

DONE, FAILED, INTERRUPTED = 0, 1, 130

# Memory of a process with a file of so many bytes: Blender itself, and what a mesh becomes.
# Measured on files of 1.3 million triangles; see docs/batch.md.
_BLENDER = 500 << 20
_PER_BYTE = 30
# How often the processes are looked after, in seconds.
_PAUSE = 0.05


def run(plan: Plan, blender: list[str]) -> int:
    """Do the batch; its exit code. `blender` starts the command for one file.

    Raises
    ------
    OSError
        The folder of the results cannot be written.
    """
    part = "" if plan.part == (1, 1) else "-{}-of-{}".format(*plan.part)
    plan.out.mkdir(parents=True, exist_ok=True)
    kept = journal.Journal(plan.out / f"report{part}.jsonl", fresh=not plan.resume)
    # A name of its own: what a killed batch left running may still write into its folder.
    prefix = f".umbilics-running{part}."
    for left in plan.out.glob(f"{prefix}*"):
        shutil.rmtree(left, ignore_errors=True)
    scratch = Path(tempfile.mkdtemp(prefix=prefix, dir=plan.out))
    batch = _Batch(plan, blender, kept, scratch)
    try:
        with _stoppable(batch):
            batch.run()
    finally:
        batch.stop_workers()
        shutil.rmtree(scratch, ignore_errors=True)
    # Only what this batch is about: an earlier one may have had other files.
    entries = [kept.entries[task.name] for task in plan.tasks if task.name in kept.entries]
    report = plan.report or plan.out / f"report{part}.csv"
    journal.write_report(report, entries)
    code = _conclude(entries, report, len(plan.tasks) - len(entries))
    return DONE if code == FAILED and plan.tolerant else code


def summarize(out: Path, report: Path | None) -> int:
    """One summary of all the parts in a folder; the exit code that they have together."""
    entries = {}
    for path in sorted(out.glob("report*.jsonl")):
        entries |= {entry["name"]: entry for entry in journal.read(path)}
    report = report or out / "report.csv"
    journal.write_report(report, list(entries.values()))
    return _conclude(list(entries.values()), report, 0)


def _conclude(entries: list[dict], report: Path, missing: int) -> int:
    failed = [entry for entry in entries if entry["status"] != "done"]
    for entry in failed:
        print(journal.in_words(entry), file=sys.stderr)
    text = f"{len(entries) - len(failed)} done, {len(failed)} failed"
    if missing:
        text += f", {missing} not done: the same command with --resume does them"
    print(f"{text}; summary in {report}", file=sys.stderr, flush=True)
    if missing:
        return INTERRUPTED
    return FAILED if failed else DONE


class _Batch:
    """The files still to do and the processes that are running."""

    def __init__(
        self, plan: Plan, blender: list[str], kept: journal.Journal, scratch: Path
    ) -> None:
        self._plan = plan
        self._command = blender
        self._journal = kept
        self._scratch = scratch
        self._running: list[Worker] = []
        self._digest = hashlib.sha256(repr(plan.worker_arguments).encode()).hexdigest()[:16]
        self.stopping = False

    def run(self) -> None:
        plan = self._plan
        waiting = [task for task in plan.tasks if not self._is_done(task)]
        display = Display(len(waiting), sys.stderr)
        jobs, memory = _shares(waiting, plan.jobs)
        skipped = len(plan.tasks) - len(waiting)
        display.say(
            f"{len(waiting)} files to do{f', {skipped} done before' if skipped else ''}; "
            f"{jobs} at a time, each with at most {memory >> 20} MB of memory."
        )
        start = time.monotonic()
        waiting.reverse()
        number = 0
        while (waiting and not self.stopping) or self._running:
            while waiting and len(self._running) < jobs and not self.stopping:
                number += 1
                self._start(waiting.pop(), self._scratch / str(number), memory)
            time.sleep(_PAUSE)
            if self.stopping:
                self.stop_workers()
            for worker in [w for w in self._running if w.has_ended(plan.time_limit)]:
                self._running.remove(worker)
                entry = self._outcome(worker)
                self._journal.add(entry)
                display.ended(journal.in_words(entry), entry["status"] != "done")
            display.tick()
        display.close()
        display.say(f"Took {duration(time.monotonic() - start)}.")

    def stop_workers(self) -> None:
        """End what is running; what it was about is not done."""
        for worker in self._running:
            worker.stop()
        self._running.clear()

    def _start(self, task: Task, scratch: Path, memory: int) -> None:
        command = [*self._command, task.source, *self._plan.worker_arguments]
        worker = Worker(task, command, scratch, self._plan.kinds)
        worker.limit_memory(memory)
        self._running.append(worker)

    def _outcome(self, worker: Worker) -> dict:
        objects = journal.objects_in(worker.result())
        entry = {
            "name": worker.task.name,
            "file": worker.task.source,
            "status": "done" if worker.succeeded and objects else "failed",
            "arguments": self._digest,
            "source": _identity(worker.task.source),
            "seconds": round(worker.seconds, 2),
            "peak_mb": round(worker.peak / 2**20),
            "results": worker.deliver(self._plan.out),
            "objects": objects,
        }
        if entry["status"] != "done":
            entry["error"] = worker.why()
        return entry

    def _is_done(self, task: Task) -> bool:
        """Whether an earlier run has done this very file, in the same way."""
        entry = self._journal.entries.get(task.name)
        if entry is None or entry["status"] != "done":
            return False
        results = [entry["results"].get(kind, ".") for kind in self._plan.kinds]
        return (
            entry["arguments"] == self._digest
            and entry["source"] == _identity(task.source)
            and all((self._plan.out / result).is_file() for result in results)
        )


def _identity(source: str) -> list[int] | None:
    """Size and time of change of a file, None if there is none."""
    try:
        status = Path(source).stat()
    except OSError:
        return None
    return [status.st_size, status.st_mtime_ns]


def _shares(tasks: list[Task], jobs: int | None) -> tuple[int, int]:
    """How many files at a time, and bytes of memory for each process."""
    free = machine.free_memory()
    largest = max((size[0] for task in tasks if (size := _identity(task.source))), default=0)
    if jobs is None:
        fitting = free // (_BLENDER + _PER_BYTE * largest)
        jobs = min(machine.processors(), fitting)
    jobs = max(1, min(jobs, len(tasks)))
    return jobs, free // jobs


@contextmanager
def _stoppable(batch: _Batch) -> Iterator[None]:
    """Ctrl-C and the wish to end stop the batch in an orderly way."""

    def stop(*_: object) -> None:
        batch.stopping = True

    before = {number: signal.signal(number, stop) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler if handler is not None else signal.SIG_DFL)
