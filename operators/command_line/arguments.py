"""The command's arguments, generated from the core's list of settings."""

from __future__ import annotations

import argparse
import dataclasses
import math
from pathlib import Path

from ... import core
from ..data.properties import GIVEN_NAMES
from . import guidance
from .batch import Plan, PlanError
from .batch.plan import tasks_for
from .importers import SUFFIXES

_OUTPUTS = ("json", "blend", "png", "ply")
# What only makes sense together with --out.
_BATCH = ("also", "jobs", "report", "resume", "part", "tolerant", "summary")
_CURVATURE_NAMES = {
    "k1": "larger principal curvature",
    "k2": "smaller principal curvature",
    "d1": "direction of k1",
    "d2": "direction of k2",
}


@dataclasses.dataclass(frozen=True)
class Request:
    """What the command is asked to do.

    `outputs` gives, for each file (or for None, the file that Blender has open), where its
    JSON, .blend, PNG and PLY go. With a `batch` other processes do the files; with `summary`
    nothing is done but the summary of the batches in that folder.
    """

    files: tuple[str | None, ...]
    objects: tuple[str, ...]
    settings: core.Settings
    given_names: tuple[str, ...]
    per_vertex: bool
    compare: bool
    outputs: tuple[dict[str, Path], ...]
    guidance: guidance.GuidanceRequest | None = None
    batch: Plan | None = None
    summary: tuple[Path, Path | None] | None = None


def parse(arguments: list[str]) -> Request:
    """The request that the arguments stand for.

    Raises
    ------
    SystemExit
        With code 2 for wrong arguments, after a line on standard error; with 0 after --help.
    """
    parser = _parser()
    found = parser.parse_args(arguments)
    values = {name: getattr(found, name) for name in core.options()}
    try:
        if found.compare:
            values["method"] = "S"
        settings = core.Settings(**values)
    except core.InvalidSettingsError as error:
        parser.error(str(error))
    files = tuple(found.files) or (None,)
    batch = _batch(parser, found, settings)
    return Request(
        files=files,
        objects=tuple(found.object),
        settings=settings,
        given_names=tuple(getattr(found, name) for name in GIVEN_NAMES),
        per_vertex=found.per_vertex,
        compare=found.compare,
        outputs=() if found.out else _outputs(parser, found, files),
        guidance=guidance.request_of(parser, found),
        batch=batch,
        summary=(found.out, found.report) if found.summary else None,
    )


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="blender -b [FILE.blend] --command umbilics",
        description="Find the umbilical points of meshes and their kind.",
        epilog=f"Files may be {', '.join(SUFFIXES)}. Exit code: 0 done, 1 something could not "
        "be done (one line on standard error each), 2 wrong arguments.",
        allow_abbrev=False,
    )
    parser.add_argument(
        "files",
        metavar="FILE",
        nargs="*",
        help="mesh files; without any, the meshes of the file that Blender has open",
    )
    parser.add_argument(
        "--object",
        metavar="NAME",
        action="append",
        default=[],
        help="only this object; may be given several times (default: every mesh)",
    )
    output = parser.add_argument_group(
        "results", "With several FILEs each of these names a folder, made if it is missing."
    )
    output.add_argument("--json", metavar="F", help="write the umbilics as JSON")
    output.add_argument("--blend", metavar="F", help="save a .blend with the results")
    output.add_argument("--png", metavar="F", help="draw a picture")
    output.add_argument("--ply", metavar="F", help="write the mesh with the curvatures as PLY")
    output.add_argument(
        "--per-vertex", action="store_true", help="JSON: add the curvature at every vertex"
    )
    output.add_argument(
        "--compare",
        action="store_true",
        help="run methods S, I and C on the same operators: a table, and with --png a picture of "
        "the three; the other results are those of S",
    )
    guidance.add_arguments(parser, _add_setting)
    _add_batch(parser)
    group = parser.add_argument_group("settings")
    for name, option in core.options().items():
        _add_setting(group, name, option, core.defaults()[name])
    for name in GIVEN_NAMES:
        group.add_argument(
            f"--{name}",
            metavar="ATTRIBUTE",
            default=name,
            help=f"--curvature given: vertex attribute of the {_CURVATURE_NAMES[name]} "
            f"(default: {name})",
        )
    return parser


def _add_batch(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group(
        "many files",
        "With --out each file gets a Blender process of its own, several at a time. FILE may then "
        "be a folder (with all below it) or a pattern such as '*.stl'.",
    )
    group.add_argument(
        "--out", metavar="DIR", type=Path, help="write DIR/FILE.json for each file, and a summary"
    )
    group.add_argument(
        "--also",
        metavar="KIND",
        action="append",
        choices=_OUTPUTS[1:],
        default=[],
        help=f"write this for each file too: {', '.join(_OUTPUTS[1:])}; may be given several times",
    )
    group.add_argument(
        "--jobs",
        metavar="N",
        type=_positive_number,
        help="files at a time (default: what processors and memory allow)",
    )
    group.add_argument(
        "--report",
        metavar="F",
        type=Path,
        help="the summary as .csv, or as .jsonl (default: DIR/report.csv)",
    )
    group.add_argument(
        "--resume", action="store_true", help="skip what an earlier run into DIR has done"
    )
    group.add_argument(
        "--part",
        metavar="K/N",
        type=_part,
        default=(1, 1),
        help="do the K-th of N parts of the files only, for several machines with one DIR",
    )
    group.add_argument(
        "--time-limit",
        metavar="S",
        type=_number,
        default=3600.0,
        help="give a file up after S seconds (default: 3600)",
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


def _batch(
    parser: argparse.ArgumentParser, found: argparse.Namespace, settings: core.Settings
) -> Plan | None:
    if found.out is None:
        for name in _BATCH:
            if getattr(found, name) != parser.get_default(name):
                parser.error(f"--{name} needs --out DIR.")
        return None
    if found.summary:
        return None
    for kind in _OUTPUTS:
        if getattr(found, kind):
            parser.error(f"With --out there is no --{kind}; say --also {kind}.")
    if not found.files:
        parser.error("--out needs files or folders.")
    if found.out.exists() and not found.out.is_dir():
        parser.error(f"--out {found.out} is not a folder.")
    try:
        tasks = tasks_for(found.files, SUFFIXES, found.part)
    except PlanError as error:
        parser.error(str(error))
    return Plan(
        tasks=tasks,
        out=found.out,
        kinds=("json", *sorted(set(found.also))),
        worker_arguments=_worker_arguments(found, settings),
        jobs=found.jobs,
        part=found.part,
        report=found.report,
        resume=found.resume,
        tolerant=found.tolerant,
        time_limit=found.time_limit,
    )


def _worker_arguments(found: argparse.Namespace, settings: core.Settings) -> tuple[str, ...]:
    """What gives another process of this command the same settings."""
    arguments = []
    for name, option in core.options().items():
        flag, value = name.replace("_", "-"), getattr(settings, name)
        if option.kind == "flag":
            arguments.append(f"--{flag}" if value else f"--no-{flag}")
        else:
            arguments.append(f"--{flag}={value}")
    arguments += [f"--{name}={getattr(found, name)}" for name in GIVEN_NAMES]
    arguments += [f"--object={name}" for name in found.object]
    arguments += ["--per-vertex"] * found.per_vertex + ["--compare"] * found.compare
    return tuple(arguments)


def _add_setting(group, name: str, option: core.Option, default) -> None:
    flag = f"--{name.replace('_', '-')}"
    text = option.help.replace("%", "%%")
    if option.unit:
        text += f" [{option.unit}]"
    if option.kind == "flag":
        group.add_argument(flag, action=argparse.BooleanOptionalAction, default=default, help=text)
        return
    text += f" (default: {default})"
    if option.kind == "choice":
        values = [choice.value for choice in option.choices]
        group.add_argument(flag, choices=values, default=default, help=text)
        return
    read = _whole_number if option.kind == "count" else _number
    if option.automatic:
        read = _or_automatic(read)
    group.add_argument(flag, type=read, default=default, metavar="N", help=text)


def _whole_number(text: str) -> int:
    try:
        return int(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is not a whole number") from None


def _positive_number(text: str) -> int:
    value = _whole_number(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"'{text}' is not 1 or more")
    return value


def _part(text: str) -> tuple[int, int]:
    number, _, count = text.partition("/")
    try:
        part = int(number), int(count)
    except ValueError:
        part = 0, 0
    if not 1 <= part[0] <= part[1]:
        raise argparse.ArgumentTypeError(f"'{text}' is not like 3/16")
    return part


def _number(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"'{text}' is not a number")
    return value


def _or_automatic(read):
    return lambda text: core.AUTO if text == core.AUTO else read(text)


def _outputs(
    parser: argparse.ArgumentParser,
    found: argparse.Namespace,
    files: tuple[str | None, ...],
) -> tuple[dict[str, Path], ...]:
    wanted = {kind: Path(path) for kind in _OUTPUTS if (path := getattr(found, kind))}
    if len(files) == 1:
        for kind, path in wanted.items():
            if path.is_dir():
                parser.error(f"--{kind} {path} is a folder; name a file.")
        return (wanted,)
    for kind, path in wanted.items():
        if path.is_file():
            parser.error(f"--{kind} {path} is a file; with several FILEs it must be a folder.")
    names = [Path(file).stem for file in files]
    twice = next((name for name in names if names.count(name) > 1), None)
    if wanted and twice is not None:
        parser.error(f"Two FILEs are called {twice}: their results would have the same name.")
    return tuple(
        {kind: folder / f"{name}.{kind}" for kind, folder in wanted.items()} for name in names
    )
