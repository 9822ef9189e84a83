"""The command's part in retopology: `--guide DIR`, `--quads N` and their settings."""

from __future__ import annotations

import argparse
import dataclasses
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np

from ... import core
from ..jobs import detect
from . import steering, topology
from .arguments import values
from .batch.names import result_name
from .files.guard import Guard

_USUAL = ("mesh", "rosy", "sharp", "sing", "json")
_RIDGES = ("ridges", "ridge_figures")


@dataclasses.dataclass(frozen=True)
class GuidanceRequest:
    """Which files to write of every mesh, where, how to plan and how to remesh."""

    folder: Path
    kinds: tuple[str, ...]
    settings: core.GuidanceSettings
    remeshing: core.RemeshSettings

    @property
    def makes_quads(self) -> bool:
        return any(kind in core.QUAD_KINDS for kind in self.kinds)

    def stem(self, file: str | None, object_name: str, frame: int | None) -> Path:
        """The path of a mesh's files, without their endings."""
        name = object_name if file is None else Path(file).stem
        if file is not None and object_name != name:
            name = f"{name}-{object_name}"
        name = "".join("_" if letter in '/\\:*?"<>|' else letter for letter in name)
        name = result_name(name)
        return self.folder / (name if frame is None else f"{name}.{frame:04d}")

    def claim_file(self, guard: Guard, file: str, frames: Iterable[int]) -> None:
        """Claim the files of the mesh that is called like its file, before any is opened.

        Raises
        ------
        OverwriteError
            They would overwrite something.
        """
        self.claim(guard, file, [Path(file).stem], frames)

    def claim(
        self, guard: Guard, file: str | None, object_names: Iterable[str], frames: Iterable[int]
    ) -> None:
        """Claim the files of some objects; otherwise as `claim_file`."""
        for name in object_names:
            for frame in tuple(frames) or (None,):
                for path in core.guidance_paths(self.stem(file, name, frame), self.kinds):
                    guard.writes(path)


def add_arguments(
    parser: argparse.ArgumentParser,
    add_setting: Callable[[argparse._ArgumentGroup, str, core.Option, Any], None],
) -> None:
    """Add the options; `add_setting` adds one to a group by name, option and default."""
    group = parser.add_argument_group(
        "retopology",
        "With --guide a cross field, its poles and lines are written for remeshers, with --quads "
        "a mesh of quads alone.",
    )
    group.add_argument(
        "--guide",
        metavar="DIR",
        type=values.place,
        help="write DIR/FILE-OBJECT.rosy and the like; with --out in DIR/FILE/",
    )
    group.add_argument(
        "--guide-files",
        metavar="KIND",
        nargs="+",
        choices=tuple(core.FILE_KINDS),
        help=f"which: {', '.join(core.FILE_KINDS)} (default: {' '.join(_USUAL)})",
    )
    group.add_argument(
        "--ridges",
        action="store_true",
        help="with --guide or --out: write the ridges and their figures too",
    )
    group.add_argument(
        "--check-topology",
        metavar="MESH",
        type=values.path,
        help="hold the quads of the file MESH against the surface of FILE and its plan: numbers in "
        "the JSON; of a folder MESH the mesh that is called like FILE, and without FILE the "
        "object MESH of the open file",
    )
    steering.add_arguments(group, add_setting)
    for name, option in core.options(core.GuidanceSettings).items():
        add_setting(group, name, option, core.defaults(core.GuidanceSettings)[name])
    group = parser.add_argument_group(
        "quads",
        "Written as FILE-OBJECT-quads.obj where --guide says, or with --out alone in "
        "OUT/FILE/; --guide-files quads_ply has valence, patch and angle too.",
    )
    group.add_argument(
        "--quads",
        metavar="N",
        type=values.whole_number,
        help="remesh each mesh to about N quads along its curvature",
    )
    for name, option in core.options(core.RemeshSettings).items():
        if name != "quads":
            default = core.defaults(core.RemeshSettings)[name]
            add_setting(group, quad_setting(name), option, default)


def quad_setting(name: str) -> str:
    """What a setting of the remeshing is called here, where others may have its name."""
    taken = core.options().keys() | core.options(core.GuidanceSettings).keys()
    return f"quad_{name}" if name in taken else name


def settings_of(
    parser: argparse.ArgumentParser, found: argparse.Namespace
) -> core.GuidanceSettings:
    """How to plan, whatever the plan is for."""
    given = {name: getattr(found, name) for name in core.options(core.GuidanceSettings)}
    return values.settings(parser, core.GuidanceSettings, given)


def request_of(
    parser: argparse.ArgumentParser, found: argparse.Namespace, settings: core.GuidanceSettings
) -> GuidanceRequest | None:
    """What the arguments ask for; None without --guide and --quads."""
    folder = found.guide or found.out
    if folder is None and found.quads is not None:
        parser.error("--quads needs a folder that the quads go to: --guide DIR, or --out DIR.")
    if folder is None and found.ridges:
        parser.error("--ridges needs a folder that the files go to: --guide DIR, or --out DIR.")
    if found.guide is None and found.quads is None and not found.ridges:
        return None
    if folder.exists() and not folder.is_dir():
        parser.error(f"{'--guide' if found.guide else '--out'} {folder} is a file; name a folder.")
    quads = {
        name: getattr(found, quad_setting(name))
        for name in core.options(core.RemeshSettings)
        if name != "quads" or found.quads is not None
    }
    remeshing = values.settings(parser, core.RemeshSettings, quads, quad_setting)
    kinds = list(found.guide_files or (_USUAL if found.guide else ()))
    kinds += _RIDGES if found.ridges else ()
    if found.quads is not None and not any(kind in core.QUAD_KINDS for kind in kinds):
        kinds.append(core.QUAD_KINDS[0])
    return GuidanceRequest(folder, tuple(dict.fromkeys(kinds)), settings, remeshing)


def worker_arguments(request: GuidanceRequest, words_of: Callable[..., list[str]]) -> list[str]:
    """What gives another process the same files; `words_of` tells settings by their options."""
    arguments = ["--guide-files", *request.kinds]
    if request.makes_quads:
        arguments += words_of(core.options(core.RemeshSettings), request.remeshing, quad_setting)
    return arguments


def write(
    request: GuidanceRequest,
    stem: Path,
    inputs: detect.Inputs,
    guide: core.Guide,
    by_hand: steering.ByHand,
    to_file: np.ndarray,
    progress: core.Progress,
) -> tuple[list[str], dict[str, Any]]:
    """Write the files of one mesh; sentences on what was written and what there is not, and
    what the report says of the plan and the quads.

    Raises
    ------
    core.UmbilicsError
        A file cannot be written.
    """
    arrays = inputs.arrays
    found = core.export_guidance(
        stem,
        request.kinds,
        guide,
        request.settings,
        mesh=(arrays.vertices, arrays.triangles),
        sharp=arrays.sharp,
        strokes=by_hand.strokes,
        wanted=by_hand.wanted,
        to_file=to_file,
        remeshing=request.remeshing,
        progress=progress,
    )
    poles = found.guidance.poles
    three = int(np.count_nonzero(poles.valence == 3))
    five = len(poles) - three
    warnings = [*found.left_out, *found.guidance.warnings]
    said = [
        f"Poles: {three} of valence 3, {five} of valence 5. "
        f"Wrote {', '.join(path.name for path in found.paths)}.",
        *warnings,
    ]
    plan = {"valence_3": three, "valence_5": five, "warnings": warnings}
    facts = {"plan": plan} | steering.facts(by_hand, found.guidance.warnings)
    if found.quads is None or found.check is None:
        return said, facts
    said += [topology.in_words(found.check), *found.quads.warnings]
    quads = topology.of_quads(found.quads, found.check, request.remeshing)
    return said, facts | {"quads": quads}
