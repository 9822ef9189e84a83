"""One run of the command: open, detect, write, for each file in turn."""

from __future__ import annotations

import sys

import bpy

from ... import core
from ..base.errors import FileError
from ..base.words import outcome
from ..data import properties
from ..jobs import detect
from . import arguments, batch, guidance, importers, mesh_file, panels, picture, report

DONE, FAILED = 0, 1


def run(argv: list[str]) -> int:
    """Do what the arguments say; the command's exit code."""
    try:
        request = arguments.parse(argv)
    except SystemExit as stop:
        return int(stop.code or 0)
    base = bpy.data.filepath
    if request.batch or request.summary:
        return _many(request, base)
    failed = False
    for file, outputs in zip(request.files, request.outputs, strict=True):
        try:
            failed |= not _one_file(request, file, base, outputs)
        except core.UmbilicsError as error:
            _complain(str(error))
            failed = True
    return FAILED if failed else DONE


def _many(request: arguments.Request, base: str) -> int:
    """Do a batch with other processes of this Blender; the command's exit code."""
    blender = [bpy.app.binary_path, "-b", *([base] if base else []), "--command", "umbilics"]
    try:
        if request.summary:
            return batch.summarize(*request.summary)
        return batch.run(request.batch, blender)
    except OSError as error:
        _complain(f"{error.filename}: {error.strerror}.")
        return FAILED


def _one_file(request: arguments.Request, file: str | None, base: str, outputs: dict) -> bool:
    """Detect on every wanted mesh of a file and write its results; whether all went well."""
    opened = importers.open_file(file, base)
    scene = bpy.context.scene
    properties.from_settings(scene.umbilics, request.settings)
    entries, done, compared = [], [], []
    for obj in _wanted(opened.objects, request.objects, file):
        label = obj.name if file is None else f"{file}: {obj.name}"
        try:
            inputs = detect.gather(obj, request.settings, request.given_names, request.compare)
            results = detect.compare(inputs) if request.compare else ()
            detection = results[0].detection if results else detect.compute(inputs)
            detect.write(bpy.context, inputs, detect.found(inputs, detection))
            said = []
            if request.guidance is not None:
                said = guidance.write(request.guidance, file, inputs, detection, opened.to_file)
        except core.UmbilicsError as error:
            _complain(f"{label}: {error}")
            entries.append(report.failure(file, obj.name, str(error)))
            continue
        print(f"{label}: {outcome(detection)}.", flush=True)
        for warning in detection.warnings:
            print(f"  {warning}", flush=True)
        for sentence in said:
            print(f"  {sentence}", flush=True)
        if results:
            print(core.comparison_table(results), flush=True)
            compared.append((inputs, results))
        done.append((inputs, detection))
        entry = report.success(file, inputs, detection, opened.to_file, request.per_vertex)
        if results:
            entry["comparison"] = report.comparison(results, opened.to_file)
        entries.append(entry)
    if done:
        if "json" in outputs:
            report.write(outputs["json"], request.settings, entries)
        if "blend" in outputs:
            _save(outputs["blend"])
        if "png" in outputs and compared:
            panels.write_comparison(outputs["png"], compared, opened.up)
        elif "png" in outputs:
            picture.write(outputs["png"], done, opened.up)
        if "ply" in outputs:
            mesh_file.write(outputs["ply"], done, opened.to_file)
    return len(done) == len(entries)


def _wanted(
    objects: list[bpy.types.Object], names: tuple[str, ...], file: str | None
) -> list[bpy.types.Object]:
    """The objects to analyse: those named, else all that have faces."""
    where = file or bpy.data.filepath or "The scene"
    by_name = {obj.name: obj for obj in objects}
    for name in names:
        if name not in by_name:
            raise FileError(f"{where}: there is no mesh called {name}.")
    if names:
        return [by_name[name] for name in names]
    solid = [obj for obj in objects if obj.data.polygons]
    if not solid:
        what = "its meshes have no faces" if objects else "there is no mesh in it"
        raise FileError(f"{where}: {what}; curvature needs a surface.")
    return solid


def _save(path) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with importers.quiet():
            bpy.ops.wm.save_as_mainfile(filepath=str(path.resolve()), copy=True, compress=True)
    except (OSError, RuntimeError) as error:
        raise FileError(f"{path}: cannot be written ({str(error).strip()}).") from error


def _complain(text: str) -> None:
    print(f"umbilics: {text}", file=sys.stderr, flush=True)
