"""--align-to and --find-symmetry: which shape a mesh is, where it lies on it, and its symmetry."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ... import core
from ..data.properties import GIVEN_NAMES
from ..jobs import detect
from ..jobs.matching import shape_of
from .arguments import values
from .files import companions, importers
from .files.guard import shown


@dataclass(frozen=True)
class MatchingRequest:
    """What is asked for.

    Attributes
    ----------
    files:
        With the meshes that those of each file are to be brought onto.
    scaled:
        Sizes may differ.
    symmetry:
        The mirror plane and the rotation axis of each mesh are asked for.
    """

    files: tuple[str, ...]
    scaled: bool
    symmetry: bool


@dataclass(frozen=True)
class Reference:
    """A mesh that others may be brought onto; `to_file` (3, 3) as in `importers.Opened`."""

    file: str
    object: str
    shape: core.Shape
    to_file: np.ndarray


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    group = parser.add_argument_group(
        "matching", "By umbilics that are the same points of two shapes, or of one and its image."
    )
    group.add_argument(
        "--align-to",
        metavar="MESH",
        type=values.path,
        action="append",
        default=[],
        help="say how each mesh lies on those of this file, and which of them it is; may be given "
        "several times",
    )
    group.add_argument(
        "--align-scaled",
        action="store_true",
        help="with --align-to: sizes may differ",
    )
    group.add_argument(
        "--find-symmetry",
        action="store_true",
        help="find the mirror plane and the rotation axis of each mesh",
    )


def request_of(
    parser: argparse.ArgumentParser, found: argparse.Namespace
) -> MatchingRequest | None:
    """What the arguments ask for; None without --align-to and --find-symmetry."""
    if found.align_scaled and not found.align_to:
        parser.error("--align-scaled needs --align-to MESH, the file to align to.")
    if found.align_to and not found.files:
        parser.error(
            "--align-to needs the FILE whose meshes are to be aligned; in the window there is "
            "Align to Other."
        )
    for file in found.align_to:
        if not Path(file).exists():
            parser.error(f"--align-to {file}: there is no such file.")
    if not found.align_to and not found.find_symmetry:
        return None
    return MatchingRequest(tuple(found.align_to), found.align_scaled, found.find_symmetry)


def worker_arguments(found: argparse.Namespace) -> list[str]:
    """What asks another process of this command for the same."""
    arguments = [f"--align-to={file}" for file in found.align_to]
    arguments += ["--align-scaled"] * found.align_scaled
    return arguments + ["--find-symmetry"] * found.find_symmetry


def identity_of(found: argparse.Namespace) -> tuple[tuple[str, int, int], ...]:
    """What tells the files from another state of them."""
    files = found.align_to
    return tuple(one for file in files for one in companions.identity_of(file, importers.SUFFIXES))


def references(
    request: MatchingRequest,
    settings: core.Settings,
    base: str,
    progress: core.Progress | None = None,
) -> list[Reference]:
    """The meshes to align to, detected on as all others.

    Raises
    ------
    core.UmbilicsError
        A file cannot be read, a mesh cannot be analysed, or the work is to stop.
    """
    found = []
    for file in request.files:
        opened = importers.open_file(file, base)
        for obj in opened.objects:
            if not len(obj.data.polygons):
                continue
            inputs = detect.gather(obj, settings, GIVEN_NAMES)
            shape = shape_of(inputs, detect.compute(inputs, progress))
            found.append(Reference(shown(file), obj.name, shape, opened.to_file))
    return found


def write(
    request: MatchingRequest,
    others: Sequence[Reference],
    inputs: detect.Inputs,
    detection: core.Detection,
    to_file: np.ndarray,
    progress: core.Progress,
) -> tuple[list[str], dict[str, Any]]:
    """Sentences on what one mesh matches, and what the report says of it."""
    shape = shape_of(inputs, detection)
    said: list[str] = []
    facts: dict[str, Any] = {}
    if request.files:
        found = core.identify(shape, [one.shape for one in others], progress, scaled=request.scaled)
        facts["alignment"] = [
            _alignment(one, other, to_file) for one, other in zip(found, others, strict=True)
        ]
        said += _in_words(found, others, shape.size)
    if request.symmetry:
        facts["symmetry"], sentences = _symmetry(inputs, detection, shape, to_file, progress)
        said += sentences
    return said, facts


def _alignment(one: core.Alignment | None, other: Reference, to_file: np.ndarray) -> dict[str, Any]:
    entry: dict[str, Any] = {"file": other.file, "object": other.object, "same": one is not None}
    if one is None:
        return entry
    before, after = np.eye(4), np.eye(4)
    before[:3, :3], after[:3, :3] = to_file.T, other.to_file
    return entry | {
        "score": one.score,
        "overlap": one.overlap,
        "error": one.error,
        "scale": one.scale,
        "rotation_error": one.rotation_error,
        "shift_error": one.shift_error,
        "matched": len(one.pairs),
        "matrix": after @ one.matrix @ before,
    }


def _in_words(
    found: list[core.Alignment | None], others: Sequence[Reference], size: float
) -> list[str]:
    same = [(one, other) for one, other in zip(found, others, strict=True) if one is not None]
    if not same:
        return ["It is none of the meshes to align to."]
    one, other = max(same, key=lambda pair: pair[0].score)
    scaled = f", scaled {one.scale:.4g} times" if one.scale != 1.0 else ""
    return [
        f"It is {other.object} of {other.file}{scaled}: {100.0 * one.overlap:.0f} % overlap, "
        f"{100.0 * one.error / (one.scale * size):.2g} % of its size apart, direction good to "
        f"{one.rotation_error:.1g}°."
    ]


def _symmetry(
    inputs: detect.Inputs,
    detection: core.Detection,
    shape: core.Shape,
    to_file: np.ndarray,
    progress: core.Progress,
) -> tuple[dict[str, Any], list[str]]:
    arrays = inputs.arrays
    entry: dict[str, Any] = {"mirror": None, "rotation": None}
    said = []
    try:
        plane = core.Guide(arrays.vertices, arrays.triangles, detection).symmetry(progress)
        entry["mirror"] = {
            "point": to_file @ plane.point,
            "normal": to_file @ plane.normal,
            "error": plane.error,
            "angle_error": plane.angle_error,
            "offset_error": plane.offset_error,
            "score": plane.score,
            "matched": len(plane.pairs),
        }
        said.append(f"Mirror plane: the image lies {plane.error:.3g} away from the shape.")
    except core.GuidanceError as error:
        said.append(f"No mirror plane: {_without(str(error))}")
    try:
        turn = core.find_rotation(shape, progress)
        entry["rotation"] = {
            "point": to_file @ turn.point,
            "axis": to_file @ turn.axis,
            "order": turn.order,
            "error": turn.error,
            "axis_error": turn.axis_error,
            "score": turn.score,
            "matched": len(turn.pairs),
        }
        said.append(
            f"Rotation symmetry of order {turn.order}: the image lies {turn.error:.3g} away from "
            "the shape."
        )
    except core.MatchError as error:
        said.append(f"No rotation axis: {error}")
    return entry, said


def _without(text: str) -> str:
    """The error of the mirror plane without the words that start it."""
    return text.removeprefix("No mirror plane: ")
