"""The arguments for many files, and the plan that they make."""

from __future__ import annotations

import argparse
import dataclasses
import os
from collections.abc import Callable
from pathlib import Path

import bpy

from .... import core
from ...data.properties import GIVEN_NAMES
from .. import frames, guidance, matching, steering, version
from ..batch import Plan, PlanError
from ..batch.plan import Task, tasks_for
from ..files import companions
from ..files.guard import Guard
from ..files.importers import SUFFIXES
from . import source as source_arguments
from . import values

OUTPUTS = ("json", "blend", "png", "ply", "usda")
# What only makes sense together with --out.
_BATCH = ("also", "jobs", "report", "resume", "part", "tolerant", "summary")
_TIME_LIMIT = 3600.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group(
        "many files",
        "With --out each file gets a Blender process of its own, several at a time. FILE may then "
        "be a folder (with all below it) or a pattern such as '*.stl'.",
    )
    group.add_argument(
        "--out",
        metavar="DIR",
        type=values.place,
        help="write DIR/FILE.json for each file, and a summary",
    )
    group.add_argument(
        "--also",
        metavar="KIND",
        action="append",
        choices=OUTPUTS[1:],
        default=[],
        help=f"write this for each file too: {', '.join(OUTPUTS[1:])}; may be given several times",
    )
    group.add_argument(
        "--jobs",
        metavar="N",
        type=values.positive_whole_number,
        help="files at a time (default: what processors and memory allow)",
    )
    group.add_argument(
        "--report",
        metavar="F",
        type=values.place,
        help="the summary as .csv, or as .jsonl (default: DIR/report.csv)",
    )
    group.add_argument(
        "--resume", action="store_true", help="skip what an earlier run into DIR has done"
    )
    group.add_argument(
        "--part",
        metavar="K/N",
        type=values.part,
        default=(1, 1),
        help="do the K-th of N parts of the files only, for several machines with one DIR",
    )
    group.add_argument(
        "--tolerant",
        action="store_true",
        help="exit with 0 although files failed, for farms that would try again; the summary "
        "says which",
    )
    group.add_argument(
        "--summary", action="store_true", help="only make one summary of all the parts in DIR"
    )


def add_limits(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group(
        "limits", "Each file then has a Blender process of its own, which is ended at a limit."
    )
    group.add_argument(
        "--time-limit",
        metavar="S",
        type=values.positive_number,
        help="give a file up after S seconds (default: 3600 with --out, else none)",
    )
    group.add_argument(
        "--memory-limit",
        metavar="MB",
        type=values.positive_whole_number,
        help="give a file up that needs more memory (default: its share of what is free with "
        "--out, else none; Linux enforces it)",
    )


def plan_of(
    parser: argparse.ArgumentParser,
    found: argparse.Namespace,
    settings: core.Settings,
    planning: core.GuidanceSettings,
    guide: guidance.GuidanceRequest | None,
    guard: Guard,
) -> Plan | None:
    """What the arguments ask for; None without --out. Its paths are claimed in the guard."""
    if found.out is None:
        for name in _BATCH:
            if getattr(found, name) != parser.get_default(name):
                parser.error(f"--{name} needs --out DIR.")
        return None
    if found.summary:
        if found.files:
            parser.error("--summary is about what is in --out: it takes no files.")
        return None
    for kind in OUTPUTS:
        if getattr(found, kind):
            way = f"say --also {kind}" if kind in OUTPUTS[1:] else "each file has its JSON there"
            parser.error(f"With --out there is no --{kind}; {way}.")
    if not found.files:
        parser.error("--out needs files or folders.")
    if os.path.lexists(found.out) and not found.out.is_dir():
        parser.error(f"--out {found.out} is not a folder.")
    kinds = ("json", *sorted(set(found.also)))
    endings = [f".{kind}" for kind in kinds]
    try:
        tasks = tasks_for(found.files, SUFFIXES, (1, 1), found.out, endings)
    except PlanError as error:
        parser.error(str(error))
    number, count = found.part
    plan = Plan(
        tasks=tasks[number - 1 :: count],
        out=found.out,
        kinds=kinds,
        worker_arguments=worker_arguments(found, settings, planning, guide),
        key=repr((version.OURS, _base_key(), _companions(found))),
        jobs=found.jobs,
        part=found.part,
        report=found.report,
        resume=found.resume,
        tolerant=found.tolerant,
        time_limit=found.time_limit or _TIME_LIMIT,
        memory_limit=memory_limit_of(found),
        guide=guide.folder if guide else None,
        events=found.progress == "jsonl",
        guard=guard,
    )
    try:
        _claim(plan, tasks, guide, found.frames)
    except PlanError as error:
        parser.error(str(error))
    return plan


def _claim(
    plan: Plan,
    tasks: tuple[Task, ...],
    guide: guidance.GuidanceRequest | None,
    wanted_frames: tuple[int, ...],
) -> None:
    """Claim all that the `tasks`, of this part and of the others, read and write.

    Raises
    ------
    OverwriteError
        A result would overwrite something.
    PlanError
        A file is where a folder would be.
    """
    guard = plan.guard
    guard.reads(task.source for task in tasks)
    for path in (plan.journal, plan.summary):
        guard.writes(path)
    for task in tasks:
        for kind in plan.kinds:
            place = plan.out / f"{task.name}.{kind}"
            for path in frames.places(place, kind, wanted_frames):
                guard.writes(path)
        if guide:
            place = guide.folder / task.name
            dataclasses.replace(guide, folder=place).claim_file(guard, task.source, wanted_frames)
            if place.exists() and not place.is_dir():
                raise PlanError(
                    f"{place} is a file, where the folder of the guidance would be. Choose "
                    "another folder with --guide."
                )


def memory_limit_of(found: argparse.Namespace) -> int | None:
    """Bytes."""
    return found.memory_limit << 20 if found.memory_limit else None


def worker_arguments(
    found: argparse.Namespace,
    settings: core.Settings,
    planning: core.GuidanceSettings,
    guide: guidance.GuidanceRequest | None,
) -> tuple[str, ...]:
    """What gives another process of this command the same settings."""
    arguments = _settings(core.options(), settings)
    if guide is not None or found.check_topology is not None:
        arguments += _settings(core.options(core.GuidanceSettings), planning)
    if guide is not None:
        arguments += guidance.worker_arguments(guide, _settings)
    if found.check_topology is not None:
        arguments.append(f"--check-topology={found.check_topology}")
    arguments += steering.worker_arguments(found)
    arguments += [f"--{name}={getattr(found, name)}" for name in GIVEN_NAMES]
    arguments += [f"--object={name}" for name in found.object]
    arguments += ["--per-vertex"] * found.per_vertex + ["--compare"] * found.compare
    arguments += source_arguments.words_of(found)
    arguments += matching.worker_arguments(found)
    if found.frames:
        arguments.append(f"--frames={frames.in_words(found.frames)}")
    return tuple(arguments)


def _settings(
    options: dict[str, core.Option], settings: object, called: Callable[[str], str] = str
) -> list[str]:
    """The options that stand for settings; `called` tells what each setting is called here."""
    arguments = []
    for name, option in options.items():
        flag, value = called(name).replace("_", "-"), getattr(settings, name)
        if option.kind == "flag":
            arguments.append(f"--{flag}" if value else f"--no-{flag}")
        else:
            arguments.append(f"--{flag}={value}")
    return arguments


def _companions(found: argparse.Namespace) -> tuple[object, ...]:
    """What tells files that go with the meshes from another state of them."""
    checked = companions.identity_of(found.check_topology, SUFFIXES)
    return checked, steering.identity_of(found), matching.identity_of(found)


def _base_key() -> tuple[object, ...]:
    """What tells the .blend that meshes are imported into from another state of it."""
    path = bpy.data.filepath
    if not path:
        return ()
    status = Path(path).stat()
    return path, status.st_size, status.st_mtime_ns
