"""`--strokes`: guide strokes and wanted poles of a file, for the plan and the quads."""

from __future__ import annotations

import argparse
import dataclasses
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ... import core
from ..base.errors import FileError
from .arguments import values
from .files import companions
from .files.guard import Guard, shown

SUFFIXES = (".json", ".obj")


@dataclasses.dataclass(frozen=True)
class SteeringRequest:
    """The file or folder that plans are steered by, and how far strokes count."""

    path: str
    settings: core.StrokeSettings


@dataclasses.dataclass(frozen=True)
class ByHand:
    """What the plan of one mesh is steered by, in the coordinates of its world, and of which file
    or folder; of none where the plan is free."""

    strokes: core.Strokes | None = None
    wanted: core.WantedPoles | None = None
    file: str = ""


def setting_name(name: str) -> str:
    """What a setting of strokes is called here."""
    return f"stroke_{name}"


def add_arguments(
    group: argparse._ArgumentGroup,
    add_setting: Callable[[argparse._ArgumentGroup, str, core.Option, Any], None],
) -> None:
    """Add the options to a group."""
    group.add_argument(
        "--strokes",
        metavar="FILE",
        type=values.path,
        help="plan by the guide strokes and the poles of a JSON file, or by the polylines of an "
        "OBJ; of a folder FILE by the file that is called like the mesh's",
    )
    for name, option in core.options(core.StrokeSettings).items():
        default = core.defaults(core.StrokeSettings)[name]
        add_setting(group, setting_name(name), option, default)


def request_of(
    parser: argparse.ArgumentParser, found: argparse.Namespace
) -> SteeringRequest | None:
    """What the arguments ask for; None without --strokes."""
    given = {name: getattr(found, setting_name(name)) for name in core.options(core.StrokeSettings)}
    settings = values.settings(parser, core.StrokeSettings, given, setting_name)
    if found.strokes is None:
        return None
    if found.guide is None and found.quads is None and found.check_topology is None:
        parser.error(
            "--strokes needs a plan that goes by them: --guide, --quads or --check-topology."
        )
    if not Path(found.strokes).exists():
        parser.error(f"--strokes {found.strokes}: there is no such file.")
    if Path(found.strokes).is_dir() and not found.files:
        parser.error("--strokes names a folder: it needs the FILE that its files are called like.")
    return SteeringRequest(found.strokes, settings)


def claim(request: SteeringRequest | None, guard: Guard) -> None:
    """Tell the guard which files are read."""
    if request is not None:
        guard.reads(companions.files_of(Path(request.path), SUFFIXES))


def worker_arguments(found: argparse.Namespace) -> list[str]:
    """What asks another process of this command for the same."""
    if found.strokes is None:
        return []
    names = [setting_name(name) for name in core.options(core.StrokeSettings)]
    words = [f"--{name.replace('_', '-')}={getattr(found, name)}" for name in names]
    return [f"--strokes={found.strokes}", *words]


def identity_of(found: argparse.Namespace) -> tuple[tuple[str, int, int], ...]:
    """What tells the files from another state of them."""
    return companions.identity_of(found.strokes, SUFFIXES)


def read(request: SteeringRequest | None, file: str | None) -> core.Steering | None:
    """The strokes and poles for the meshes of a file.

    Raises
    ------
    core.UmbilicsError
        There is no such file, or it is not what it should be.
    """
    if request is None:
        return None
    if file is None:
        return core.read_steering(Path(request.path))
    words = "file", "files"
    return core.read_steering(
        companions.companion_of(file, request.path, SUFFIXES, "--strokes", words)
    )


def check(steering: core.Steering | None, names: Sequence[str], where: str) -> None:
    """Refuse poles for several meshes.

    Raises
    ------
    FileError
        There are poles, and not one mesh that they are of.
    """
    if steering is not None and steering.wanted is not None and len(names) > 1:
        raise FileError(
            f"{shown(where)}: the poles of --strokes are those of one mesh, and there are "
            f"{len(names)}: name it with --object."
        )


def for_mesh(
    steering: core.Steering | None,
    request: SteeringRequest | None,
    vertices: np.ndarray,
    to_file: np.ndarray,
) -> ByHand:
    """What the plan of a mesh goes by, whose world `to_file` (3, 3) turns into file coordinates."""
    if steering is None or request is None:
        return ByHand()
    # A turn back is its transpose.
    here = steering.turned(to_file.T)
    size = float(np.ptp(vertices, axis=0).max())
    return ByHand(here.strokes(size, request.settings), here.wanted, shown(request.path))


def facts(by_hand: ByHand, warnings: Sequence[str]) -> dict[str, Any]:
    """What the report says of a plan by hand, with the `warnings` of the plan."""
    if not by_hand.file:
        return {}
    entry = {
        "file": by_hand.file,
        "strokes": 0 if by_hand.strokes is None else len(by_hand.strokes),
        "poles": None if by_hand.wanted is None else len(by_hand.wanted.valence),
        "warnings": list(warnings),
    }
    return {"steering": entry}
