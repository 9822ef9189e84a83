"""Which files a batch works on, and where the results of each go."""

from __future__ import annotations

import glob
import os
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

from ..files.guard import Guard, folded, shown
from . import journal
from .names import apart, result_name


class PlanError(Exception):
    """The batch cannot be started as it was asked for; the text says why."""


@dataclass(frozen=True)
class Task:
    """One file; its results are `name` with further endings, in the batch's folder.

    `refusal` says why it cannot be read at all; then no process is started for it.
    """

    source: str
    name: str
    refusal: str = ""


@dataclass(frozen=True)
class Plan:
    """What a batch is asked to do.

    Attributes
    ----------
    tasks:
        The files, in the order in which they are started.
    out:
        Folder of the results.
    kinds:
        Endings of the results of each file: "json" first, then any of "blend", "png", "ply".
    worker_arguments:
        The command's arguments for one file, without the file and the results.
    key:
        What else the results depend on: with another one nothing counts as done before.
    jobs:
        Files at a time, or None for as many as the machine holds.
    part:
        (k, n): this is the k-th of n batches that share the folder, counted from 1.
    report:
        CSV or JSON-lines file of the summary, or None for DIR/report.csv.
    resume:
        Leave out what an earlier run has done.
    tolerant:
        Files that fail do not make the batch fail.
    time_limit:
        Seconds after which a file is given up.
    memory_limit:
        Bytes that a file's process may have, or None for its share of what is free.
    guide:
        Folder of the guidance, or None: the files of each mesh file in a folder of its name.
    events:
        Tell of the progress in JSON lines on standard output.
    guard:
        Knows all files that are read.
    """

    tasks: tuple[Task, ...]
    out: Path
    kinds: tuple[str, ...]
    worker_arguments: tuple[str, ...]
    jobs: int | None
    part: tuple[int, int]
    report: Path | None
    resume: bool
    tolerant: bool
    time_limit: float
    key: str = ""
    memory_limit: int | None = None
    guide: Path | None = None
    events: bool = False
    guard: Guard = field(default_factory=Guard)

    @property
    def suffix(self) -> str:
        """What the names of this part's own files have at the end."""
        return "" if self.part == (1, 1) else "-{}-of-{}".format(*self.part)

    @property
    def journal(self) -> Path:
        return self.out / f"report{self.suffix}.jsonl"

    @property
    def summary(self) -> Path:
        return self.report or self.out / f"report{self.suffix}.csv"


def tasks_for(
    named: Iterable[str],
    suffixes: tuple[str, ...],
    part: tuple[int, int],
    out: Path | None = None,
    endings: Iterable[str] = (".json",),
) -> tuple[Task, ...]:
    """The files that the arguments stand for, each once; with a part (k, n), every n-th of them.

    A folder stands for every mesh file in it and below; `*`, `?` and `[` are filled in here
    where the shell did not. What does not exist stays a task, which then fails with a word on
    it. Results of this batch (in `out`) and of others, as their journals have them, are no
    mesh files. `endings` are those that results will have.

    Raises
    ------
    PlanError
        Two files would have results of the same name.
    """
    search = _Search(suffixes)
    found = [task for argument in named for task in search.files(argument)]
    # Read after the search: what was found and is a result stands in a journal by now.
    results = journal.results_in({*search.folders, *([out] if out else [])})
    chosen: dict[str, Task] = {}
    for task in found:
        if task.source not in search.named and os.path.realpath(task.source) in results:
            continue
        # Also where a file system does not tell upper from lower case, or accents composed
        # otherwise.
        other = chosen.setdefault(folded(task.name), task)
        if os.path.realpath(other.source) != os.path.realpath(task.source):
            raise PlanError(
                f"{shown(other.source)} and {shown(task.source)} would both have results "
                f"called {task.name}."
            )
    tasks = sorted(chosen.values(), key=lambda task: task.name)
    names = apart([task.name for task in tasks], endings)
    tasks = [Task(task.source, names[task.name], task.refusal) for task in tasks]
    number, count = part
    return tuple(tasks[number - 1 :: count])


class _Search:
    """Finds mesh files; remembers the folders it saw, and the files that were named one by one."""

    def __init__(self, suffixes: tuple[str, ...]) -> None:
        self._suffixes = suffixes
        self.folders: set[Path] = set()
        self.named: set[str] = set()

    def files(self, argument: str) -> list[Task]:
        """Files and the names of their results: the path below a folder that was given, or else
        the file's own name."""
        path = Path(argument)
        if path.is_dir():
            inside = list(self._inside(argument))
            why = "there are no mesh files in this folder"
            return inside or [Task(argument, result_name(path.resolve().name), why)]
        if not os.path.lexists(argument) and glob.has_magic(argument):
            matches = sorted(glob.glob(argument, recursive=True))
            self.folders |= {Path(match).parent for match in matches}
            return [task for match in matches for task in self._matched(match)] or [
                Task(argument, result_name("".join("_" if c in "/\\*?[]" else c for c in argument)))
            ]
        self.named.add(argument)
        return [Task(argument, result_name(path.name))]

    def _matched(self, match: str) -> list[Task]:
        if os.path.isdir(match):
            return list(self._inside(match))
        return [Task(match, result_name(os.path.basename(match)))]

    def _inside(self, top: str) -> Iterable[Task]:
        unreadable: list[Task] = []

        def remember(error: OSError) -> None:
            source = str(error.filename)
            name = result_name(os.path.relpath(source, top).replace(os.sep, "/"))
            unreadable.append(Task(source, name, f"cannot be looked into ({error.strerror})"))

        for folder, folders, files in os.walk(top, onerror=remember):
            self.folders.add(Path(folder))
            # A batch that is at work has its unfinished results there.
            folders[:] = sorted(name for name in folders if not name.startswith(".umbilics-"))
            for name in sorted(files):
                if os.path.splitext(name)[1].lower() in self._suffixes:
                    source = os.path.join(folder, name)
                    below = os.path.relpath(source, top).replace(os.sep, "/")
                    yield Task(source, result_name(below))
        yield from unreadable
