"""Single files, each in a process of its own, which is ended at a limit and may end by itself."""

from __future__ import annotations

import subprocess
import time
from pathlib import Path
from typing import Any

from ....core.formats.whole import PARTIAL
from .. import exit_codes
from ..arguments.request import Request
from ..files import damage
from ..files.guard import shown
from ..files.importers import SUFFIXES
from ..messages import STOPPED, complain, tell
from . import machine

_PAUSE = 0.05


def run(request: Request, blender: list[str]) -> int:
    """Do the files one after the other; the command's exit code."""
    failed = False
    for file, outputs in zip(request.files, request.outputs, strict=True):
        failed |= not _one_file(request, file, outputs, blender)
        if request.stop.asked():
            break
    return exit_codes.FAILED if failed else exit_codes.DONE


def _one_file(
    request: Request, file: str | None, outputs: dict[str, Any], blender: list[str]
) -> bool:
    name = None if file is None else shown(file)
    if file is not None and (why := damage.refusal(file, SUFFIXES)):
        if request.events:
            tell("start", file=name)
        _fail(request, name, f"{why}.", 0.0)
        return False
    command = [*blender, *request.worker_arguments, "--worker"]
    command += [f"--{kind}={path}" for kind, path in outputs.items()]
    if request.guidance:
        command.append(f"--guide={request.guidance.folder}")
    if request.events:
        command.append("--progress=jsonl")
    command += [] if file is None else ["--", file]
    start = time.monotonic()
    number, code, memory = _end_of(command, request)
    if code in (exit_codes.DONE, exit_codes.FAILED):
        # It has said all that there is to say.
        return code == exit_codes.DONE
    _remove_partial(request, outputs, number)
    if request.stop.asked():
        error = STOPPED
    elif code is None:
        error = f"given up after {request.limits.seconds:g} s (--time-limit)."
    elif memory.is_spent():
        error = f"{memory.lack()}."
    else:
        error = f"{machine.end_in_words(code)}."
    _fail(request, name, error, time.monotonic() - start)
    return False


def _fail(request: Request, name: str | None, error: str, seconds: float) -> None:
    """Say why a file is not done."""
    error = error if name is None else f"{name}: {error}"
    complain(error)
    if request.events:
        tell("file", file=name, status="failed", seconds=round(seconds, 3), error=error)


def _end_of(command: list[str], request: Request) -> tuple[int, int | None, machine.Memory]:
    """Run a process within the limits; its number, its exit code, None if it was ended, and its
    memory."""
    limits = request.limits
    process = subprocess.Popen(command, stdin=subprocess.PIPE)
    assert process.stdin is not None
    memory = machine.Memory(process.pid)
    if limits.memory:
        memory.limit(limits.memory)
    start = time.monotonic()
    try:
        while process.poll() is None:
            if request.stop.asked():
                return process.pid, None, memory
            if limits.seconds is not None and time.monotonic() - start > limits.seconds:
                return process.pid, None, memory
            memory.look()
            time.sleep(_PAUSE)
        return process.pid, process.returncode, memory
    finally:
        process.kill()
        process.wait()
        process.stdin.close()


def _remove_partial(request: Request, outputs: dict[str, Any], number: int) -> None:
    """Remove what a process that was ended had begun to write."""
    folders = {Path(path).parent for path in outputs.values()}
    folders |= {request.guidance.folder} if request.guidance else set()
    for folder in folders:
        for left in folder.glob(f"{PARTIAL}{number}-*"):
            left.unlink(missing_ok=True)
