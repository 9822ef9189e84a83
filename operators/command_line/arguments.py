"""The command's arguments, generated from the core's list of settings."""

from __future__ import annotations

import argparse
import dataclasses
from pathlib import Path

import bpy

from ... import core
from ..data.properties import GIVEN_NAMES
from . import batch_arguments, frames, guidance, values
from .batch import Plan
from .batch_arguments import OUTPUTS
from .guard import Guard, OverwriteError
from .importers import SUFFIXES

_CURVATURE_NAMES = {
    "k1": "larger principal curvature",
    "k2": "smaller principal curvature",
    "d1": "direction of k1",
    "d2": "direction of k2",
}


@dataclasses.dataclass(frozen=True)
class Limits:
    """What one file may take: seconds and bytes, None for no bound."""

    seconds: float | None = None
    memory: int | None = None

    def __bool__(self) -> bool:
        return self.seconds is not None or self.memory is not None


@dataclasses.dataclass(frozen=True)
class Request:
    """What the command is asked to do.

    Attributes
    ----------
    files:
        The files, None for the one that Blender has open.
    objects:
        Names of the meshes to take, or none for all.
    frames:
        Frames of the animation, or none for the mesh without modifiers.
    outputs:
        For each file where its JSON, .blend, PNG, PLY and USD go.
    guidance:
        Files for remeshers.
    events:
        Tell of the progress in JSON lines on standard output, instead of in sentences.
    limits:
        Of each file.
    worker_arguments:
        What gives another process the same settings.
    is_worker:
        This process belongs to another one, and ends with it.
    guard:
        Holds the paths of all inputs and results.
    batch:
        With one other processes do the files.
    summary:
        With one nothing is done but the summary of the batches in that folder.
    """

    files: tuple[str | None, ...]
    objects: tuple[str, ...]
    frames: tuple[int, ...]
    settings: core.Settings
    given_names: tuple[str, ...]
    per_vertex: bool
    compare: bool
    outputs: tuple[dict[str, Path], ...]
    guard: Guard
    events: bool = False
    limits: Limits = Limits()
    worker_arguments: tuple[str, ...] = ()
    is_worker: bool = False
    guidance: guidance.GuidanceRequest | None = None
    batch: Plan | None = None
    summary: tuple[Path, Path | None] | None = None


def parse(arguments: list[str]) -> Request:
    """The request that the arguments stand for.

    Raises
    ------
    SystemExit
        With code 2 for wrong arguments, or results that would overwrite something, after a line
        on standard error; with 0 after --help.
    """
    parser = _parser()
    found = parser.parse_args(arguments)
    setting_values = {name: getattr(found, name) for name in core.options()}
    try:
        if found.compare:
            setting_values["method"] = "S"
        settings = core.Settings(**setting_values)
    except core.InvalidSettingsError as error:
        parser.error(str(error))
    files = tuple(found.files) or (None,)
    guard = Guard()
    try:
        guide = guidance.request_of(parser, found)
        guide_settings = guide.settings if guide else None
        guard.reads([bpy.data.filepath] if bpy.data.filepath else [])
        batch = batch_arguments.plan_of(parser, found, settings, guide_settings, guard)
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
        settings=settings,
        given_names=tuple(getattr(found, name) for name in GIVEN_NAMES),
        per_vertex=found.per_vertex,
        compare=found.compare,
        outputs=outputs,
        guard=guard,
        events=found.progress == "jsonl",
        limits=Limits(found.time_limit, batch_arguments.memory_limit_of(found)),
        worker_arguments=batch_arguments.worker_arguments(found, settings, guide_settings),
        is_worker=found.worker,
        guidance=guide,
        batch=batch,
        summary=(found.out, found.report) if found.summary else None,
    )


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
        help="the meshes as modifiers, armatures and shape keys make them at these frames, such "
        "as 1-10,20,30-50x5 (default: the meshes without modifiers)",
    )
    parser.add_argument(
        "--progress",
        choices=("text", "jsonl"),
        default="text",
        help="how far it is: sentences, or JSON lines on standard output (default: text)",
    )
    _add_results(parser)
    guidance.add_arguments(parser, _add_setting)
    batch_arguments.add_arguments(parser)
    batch_arguments.add_limits(parser)
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
    group.add_argument("--json", metavar="F", help="write the umbilics as JSON")
    group.add_argument("--blend", metavar="F", help="save a .blend with the results")
    group.add_argument("--png", metavar="F", help="draw a picture")
    group.add_argument("--ply", metavar="F", help="write the mesh with the curvatures as PLY")
    group.add_argument(
        "--per-vertex", action="store_true", help="JSON: add the curvature at every vertex"
    )
    group.add_argument(
        "--compare",
        action="store_true",
        help="run methods S, I and C on the same operators: a table, and with --png a picture of "
        "the three; the other results are those of S",
    )


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
        choices = [choice.value for choice in option.choices]
        group.add_argument(flag, choices=choices, default=default, help=text)
        return
    read = values.whole_number if option.kind == "count" else values.number
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
        {kind: folder / f"{Path(file).stem}.{kind}" for kind, folder in wanted.items()}
        for file in files
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
