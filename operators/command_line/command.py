"""The command: reads its arguments and does the files here, or has other processes do them."""

from __future__ import annotations

import sys
import time
import traceback
from pathlib import Path
from typing import Any

import bpy

from ... import core
from . import batch, exit_codes, matching, messages, one_file, topology, version
from .arguments import parser as arguments
from .arguments.request import Request
from .batch import lifetime, machine, supervised
from .files import importers
from .files.guard import shown


def run(argv: list[str]) -> int:
    """Do what the arguments say; the command's exit code."""
    messages.hold_streams()
    try:
        request = arguments.parse(argv)
    except SystemExit as stop:
        return int(stop.code or 0)
    if request.is_worker:
        lifetime.end_with_parent()
    with request.stop.heard():
        return _told(request)


def _told(request: Request) -> int:
    """Do it between the first and the last event; the exit code."""
    # A worker's lines stand between those of the process that started it.
    telling = request.events and not request.is_worker
    if telling:
        messages.tell("command", version=version.OURS, blender=bpy.app.version_string)
    code = _done(request)
    if telling:
        messages.tell("end", exit_code=code)
    return code


def _done(request: Request) -> int:
    base = bpy.data.filepath
    blender = [bpy.app.binary_path, *_quiet(), "-b", *([base] if base else [])]
    blender += ["--command", "umbilics"]
    try:
        if request.summary:
            return batch.summarize(*request.summary)
        if request.batch:
            return batch.run(request.batch, blender, request.stop)
        if _needs_processes(request) and (base or request.files != (None,)):
            code = supervised.run(request, blender)
            return exit_codes.INTERRUPTED if request.stop.asked() else code
    except batch.BusyError as error:
        messages.complain(str(error))
        return exit_codes.BUSY
    except OSError as error:
        messages.complain(f"{shown(error.filename)}: cannot be written ({error.strerror}).")
        return exit_codes.FAILED
    references: list[matching.Reference] = []
    if request.matching:
        try:
            progress = messages.progress_until(None, request.stop, None)
            references = matching.references(request.matching, request.settings, base, progress)
        except core.CancelledError:
            messages.complain(messages.STOPPED)
            return exit_codes.INTERRUPTED
        except core.UmbilicsError as error:
            messages.complain(str(error))
            return exit_codes.FAILED
    failed = False
    waiting = list(zip(request.files, request.outputs, strict=True))
    while waiting:
        failed |= not _one_file(request, *waiting.pop(0), base, references)
        if request.stop.asked() and (waiting or failed):
            return exit_codes.INTERRUPTED
    return exit_codes.FAILED if failed else exit_codes.DONE


def _quiet() -> list[str]:
    """The option by which a Blender that is started does not tell its version once more, where it
    has one."""
    # As a module Blender has no options, and ends where it is asked for them.
    is_known = bpy.app.binary_path and "--quiet" in bpy.app.help_text()
    return ["--quiet"] if is_known else []


def _needs_processes(request: Request) -> bool:
    """Whether each file is done in a process of its own, which may be ended or end by itself."""
    # As a module Blender has no program to start; then the work itself looks at the clock.
    if request.is_worker or not bpy.app.binary_path:
        return False
    files = [*request.files, *(request.matching.files if request.matching else ())]
    return bool(request.limits) or any(
        file is not None and Path(file).suffix.lower() in importers.UNCHECKED for file in files
    )


def _one_file(
    request: Request,
    file: str | None,
    outputs: dict[str, Any],
    base: str,
    references: list[matching.Reference],
) -> bool:
    """Do one file, so that the next ones are done whatever is in it; whether all went well."""
    label = "" if file is None else f"{shown(file)}: "
    start = time.monotonic()
    if request.events:
        messages.tell("start", file=None if file is None else shown(file))
    failure = ""
    try:
        # Before the file itself is opened: Blender has one file open at a time.
        checked = None
        if request.check is not None and file is not None:
            checked = topology.from_file(request.check, file)
        opened = importers.open_file(file, base)
        done = one_file.analyse(request, file, opened, outputs, checked, references)
    except core.CancelledError:
        failure = label + messages.STOPPED
    except core.UmbilicsError as error:
        failure = str(error) or f"{label}stopped without a word ({type(error).__name__})."
    except MemoryError:
        failure = f"{label}{machine.LACK}."
    except Exception as error:  # noqa: BLE001
        # Not foreseen: said in full for those who can mend it, and the other files go on.
        messages.say(traceback.format_exc(), sys.stderr)
        failure = f"{label}stopped by a fault of this program ({type(error).__name__}: {error})."
    if failure:
        messages.complain(failure)
        done = False
    if request.events:
        facts = {"error": failure} if failure else {}
        told = None if file is None else shown(file)
        seconds = round(time.monotonic() - start, 3)
        messages.tell(
            "file", file=told, status="done" if done else "failed", seconds=seconds, **facts
        )
    return done
