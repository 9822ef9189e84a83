"""One file: detect on every wanted mesh of it and write its results."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import bpy

from ... import core
from ..base.errors import FileError
from ..base.words import outcome
from ..data import properties
from ..jobs import detect
from ..mesh.evaluated import is_in
from ..scene import display_objects
from . import frames, guidance, matching, messages, report, shares, steering, topology
from .arguments.request import Request
from .files import beside, blend_file, importers, mesh_file
from .files.guard import shown
from .messages import complain
from .pictures import panels, picture


@dataclasses.dataclass
class _Frame:
    """What has been found at one frame, or in the file as it is."""

    number: int | None
    done: list[tuple[detect.Inputs, core.Detection]] = dataclasses.field(default_factory=list)
    checked: topology.Checked | None = None
    steering: core.Steering | None = None
    compared: list[tuple[detect.Inputs, tuple[core.MethodResult, ...]]] = dataclasses.field(
        default_factory=list
    )


def analyse(
    request: Request,
    file: str | None,
    opened: importers.Opened,
    outputs: dict[str, Path],
    checked: topology.Checked | None = None,
    references: Sequence[matching.Reference] = (),
) -> bool:
    """Do what is asked for with an opened file; whether all went well. The `references` are what
    its meshes are to be brought onto.

    `checked` is the mesh of another file that is held against its surfaces.

    Raises
    ------
    core.UmbilicsError
        The file holds no mesh that is wanted, a result would overwrite something or cannot be
        written, or the command is to stop (`core.CancelledError`).
    """
    others = beside.files_beside(file)
    source = report.source_of(file, others)
    request.guard.reads(others)
    wanted = [obj.name for obj in _wanted(opened.objects, request, file)]
    _claim_guidance(request, file, wanted)
    steered = steering.read(request.steering, file)
    steering.check(steered, wanted, file or "The scene")
    properties.from_settings(bpy.context.scene.umbilics, request.settings)
    display = bpy.context.scene.umbilics_display
    display.source, display.scope = request.source.reading.source, request.source.scope.kind
    display.scope_group = request.source.scope.group
    entries = []
    for number in request.frames or (None,):
        if number is not None:
            bpy.context.scene.frame_set(number)
        found = _Frame(number, steering=steered)
        if request.check is not None and file is None:
            checked = topology.from_object(request.check)
        found.checked = checked
        for name in wanted:
            is_kept = "blend" in outputs
            entries.append(_one_object(request, file, opened, name, found, is_kept, references))
        if found.done:
            _write(found, opened, outputs)
    if any("error" not in entry for entry in entries) and "json" in outputs:
        # Last: where it is, all the other results are.
        report.write(outputs["json"], request.every_setting(), source, entries)
    return all("error" not in entry for entry in entries)


def _one_object(
    request: Request,
    file: str | None,
    opened: importers.Opened,
    name: str,
    found: _Frame,
    is_kept: bool,
    references: Sequence[matching.Reference],
) -> dict[str, Any]:
    """Detect on one mesh; its entry in the report."""
    label = shown(name) if file is None else f"{shown(file)}: {shown(name)}"
    if found.number is not None:
        label += f", frame {found.number}"
    told = None if file is None else shown(file)
    about: dict[str, Any] = {"file": told, "object": name}
    about |= {} if found.number is None else {"frame": found.number}
    progress = _progress(request, about)
    try:
        parts = shares.Parts(_works(request, found), progress)
        inputs, detection, results = _detected(request, name, found.number, parts, is_kept)
        stem = None
        if request.guidance is not None:
            stem = request.guidance.stem(file, name, found.number)
        said, facts = _guided(request, stem, found, inputs, detection, opened, parts)
        if request.matching is not None:
            part = parts.begin("Matching")
            sentences, matches = matching.write(
                request.matching, references, inputs, detection, opened.to_file, part
            )
            said += sentences
            facts |= matches
    except core.CancelledError:
        if request.stop.asked():
            raise
        error = f"given up after {request.limits.seconds:g} s (--time-limit)."
    except core.UmbilicsError as reason:
        error = str(reason) or f"stopped without a word ({type(reason).__name__})."
        error = " ".join([error, *opened.warnings])
    else:
        found.done.append((inputs, detection))
        if results:
            found.compared.append((inputs, results))
        entry = report.success(about, inputs, detection, opened.to_file, request.per_vertex)
        entry |= facts
        entry["warnings"] = [*opened.warnings, *entry["warnings"]]
        if results:
            entry["comparison"] = report.comparison(results, opened.to_file)
        if request.events:
            news = {key: entry[key] for key in ("counts", "index_sum", "warnings")}
            messages.tell("object", **about, **news)
        else:
            _say(label, detection, [*opened.warnings, *detection.warnings, *said], results)
        return entry
    complain(f"{label}: {error}")
    if request.events:
        messages.tell("object", **about, error=error)
    return about | {"error": error}


def _works(request: Request, found: _Frame) -> list[str]:
    """What is done with each mesh, in this order."""
    asked = {
        "Detecting": True,
        "Planning": request.guidance is not None,
        "Checking": found.checked is not None,
        "Matching": request.matching is not None,
    }
    return [work for work, is_asked in asked.items() if is_asked]


def _progress(request: Request, about: dict[str, Any]) -> core.Progress:
    """Stops at a signal or at the limit; tells of itself what is `about` it, where lines are."""
    seconds = request.limits.seconds
    return messages.progress_until(
        None if seconds is None else time.monotonic() + seconds,
        request.stop,
        messages.Watched(about) if request.events else None,
    )


def _detected(
    request: Request, name: str, frame: int | None, parts: shares.Parts, is_kept: bool
) -> tuple[detect.Inputs, core.Detection, tuple[core.MethodResult, ...]]:
    """Read one mesh and detect on it."""
    context = bpy.context
    source = request.source
    depsgraph = context.evaluated_depsgraph_get() if source.evaluated else None
    obj = context.scene.objects[name]
    inputs = detect.gather(
        obj, request.settings, request.given_names, request.compare, depsgraph, source.scope
    )
    part = parts.begin("Detecting")
    results = detect.compare(inputs, part) if request.compare else ()
    detection = results[0].detection if results else detect.compute(inputs, part)
    assert detection is not None, "method S, the first, refuses nothing"
    if is_kept or frame is None:
        detect.write(context, inputs, detect.results_of(inputs, detection))
    return inputs, detection, results


def _guided(
    request: Request,
    stem: Path | None,
    found: _Frame,
    inputs: detect.Inputs,
    detection: core.Detection,
    opened: importers.Opened,
    parts: shares.Parts,
) -> tuple[list[str], dict[str, Any]]:
    """The guidance's files, named after `stem`, and the check, as far as they are asked for;
    sentences on them and what the report says."""
    said: list[str] = []
    facts: dict[str, Any] = {}
    checked = found.checked
    if request.guidance is None and checked is None:
        return said, facts
    arrays = inputs.arrays
    by_hand = steering.for_mesh(found.steering, request.steering, arrays.vertices, opened.to_file)
    guide = core.Guide(arrays.vertices, arrays.triangles, detection)
    if request.guidance is not None and stem is not None:
        part = parts.begin("Planning")
        said, facts = guidance.write(
            request.guidance, stem, inputs, guide, by_hand, opened.to_file, part
        )
    if checked is not None:
        part = parts.begin("Checking")
        more, check = topology.check(
            checked, guide, request.planning, arrays.sharp, by_hand, opened.to_file, part
        )
        said, facts = said + more, facts | check
    return said, facts


def _say(
    label: str, detection: core.Detection, said: list[str], results: tuple[core.MethodResult, ...]
) -> None:
    lines = [f"{label}: {outcome(detection)}."]
    lines += [f"  {sentence}" for sentence in said]
    lines += [core.comparison_table(results)] if results else []
    messages.say("\n".join(lines) + "\n")


def _claim_guidance(request: Request, file: str | None, names: list[str]) -> None:
    """Claim the files of the guidance, now that the objects are known."""
    if request.guidance is None:
        return
    if file is not None and not request.is_worker:
        # Claimed when the arguments were read.
        names = [name for name in names if name != Path(file).stem]
    request.guidance.claim(request.guard, file, names, request.frames)


def _wanted(
    objects: list[bpy.types.Object], request: Request, file: str | None
) -> list[bpy.types.Object]:
    """The objects to analyse: those named, else all that have faces and can be seen."""
    where = shown(file or bpy.data.filepath or "The scene")
    by_name = {obj.name: obj for obj in objects}
    for name in request.objects:
        if name not in by_name:
            raise FileError(f"{where}: there is no mesh called {name}.")
    if request.objects:
        return [by_name[name] for name in dict.fromkeys(request.objects)]
    evaluated = request.source.evaluated
    # Modifiers may make the faces.
    solid = [obj for obj in objects if obj.data.polygons or (evaluated and obj.modifiers)]
    solid = [obj for obj in solid if not display_objects.is_ours(obj)]
    if file is None:
        # A mesh that is checked is no surface.
        solid = [obj for obj in solid if obj.name != request.check]
    if evaluated:
        layer = bpy.context.view_layer
        for obj in solid:
            if not is_in(layer, obj):
                complain(f"{where}: {obj.name} is left out: it is not in the view layer.")
        solid = [obj for obj in solid if is_in(layer, obj)]
    if not solid:
        what = "its meshes have no faces" if objects else "there is no mesh in it"
        raise FileError(f"{where}: {what}; curvature needs a surface.")
    return solid


def _write(found: _Frame, opened: importers.Opened, outputs: dict[str, Path]) -> None:
    """Write what was found, but for the report."""
    places = {
        kind: path if found.number is None else frames.path_at(path, found.number)
        for kind, path in outputs.items()
    }
    if "blend" in places:
        blend_file.write(places["blend"])
    if "png" in places and found.compared:
        panels.write_comparison(places["png"], found.compared, opened.up)
    elif "png" in places:
        picture.write(places["png"], found.done, opened.up)
    if "ply" in places:
        mesh_file.write(places["ply"], found.done, opened.to_file)
    if "usda" in places:
        meshes = [
            core.UsdMesh(
                inputs.object_name,
                inputs.arrays.vertices,
                inputs.arrays.triangles,
                detection,
                opened.to_file,
            )
            for inputs, detection in found.done
        ]
        core.write_usda(places["usda"], meshes, opened.file_up, found.number)
