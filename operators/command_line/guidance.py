"""The command's part in retopology: `--guide DIR` and the settings of the guidance."""

from __future__ import annotations

import argparse
import dataclasses
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np

from ... import core
from ..jobs import detect
from .batch.names import result_name
from .guard import Guard

_USUAL = ("mesh", "rosy", "sharp", "sing", "json")
_RIDGES = ("ridges", "ridge_figures")


@dataclasses.dataclass(frozen=True)
class GuidanceRequest:
    """Which files to write of every mesh, where, and how to plan."""

    folder: Path
    kinds: tuple[str, ...]
    settings: core.GuidanceSettings

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
        "retopology", "With --guide a cross field, its poles and lines are written for remeshers."
    )
    group.add_argument(
        "--guide",
        metavar="DIR",
        type=Path,
        help="write DIR/FILE-OBJECT.rosy and the like; with --out in DIR/FILE/",
    )
    group.add_argument(
        "--guide-files",
        metavar="KIND",
        nargs="+",
        choices=tuple(core.FILE_KINDS),
        default=_USUAL,
        help=f"which: {', '.join(core.FILE_KINDS)} (default: {' '.join(_USUAL)})",
    )
    group.add_argument(
        "--ridges",
        action="store_true",
        help="with --guide: write the ridges and their figures too",
    )
    for name, option in core.options(core.GuidanceSettings).items():
        add_setting(group, name, option, core.defaults(core.GuidanceSettings)[name])


def request_of(
    parser: argparse.ArgumentParser, found: argparse.Namespace
) -> GuidanceRequest | None:
    """What the arguments ask for; None without --guide."""
    if found.guide is None:
        if found.ridges:
            parser.error("--ridges needs --guide DIR, the folder that the files go to.")
        return None
    if found.guide.exists() and not found.guide.is_dir():
        parser.error(f"--guide {found.guide} is a file; name a folder.")
    values = {name: getattr(found, name) for name in core.options(core.GuidanceSettings)}
    try:
        settings = core.GuidanceSettings(**values)
    except core.InvalidSettingsError as error:
        parser.error(str(error))
    ridges = _RIDGES if found.ridges else ()
    kinds = tuple(dict.fromkeys((*found.guide_files, *ridges)))
    return GuidanceRequest(found.guide, kinds, settings)


def write(
    request: GuidanceRequest,
    stem: Path,
    inputs: detect.Inputs,
    detection: core.Detection,
    to_file: np.ndarray,
    progress: core.Progress,
) -> list[str]:
    """Write the files of one mesh; sentences on what was written and what there is not.

    Raises
    ------
    core.UmbilicsError
        A file cannot be written.
    """
    arrays = inputs.arrays
    found = core.export_guidance(
        stem,
        request.kinds,
        core.Guide(arrays.vertices, arrays.triangles, detection),
        request.settings,
        mesh=(arrays.vertices, arrays.triangles),
        sharp=arrays.sharp,
        to_file=to_file,
        progress=progress,
    )
    poles = found.guidance.poles
    three = int(np.count_nonzero(poles.valence == 3))
    return [
        f"Poles: {three} of valence 3, {len(poles) - three} of valence 5. "
        f"Wrote {', '.join(path.name for path in found.paths)}.",
        *found.left_out,
    ]
