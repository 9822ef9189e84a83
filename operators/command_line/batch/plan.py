"""Which files a batch works on, and where the results of each go."""

from __future__ import annotations

import glob
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path


class PlanError(Exception):
    """The batch cannot be started as it was asked for; the text says why."""


@dataclass(frozen=True)
class Task:
    """One file; its results are `name` with further endings, in the batch's folder."""

    source: str
    name: str


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


def tasks_for(
    named: Iterable[str], suffixes: tuple[str, ...], part: tuple[int, int]
) -> tuple[Task, ...]:
    """The files that the arguments stand for, each once.

    A folder stands for every mesh file in it and below; `*`, `?` and `[` are filled in here
    where the shell did not. What does not exist stays a task, which then fails with a word on
    it. With a part (k, n), every n-th file from the k-th on.

    Raises
    ------
    PlanError
        Two files would have results of the same name.
    """
    found: dict[str, str] = {}
    for argument in named:
        for source, name in _files(argument, suffixes):
            other = found.setdefault(name, source)
            if Path(other).resolve() != Path(source).resolve():
                raise PlanError(f"{other} and {source} would both have results called {name}.")
    tasks = [Task(source, name) for name, source in sorted(found.items())]
    number, count = part
    return tuple(tasks[number - 1 :: count])


def _files(argument: str, suffixes: tuple[str, ...]) -> list[tuple[str, str]]:
    """Files and the names of their results: the path below a folder that was given, or else
    the file's own name."""
    path = Path(argument)
    if path.is_dir():
        inside = (file for file in sorted(path.rglob("*")) if file.suffix.lower() in suffixes)
        files = [(str(file), file.relative_to(path).as_posix()) for file in inside]
        return files or [(argument, path.name)]
    if not path.exists() and glob.has_magic(argument):
        matches = sorted(glob.glob(argument, recursive=True))
        return [pair for match in matches for pair in _files(match, suffixes)] or [
            (argument, "".join(c if c.isalnum() or c in "-_. " else "_" for c in argument))
        ]
    return [(argument, path.name)]
