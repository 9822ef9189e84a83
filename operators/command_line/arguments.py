"""The command's arguments, generated from the core's list of settings."""

from __future__ import annotations

import argparse
import dataclasses
import math
from pathlib import Path

from ... import core
from ..properties import GIVEN_NAMES
from .importers import SUFFIXES

_OUTPUTS = ("json", "blend", "png")
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
    JSON, .blend and PNG go.
    """

    files: tuple[str | None, ...]
    objects: tuple[str, ...]
    settings: core.Settings
    given_names: tuple[str, ...]
    per_vertex: bool
    compare: bool
    outputs: tuple[dict[str, Path], ...]


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
    return Request(
        files=files,
        objects=tuple(found.object),
        settings=settings,
        given_names=tuple(getattr(found, name) for name in GIVEN_NAMES),
        per_vertex=found.per_vertex,
        compare=found.compare,
        outputs=_outputs(parser, found, files),
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
    output.add_argument(
        "--per-vertex", action="store_true", help="JSON: add the curvature at every vertex"
    )
    output.add_argument(
        "--compare",
        action="store_true",
        help="run methods S, I and C on the same operators: a table, and with --png a picture of "
        "the three; the other results are those of S",
    )
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
