"""The command's part in retopology: `--guide DIR` and the settings of the guidance."""

from __future__ import annotations

import argparse
import dataclasses
from pathlib import Path

import numpy as np

from ... import core
from ..jobs import detect

_USUAL = ("mesh", "rosy", "sharp", "sing", "json")


@dataclasses.dataclass(frozen=True)
class GuidanceRequest:
    """Which files to write of every mesh, where, and how to plan."""

    folder: Path
    kinds: tuple[str, ...]
    settings: core.GuidanceSettings


def add_arguments(parser: argparse.ArgumentParser, add_setting) -> None:
    """Add the options; `add_setting` adds one to a group by name, option and default."""
    group = parser.add_argument_group(
        "retopology", "With --guide a cross field, its poles and lines are written for remeshers."
    )
    group.add_argument(
        "--guide", metavar="DIR", type=Path, help="write DIR/FILE-OBJECT.rosy and the like"
    )
    group.add_argument(
        "--guide-files",
        metavar="KIND",
        nargs="+",
        choices=tuple(core.FILE_KINDS),
        default=_USUAL,
        help=f"which: {', '.join(core.FILE_KINDS)} (default: {' '.join(_USUAL)})",
    )
    for name, option in core.options(core.GuidanceSettings).items():
        add_setting(group, name, option, core.defaults(core.GuidanceSettings)[name])


def request_of(
    parser: argparse.ArgumentParser, found: argparse.Namespace
) -> GuidanceRequest | None:
    """What the arguments ask for; None without --guide."""
    if found.guide is None:
        return None
    if found.guide.is_file():
        parser.error(f"--guide {found.guide} is a file; name a folder.")
    values = {name: getattr(found, name) for name in core.options(core.GuidanceSettings)}
    try:
        settings = core.GuidanceSettings(**values)
    except core.InvalidSettingsError as error:
        parser.error(str(error))
    return GuidanceRequest(found.guide, tuple(found.guide_files), settings)


def write(
    request: GuidanceRequest,
    file: str | None,
    inputs: detect.Inputs,
    detection: core.Detection,
    to_file: np.ndarray,
) -> list[str]:
    """Write the files of one mesh; sentences on what was written and what there is not.

    Raises
    ------
    core.UmbilicsError
        A file cannot be written.
    """
    arrays = inputs.arrays
    guide = core.Guide(arrays.vertices, arrays.triangles, detection)
    guidance = guide.guidance(request.settings, sharp=arrays.sharp)
    kinds, said = list(request.kinds), []
    lines = None
    if "lines" in kinds:
        try:
            lines = guide.lines(request.settings)
        except core.GuidanceError as error:
            kinds.remove("lines")
            said.append(str(error))
    arcs = guide.separatrices(request.settings) if "separatrices" in kinds else None
    data = core.Exported(arrays.vertices, arrays.triangles, guide, guidance, lines, arcs)
    name = inputs.object_name if file is None else Path(file).stem
    if file is not None and inputs.object_name != name:
        name = f"{name}-{inputs.object_name}"
    name = "".join("_" if letter in '/\\:*?"<>|' else letter for letter in name)
    written = core.write_guidance(request.folder / name, kinds, data, to_file)
    poles = guidance.poles
    three = int(np.count_nonzero(poles.valence == 3))
    said.insert(
        0,
        f"Poles: {three} of valence 3, {len(poles) - three} of valence 5. "
        f"Wrote {', '.join(path.name for path in written)}.",
    )
    return said
