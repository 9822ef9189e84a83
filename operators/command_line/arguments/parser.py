"""The command's arguments, generated from the core's list of settings."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy

from .... import core
from ...data.properties import GIVEN_NAMES
from .. import frames, guidance, matching, steering
from ..batch.names import result_name
from ..files import companions
from ..files.guard import Guard, OverwriteError
from ..files.importers import SUFFIXES
from . import batch as batch_arguments
from . import idle, values
from . import source as source_arguments
from .batch import OUTPUTS
from .request import Limits, Request

_CURVATURE_NAMES = {
    "k1": "larger principal curvature",
    "k2": "smaller principal curvature",
    "d1": "direction of k1",
    "d2": "direction of k2",
}


def parse(arguments: list[str]) -> Request:
    """The request that the arguments stand for.

    Raises
    ------
    SystemExit
        With code 2 for wrong arguments, or results that would overwrite something, after a line
        on standard error; with 0 after --help.
    """
    parser = _parser()
    try:
        arguments = _spread(arguments)
    except ValueError as error:
        parser.error(f"--options: {error}")
    found = parser.parse_args(arguments)
    setting_values = {name: getattr(found, name) for name in core.options()}
    if found.compare:
        setting_values["method"] = "S"
    settings = values.settings(parser, core.Settings, setting_values)
    files = tuple(found.files) or (None,)
    guard = Guard()
    try:
        planning = guidance.settings_of(parser, found)
        guide = guidance.request_of(parser, found, planning)
        idle.refuse(parser, found, guide)
        steered = steering.request_of(parser, found)
        steering.claim(steered, guard)
        match = matching.request_of(parser, found)
        guard.reads(match.files if match else ())
        guard.reads([bpy.data.filepath] if bpy.data.filepath else [])
        _claim_checked(parser, found, guard)
        batch = batch_arguments.plan_of(parser, found, settings, planning, guide, guard)
        outputs = () if found.out else _outputs(parser, found, files)
        if not found.out:
            guard.reads(file for file in files if file is not None)
            _claim(guard, found, files, outputs, guide)
    except OverwriteError as error:
        parser.error(str(error))
    return Request(
        files=files,
        objects=tuple(found.object),
        frames=found.frames,
        source=source_arguments.source_of(parser, found),
        settings=settings,
        given_names=tuple(getattr(found, name) for name in GIVEN_NAMES),
        per_vertex=found.per_vertex,
        compare=found.compare,
        outputs=outputs,
        guard=guard,
        events=found.progress == "jsonl",
        limits=Limits(found.time_limit, batch_arguments.memory_limit_of(found)),
        worker_arguments=batch_arguments.worker_arguments(found, settings, planning, guide),
        is_worker=found.worker,
        planning=planning,
        guidance=guide,
        matching=match,
        check=found.check_topology,
        steering=steered,
        batch=batch,
        summary=(found.out, found.report) if found.summary else None,
    )


def _claim_checked(
    parser: argparse.ArgumentParser, found: argparse.Namespace, guard: Guard
) -> None:
    """Tell the guard of the file that is checked; without FILE it is an object of the open one."""
    if found.check_topology is None or not found.files:
        return
    checked = Path(found.check_topology)
    if not checked.exists():
        parser.error(f"--check-topology {found.check_topology}: there is no such file.")
    guard.reads(companions.files_of(checked, SUFFIXES))


def _spread(arguments: list[str]) -> list[str]:
    """The arguments with those of `--options TEXT` in its place, for farms that pass one text.

    Raises
    ------
    ValueError
        A quotation is not closed, or there is no text.
    """
    spread: list[str] = []
    rest = iter(arguments)
    for argument in rest:
        if argument == "--":
            return [*spread, argument, *rest]
        if argument == "--options":
            text = next(rest, None)
            if text is None:
                raise ValueError("expected one argument")
            argument = f"--options={text}"
        if argument.startswith("--options="):
            spread += shlex.split(argument.partition("=")[2])
        else:
            spread.append(argument)
    return spread


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="blender -b [FILE.blend] --command umbilics",
        # All of the options would stand between an error and its reader.
        usage="%(prog)s [FILE ...] [options; --help lists them]",
        description="Find the umbilical points of meshes and their kind.",
        epilog=f"Files may be {', '.join(SUFFIXES)}. Exit code: 0 done, 1 something could not be "
        "done (one line on standard error each), 2 wrong arguments or results that would "
        "overwrite something, 3 another batch is at work in --out, 130 stopped.",
        allow_abbrev=False,
    )
    parser.add_argument(
        "files",
        metavar="FILE",
        nargs="*",
        type=values.path,
        help="mesh files; without any, the meshes of the file that Blender has open",
    )
    parser.add_argument(
        "--object",
        metavar="NAME",
        action="append",
        default=[],
        help="only this object; may be given several times (default: every mesh)",
    )
    parser.add_argument(
        "--frames",
        metavar="A-B",
        type=frames.read,
        default=(),
        help="the meshes as they are at these frames of the animation, such as 1-10,20,30-50x5 "
        "(default: at the frame that the file was saved with)",
    )
    source_arguments.add_arguments(parser)
    parser.add_argument(
        "--progress",
        choices=("text", "jsonl"),
        default="text",
        help="how far it is: sentences, or JSON lines on standard output (default: text)",
    )
    parser.add_argument(
        "--options",
        metavar="TEXT",
        help="more options in one text, quoted as in a shell, for farms that pass only one",
    )
    _add_results(parser)
    guidance.add_arguments(parser, _add_setting)
    matching.add_arguments(parser)
    batch_arguments.add_arguments(parser)
    batch_arguments.add_limits(parser)
    _add_settings(parser)
    # For processes that this command starts itself.
    parser.add_argument("--worker", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("--final", action="append", default=[], help=argparse.SUPPRESS)
    return parser


def _add_results(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group(
        "results",
        "With several FILEs each of these names a folder, made if it is missing. With --frames "
        "each but the JSON has a file for every frame, F.0001.png and so on.",
    )
    for kind, text in (
        ("json", "write the umbilics as JSON"),
        ("blend", "save a .blend with the results"),
        ("png", "draw a picture"),
        ("ply", "write the mesh with the curvatures as PLY"),
        ("usda", "write the mesh, its curvatures and the umbilics as USD"),
    ):
        group.add_argument(f"--{kind}", metavar="F", type=values.path, help=text)
    group.add_argument(
        "--per-vertex", action="store_true", help="JSON: add the curvature at every vertex"
    )
    group.add_argument(
        "--compare",
        action="store_true",
        help="run methods S, I and C on the same operators: a table, and with --png a picture of "
        "the three; the other results are those of S",
    )


def _add_settings(parser: argparse.ArgumentParser) -> None:
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


def _add_setting(
    group: argparse._ArgumentGroup, name: str, option: core.Option, default: Any
) -> None:
    flag = f"--{name.replace('_', '-')}"
    text = option.help.replace("%", "%%")
    if option.unit:
        text += f" [{option.unit}]"
    if option.kind == "flag":
        made = group.add_argument(flag, action=argparse.BooleanOptionalAction, default=default)
        # Afterwards: Python 3.11 would add a default of its own.
        made.help = f"{text} (default: {'on' if default else 'off'})"
        return
    text += f" (default: {default})"
    if option.kind == "choice":
        choices = [choice.value for choice in option.choices]
        group.add_argument(flag, choices=choices, default=default, help=text)
        return
    read: Callable[[str], Any] = values.whole_number if option.kind == "count" else values.number
    if option.automatic:
        read = values.or_automatic(read)
    group.add_argument(flag, type=read, default=default, metavar="N", help=text)


def _outputs(
    parser: argparse.ArgumentParser,
    found: argparse.Namespace,
    files: tuple[str | None, ...],
) -> tuple[dict[str, Path], ...]:
    wanted = {kind: Path(path) for kind in OUTPUTS if (path := getattr(found, kind))}
    if len(files) == 1:
        for kind, path in wanted.items():
            if path.is_dir():
                parser.error(f"--{kind} {path} is a folder; name a file.")
        return (wanted,)
    for kind, path in wanted.items():
        if path.is_file():
            parser.error(f"--{kind} {path} is a file; with several FILEs it must be a folder.")
    return tuple(
        {kind: folder / f"{result_name(Path(file).stem)}.{kind}" for kind, folder in wanted.items()}
        for file in filter(None, files)
    )


def _claim(
    guard: Guard,
    found: argparse.Namespace,
    files: tuple[str | None, ...],
    outputs: tuple[dict[str, Path], ...],
    guide: guidance.GuidanceRequest | None,
) -> None:
    """Claim all results in the guard, those of the guidance as far as they are known before the
    files are opened.

    Raises
    ------
    OverwriteError
        One of them would overwrite something.
    """
    for file, places in zip(files, outputs, strict=True):
        for kind, path in places.items():
            for place in frames.places(path, kind, found.frames):
                guard.writes(place)
        if guide and file is not None and not found.worker:
            guide.claim_file(guard, file, found.frames)
    # Where a worker's results will be put; there is nothing yet that it could collide with.
    for path in found.final:
        guard.writes(path)
